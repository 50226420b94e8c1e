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

/* Keeps the points of the world with normal . x >= offset. */
struct vr_plane {
    double normal[3]; /* of any length but 0 */
    double offset_mm; /* times the normal's length */
};
#define VR_MAX_CLIP_PLANES 6

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
    /* Only what all of them keep is there; an isosurface has no caps where it is cut. */
    struct vr_plane clip[VR_MAX_CLIP_PLANES];
    uint32_t clip_count;
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
    uint64_t passes;                                     /* 1, or more where rays have thousands of samples */
    uint64_t bricks_total, bricks_active, bricks_loaded; /* of the level */
    uint64_t bytes_read;
    uint64_t gpu_cache_bytes, gpu_cache_peak_bytes; /* of the cache texture; of its slots ever in use */
    uint64_t samples;                               /* of the field, fetched */
    double seconds_frame;                           /* drawing and reading back, the bricks being resident */
    char gl_renderer[128];                          /* "" for methods on the CPU */
};

/* A context with a current-thread OpenGL and the GPU caches of one volume. One thread at a time. */
struct vr_renderer;

struct vr_renderer_params {
    enum vr_context_kind context;
    uint64_t gpu_cache_bytes;
    uint64_t host_cache_bytes; /* not used while every visible brick must fit the GPU cache */
    unsigned threads;          /* 0: one a core */
};
extern const struct vr_renderer_params vr_renderer_defaults;

/* BRICK_ERR_UNSUPPORTED when no such context can be had, saying what is missing. */
int vr_renderer_create(struct vr_renderer **renderer, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err);
void vr_renderer_destroy(struct vr_renderer **renderer);

/* Single-pass GPU raycasting. image has scene->width x scene->height. BRICK_ERR_MEMORY when the active set
 * does not fit the cache, with the size that would do; BRICK_ERR_UNSUPPORTED for clip planes. */
int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err);

/* What is interpolated between voxels. Other fields than the trilinear one are what some methods converge to;
 * gradients are the trilinear field's in all of them. */
enum vr_field {
    VR_FIELD_TRILINEAR,
    VR_FIELD_TETRAHEDRA,   /* linear on five tetrahedra a cell (Maximo et al. 2008, section 4.1) */
    VR_FIELD_PRECLASSIFIED /* trilinear in the colour and, apart from it, the extinction of classified voxels
                              (Wilson et al. 1994); dvr and shaded only */
};

/* The exact reference, on the CPU in double precision; no step size. dvr and shaded are right to 1e-10
 * absolute per channel before rounding to float32, iso and mip to the rounding of double. iso: the first t
 * where the side of the isovalue changes, f >= V being above; cells with a corner that is not finite have no
 * side and bound no surface. BRICK_ERR_UNSUPPORTED for iso and mip of pre-classified voxels. */
struct vr_exact_params {
    uint64_t host_cache_bytes;
    unsigned threads;
    double tolerance; /* absolute, per channel and ray */
    enum vr_field field;
    double *hit_mm; /* iso: t of every pixel's hit (brick/camera.h), infinite where there is none; width *
                       height, the caller's; NULL: not wanted */
};
extern const struct vr_exact_params vr_exact_defaults;
int vr_render_exact(const struct brick_volume *volume, const struct vr_scene *scene,
                    const struct vr_exact_params *params, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err);

#endif
