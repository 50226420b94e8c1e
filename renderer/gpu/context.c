/* Choosing a context and loading OpenGL through it.
 *
 * eglGetProcAddress answers for names it does not know, so the version is checked after binding and before
 * any other function is trusted. Nothing is current after any function here but vr_context_bind. */
#include "context.h"

#include <stdio.h>
#include <stdlib.h>

#define MIN_VERSION 43

static int load(struct vr_context *c, struct brick_error *err)
{
    /* POSIX, not C, lets an object pointer hold a function's address; copying it keeps the compiler quiet. */
#define LOAD(type, symbol)                                                                                   \
    {                                                                                                        \
        union {                                                                                              \
            void *object;                                                                                    \
            type function;                                                                                   \
        } address = {c->backend->get_proc(c->native, "gl" #symbol)};                                         \
        c->gl.symbol = address.function;                                                                     \
        if (!c->gl.symbol)                                                                                   \
            return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s has no function gl" #symbol,                   \
                              c->backend->name);                                                             \
    }
    VR_GL_FUNCTIONS(LOAD)
#undef LOAD
    return BRICK_OK;
}

static int inspect(struct vr_context *c, struct brick_error *err)
{
    GLint major = 0, minor = 0, elements = 0;
    const GLubyte *renderer = c->gl.GetString(GL_RENDERER);
    c->gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    c->gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    c->version = 10 * major + minor;
    snprintf(c->renderer, sizeof c->renderer, "%s", renderer ? (const char *)renderer : "unknown");
    if (c->version < MIN_VERSION)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s gives OpenGL %d.%d (%s); 4.3 core is needed",
                          c->backend->name, (int)major, (int)minor, c->renderer);
    c->gl.GetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &c->max_texture_3d);
    c->gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &c->max_layers);
    c->gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &c->max_texture_2d);
    c->gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &elements);
    c->max_buffer_elements = elements;
    return BRICK_OK;
}

static int create_with(struct vr_context **out, const struct vr_context_backend *backend,
                       struct brick_error *err)
{
    int result;
    struct vr_context *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!c)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a context");
    c->backend = backend;
    if ((result = backend->create(&c->native, err)) || (result = backend->bind(c->native, err)))
        goto fail;
    if ((result = load(c, err)) || (result = inspect(c, err))) {
        backend->unbind(c->native);
        goto fail;
    }
    backend->unbind(c->native);
    *out = c;
    return BRICK_OK;
fail:
    vr_context_destroy(&c);
    return result;
}

int vr_context_create(struct vr_context **context, enum vr_context_kind kind, struct brick_error *err)
{
    struct brick_error egl = {0}, osmesa = {0};
    if (kind == VR_CONTEXT_EGL)
        return create_with(context, &vr_context_egl, err);
    if (kind == VR_CONTEXT_OSMESA)
        return create_with(context, &vr_context_osmesa, err);
    if (create_with(context, &vr_context_egl, &egl) == BRICK_OK ||
        create_with(context, &vr_context_osmesa, &osmesa) == BRICK_OK)
        return BRICK_OK;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "no OpenGL context: %.280s; %.280s", egl.message,
                      osmesa.message);
}

void vr_context_destroy(struct vr_context **context)
{
    if (*context) {
        if ((*context)->native)
            (*context)->backend->destroy(&(*context)->native);
        free(*context);
    }
    *context = NULL;
}

int vr_context_bind(struct vr_context *context, struct brick_error *err)
{
    return context->backend->bind(context->native, err);
}

void vr_context_unbind(struct vr_context *context)
{
    context->backend->unbind(context->native);
}

int vr_context_check(struct vr_context *context, const char *doing, struct brick_error *err)
{
    GLenum code = context->gl.GetError();
    if (code == GL_NO_ERROR)
        return BRICK_OK;
    if (code == GL_OUT_OF_MEMORY)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: OpenGL (%s) is out of memory", doing,
                          context->renderer);
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: OpenGL (%s) reports error 0x%04x", doing,
                      context->renderer, (unsigned)code);
}
