/* Every OpenGL entry point this library calls: one list, from which the table and its loader are made.
 * Pointers come from the context's own get-proc-address; nothing is linked to a GL library. */
#ifndef RENDERER_GPU_FUNCTIONS_H
#define RENDERER_GPU_FUNCTIONS_H

#include <GL/glcorearb.h>

#define VR_GL_FUNCTIONS(X)                                                                                   \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                                 \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                                   \
    X(PFNGLBEGINQUERYPROC, BeginQuery)                                                                       \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                       \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                             \
    X(PFNGLBINDIMAGETEXTUREPROC, BindImageTexture)                                                           \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                                                     \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                             \
    X(PFNGLBLENDEQUATIONPROC, BlendEquation)                                                                 \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                                                         \
    X(PFNGLBUFFERDATAPROC, BufferData)                                                                       \
    X(PFNGLBUFFERSUBDATAPROC, BufferSubData)                                                                 \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                               \
    X(PFNGLCLEARBUFFERSUBDATAPROC, ClearBufferSubData)                                                       \
    X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                                                                 \
    X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv)                                                               \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                                 \
    X(PFNGLCOPYIMAGESUBDATAPROC, CopyImageSubData)                                                           \
    X(PFNGLCULLFACEPROC, CullFace)                                                                           \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                                 \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                                   \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                                 \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                                       \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                                 \
    X(PFNGLDELETEQUERIESPROC, DeleteQueries)                                                                 \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                                   \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                               \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                                       \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                                                         \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                                                         \
    X(PFNGLDISABLEPROC, Disable)                                                                             \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                       \
    X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                                                                     \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                                                                   \
    X(PFNGLENABLEPROC, Enable)                                                                               \
    X(PFNGLENDQUERYPROC, EndQuery)                                                                           \
    X(PFNGLFINISHPROC, Finish)                                                                               \
    X(PFNGLFLUSHPROC, Flush)                                                                                 \
    X(PFNGLFRAMEBUFFERPARAMETERIPROC, FramebufferParameteri)                                                 \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                                                   \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                                                       \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                             \
    X(PFNGLGENQUERIESPROC, GenQueries)                                                                       \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                                                     \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                             \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)                                                           \
    X(PFNGLGETERRORPROC, GetError)                                                                           \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                                                     \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                         \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                                   \
    X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                                                     \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                           \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                     \
    X(PFNGLGETSTRINGPROC, GetString)                                                                         \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                       \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                     \
    X(PFNGLMAPBUFFERRANGEPROC, MapBufferRange)                                                               \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                                                 \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                                     \
    X(PFNGLREADBUFFERPROC, ReadBuffer)                                                                       \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                                                       \
    X(PFNGLSCISSORPROC, Scissor)                                                                             \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                                   \
    X(PFNGLTEXBUFFERPROC, TexBuffer)                                                                         \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                                 \
    X(PFNGLTEXSTORAGE2DPROC, TexStorage2D)                                                                   \
    X(PFNGLTEXSTORAGE3DPROC, TexStorage3D)                                                                   \
    X(PFNGLTEXSUBIMAGE3DPROC, TexSubImage3D)                                                                 \
    X(PFNGLUNIFORM1DPROC, Uniform1d)                                                                         \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                         \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                                                         \
    X(PFNGLUNIFORM1UIPROC, Uniform1ui)                                                                       \
    X(PFNGLUNIFORM2FPROC, Uniform2f)                                                                         \
    X(PFNGLUNIFORM2IPROC, Uniform2i)                                                                         \
    X(PFNGLUNIFORM3DVPROC, Uniform3dv)                                                                       \
    X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                                                       \
    X(PFNGLUNIFORM3IVPROC, Uniform3iv)                                                                       \
    X(PFNGLUNIFORM4DVPROC, Uniform4dv)                                                                       \
    X(PFNGLUNIFORM4FVPROC, Uniform4fv)                                                                       \
    X(PFNGLUNIFORMMATRIX3DVPROC, UniformMatrix3dv)                                                           \
    X(PFNGLUNIFORMMATRIX3FVPROC, UniformMatrix3fv)                                                           \
    X(PFNGLUNMAPBUFFERPROC, UnmapBuffer)                                                                     \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                       \
    X(PFNGLVIEWPORTPROC, Viewport)

struct vr_gl {
#define VR_GL_MEMBER(type, name) type name;
    VR_GL_FUNCTIONS(VR_GL_MEMBER)
#undef VR_GL_MEMBER
};

#endif
