/* A scene's meshes as rays see them: for each pixel of a part of the picture, how far the nearest triangle is
 * and its colour (Scharsach 2005: opaque geometry ends rays). */
#ifndef RENDERER_FRAME_MESHES_H
#define RENDERER_FRAME_MESHES_H

#include "buffer.h"

struct vr_frame;
struct vr_uniforms;

struct vr_mesh_buffers {
    struct vr_buffer positions, triangles, normals, colours;
    double low_mm[3], high_mm[3]; /* bounds */
};

/* What stays from picture to picture. A layer of zeros is empty. */
struct vr_mesh_layer {
    struct vr_mesh_buffers mesh[VR_MAX_MESHES];
    uint64_t number; /* the scene's of those in the buffers; 0: none */
    int width, height;
    GLuint way, colour,
        depth; /* GL_RG32UI: a double's bits, infinity where no mesh is; GL_RGBA32F, premultiplied */
    GLuint framebuffer, vertex_array;
};

/* The context is bound in all of these. */

/* Take the frame's meshes, to be drawn in parts of width x height pixels. BRICK_ERR_MEMORY and _UNSUPPORTED
 * where OpenGL has no room for a mesh or a layer. */
int vr_meshes_begin(const struct vr_frame *frame, int width, int height, struct brick_error *err);
/* Draw the part that has the picture's pixel x, y at its corner. Another program is in use afterwards. */
int vr_meshes_draw(const struct vr_frame *frame, int x, int y, struct brick_error *err);
/* The last part, for ray.glsl and march.glsl. */
void vr_meshes_use(const struct vr_frame *frame, const struct vr_uniforms *u);
void vr_meshes_finish(struct vr_mesh_layer *layer, struct vr_context *context);

#endif
