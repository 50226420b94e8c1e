/* Pictures drawn with OpenGL, by the methods in methods/. */
#ifndef RENDERER_DRAWING_H
#define RENDERER_DRAWING_H

#include <renderer/renderer.h>

struct vr_drawing;
int vr_drawing_create(struct vr_drawing **drawing, const struct brick_volume *volume,
                      const struct vr_renderer_params *params, struct brick_error *err);
void vr_drawing_destroy(struct vr_drawing **drawing);

/* Does OpenGL run on more than this computer's processor? True where that cannot be told. */
bool vr_drawing_has_gpu(void);

/* As vr_render_begin and vr_render_continue, of a scene that they have checked. Scene and quality live until
 * the picture is final or another begins. */
int vr_drawing_begin(struct vr_drawing *drawing, const struct vr_scene *scene,
                     const struct vr_quality *quality, struct brick_error *err);
int vr_drawing_continue(struct vr_drawing *drawing, const struct vr_budget *budget, struct brick_image *image,
                        bool *final, struct vr_report *report, struct brick_error *err);

#endif
