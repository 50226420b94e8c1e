/* An OpenGL 4.3 core context without a window, through EGL or OSMesa, both loaded at run time. */
#ifndef RENDERER_GPU_CONTEXT_H
#define RENDERER_GPU_CONTEXT_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/error.h>
#include <renderer/renderer.h>

#include "functions.h"

/* A way to have a context. `native` is its own state. */
struct vr_context_backend {
    const char *name;
    /* BRICK_ERR_UNSUPPORTED with what is missing and the package that has it. */
    int (*create)(void **native, struct brick_error *err);
    void (*destroy)(void **native);
    int (*bind)(void *native, struct brick_error *err); /* current in the calling thread */
    void (*unbind)(void *native);
    void *(*get_proc)(void *native, const char *name);
};
extern const struct vr_context_backend vr_context_egl, vr_context_osmesa;

struct vr_context {
    const struct vr_context_backend *backend;
    void *native;
    struct vr_gl gl; /* valid calls only between bind and unbind */
    int version;     /* 10 * major + minor */
    char renderer[128];
    int max_texture_3d, max_texture_2d, max_layers;
    int64_t max_buffer_elements;
};

/* The context is not current afterwards. VR_CONTEXT_AUTO takes EGL, else OSMesa. BRICK_ERR_UNSUPPORTED when
 * none can be had. */
int vr_context_create(struct vr_context **context, enum vr_context_kind kind, struct brick_error *err);
void vr_context_destroy(struct vr_context **context);

/* Does EGL know a device that is more than software? True where it does not tell. */
bool vr_context_has_gpu(void);

/* One context is current in a thread at a time: whoever binds unbinds before another does. */
int vr_context_bind(struct vr_context *context, struct brick_error *err);
void vr_context_unbind(struct vr_context *context);

/* BRICK_OK, or the pending OpenGL error as BRICK_ERR_MEMORY (out of memory) or BRICK_ERR_UNSUPPORTED; doing
 * says what was tried. */
int vr_context_check(struct vr_context *context, const char *doing, struct brick_error *err);

#endif
