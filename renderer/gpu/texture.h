/* Textures that hold a value for each pixel and are read as they are, unfiltered. */
#ifndef RENDERER_GPU_TEXTURE_H
#define RENDERER_GPU_TEXTURE_H

#include "context.h"

/* The context is bound in both. Errors are left to vr_context_check. */
GLuint vr_texture_create(struct vr_context *context, GLenum format, int width, int height);
/* Bind it to a unit. */
void vr_texture_use(struct vr_context *context, GLuint texture, GLuint unit);

#endif
