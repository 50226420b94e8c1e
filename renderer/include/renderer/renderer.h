/* From an open volume to a picture. */
#ifndef RENDERER_RENDERER_H
#define RENDERER_RENDERER_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/active.h>
#include <brick/camera.h>
#include <brick/image.h>
#include <brick/transfer.h>
#include <brick/volume.h>

enum vr_context_kind { VR_CONTEXT_AUTO, VR_CONTEXT_EGL, VR_CONTEXT_OSMESA };

/* What is in the picture. Plain values; the transfer function stays the caller's and lives for the call. */
struct vr_scene {
    enum brick_mode mode;
    const struct brick_transfer
        *transfer;     /* dvr, shaded, mip: required. iso: colour of the surface, or NULL */
    double isovalue;   /* iso, physical */
    double iso_rgb[3]; /* iso surface colour when transfer is NULL, linear */
    struct brick_camera camera;
    uint32_t width, height;
    uint32_t level;
    /* Blinn-Phong, headlight, two-sided (shaded, iso). */
    double ambient, diffuse, specular, shininess;
};
extern const struct vr_scene vr_scene_defaults;

/* How it is computed: speed against error. */
struct vr_quality {
    double step_vox;      /* of the smallest voxel edge, > 0 */
    double termination;   /* a ray ends where its transmittance falls below; 0: never */
    bool skip;            /* jump over inactive bricks and macrocells */
    uint32_t refinements; /* bisections at an isosurface hit */
};
extern const struct vr_quality vr_quality_defaults;

struct vr_report {
    uint64_t passes;                                /* over unfinished rays */
    uint64_t bricks_total, bricks_active;           /* of the level */
    uint64_t bricks_loaded;                         /* into the GPU cache; one that came twice counts twice */
    uint64_t bricks_read, bytes_read;               /* from the file; bytes as stored */
    uint64_t gpu_cache_bytes, gpu_cache_peak_bytes; /* of the cache texture; of its slots ever in use */
    uint64_t host_cache_peak_bytes;                 /* of decoded bricks, ever */
    uint64_t samples;                               /* of the field, fetched */
    double seconds_frame;                           /* loading, drawing and reading back */
    char gl_renderer[128];                          /* "" for methods on the CPU */
};

/* A context with a current-thread OpenGL and the GPU caches of one volume. One thread at a time. */
struct vr_renderer;

struct vr_renderer_params {
    enum vr_context_kind context;
    uint64_t gpu_cache_bytes;
    uint64_t host_cache_bytes; /* of decoded bricks */
    unsigned threads;          /* 0: one a core */
};
extern const struct vr_renderer_params vr_renderer_defaults;

/* BRICK_ERR_UNSUPPORTED when no such context can be had, saying what is missing. */
int vr_renderer_create(struct vr_renderer **renderer, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err);
void vr_renderer_destroy(struct vr_renderer **renderer);

/* GPU raycasting, in passes: bricks that rays need come from the file between them, into caches of any size
 * that holds a brick; the picture is the same bytes for all sizes. Bricks stay for the next picture. image
 * has scene->width x scene->height. Errors of reading name the brick; the image is then undefined. */
int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err);

/* The exact reference, on the CPU in double precision: mode dvr, right to 1e-10 absolute per channel before
 * rounding to float32; no step size. BRICK_ERR_UNSUPPORTED for other modes. */
struct vr_exact_params {
    uint64_t host_cache_bytes;
    unsigned threads;
    double tolerance; /* absolute, per channel and ray */
};
extern const struct vr_exact_params vr_exact_defaults;
int vr_render_exact(const struct brick_volume *volume, const struct vr_scene *scene,
                    const struct vr_exact_params *params, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err);

#endif
