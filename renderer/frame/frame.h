/* What a method draws: a scene of a volume whose bricks come through the residency, and how well it is to be
 * drawn. Methods share the uniforms that describe these, by the names that the shaders in shaders/ declare.
 */
#ifndef RENDERER_FRAME_FRAME_H
#define RENDERER_FRAME_FRAME_H

#include "meshes.h"
#include "prefixes.h"
#include "programs.h"
#include "residency.h"

/* Texture units that all methods use alike; a method's own begin at VR_UNIT_METHOD. */
enum {
    VR_UNIT_ATLAS,
    VR_UNIT_PAGES,
    VR_UNIT_MACROCELLS,
    VR_UNIT_PIECES,
    VR_UNIT_BINS,
    VR_UNIT_MESH_WAY,
    VR_UNIT_MESH_COLOUR,
    VR_UNIT_PREFIXES,
    VR_UNIT_METHOD
};

/* What stays from picture to picture, whatever the method. One of zeros is empty. */
struct vr_frame_store {
    struct vr_programs programs;
    struct vr_buffer pieces, bins, prefixes; /* of the transfer function */
    struct vr_mesh_layer meshes;
};

struct vr_frame {
    struct vr_context *context; /* bound */
    struct vr_frame_store *store;
    const struct brick_volume *volume;
    const struct brick_grid *grid;
    const struct brick_level *level; /* the scene's */
    struct vr_residency *residency;  /* vr_residency_begin has been called for the scene */
    const struct vr_scene *scene;
    const struct vr_quality *quality;
    struct brick_view view;
    double step_mm;
    struct vr_transfer_table table; /* of one search step and nothing else for iso */
    struct vr_prefix *prefixes;     /* NULL unless classification is pre-integrated */

    /* A picture may be drawn in several calls; a method that always draws all of it need not look here. */
    bool begun;            /* this is not the first call: go on with what the method's state holds */
    bool final;            /* the method: false where it returns before the end. True when it is called */
    uint64_t deadline_ns;  /* of the call, by brick_now_ns; UINT64_MAX: none */
    uint64_t upload_bytes; /* to the GPU cache, in this call; UINT64_MAX: any */
};

void vr_frame_store_finish(struct vr_frame_store *store, struct vr_context *context);

/* Fill in a frame from grid to prefixes; context, store, volume and residency are given. BRICK_ERR_ARGUMENT
 * and _UNSUPPORTED where samples or voxels cannot be counted, and for pre-integrated classification of a mode
 * that integrates nothing. */
int vr_frame_init(struct vr_frame *frame, const struct vr_scene *scene, const struct vr_quality *quality,
                  struct brick_error *err);
void vr_frame_finish(struct vr_frame *frame);

/* What the shared shader parts need defined: MODE and its values, VOXEL_SAMPLER, SEARCH_STEPS, and where they
 * hold SKIP, INTERLEAVED, NONFINITE, FILTER_FAST, VOXEL_NORMALISED, PREINTEGRATED, CLIP_PLANES (how many) and
 * MESHES. Returns the number of bytes written. */
#define VR_FRAME_DEFINES_BYTES 512
size_t vr_frame_defines(const struct vr_frame *frame, char defines[VR_FRAME_DEFINES_BYTES]);

/* Uniforms of a program in use, by name; those it does not have are passed over. */
struct vr_uniforms {
    const struct vr_gl *gl;
    GLuint program;
};
/* Take the store's program of that source and these defines, and use it. */
int vr_frame_use_program(const struct vr_frame *frame, const struct vr_program_source *source,
                         const char *defines, struct vr_uniforms *u, struct brick_error *err);
void vr_set_int(const struct vr_uniforms *u, const char *name, int v);
void vr_set_float(const struct vr_uniforms *u, const char *name, double v);
void vr_set_double(const struct vr_uniforms *u, const char *name, double v);
void vr_set_ivec2(const struct vr_uniforms *u, const char *name, int x, int y);
void vr_set_ivec3(const struct vr_uniforms *u, const char *name, const int v[3]);
void vr_set_vec3(const struct vr_uniforms *u, const char *name, const double v[3]);
void vr_set_dvec3(const struct vr_uniforms *u, const char *name, const double v[3]);

/* The rays of a view, as ray.glsl and mesh.frag.glsl have them. */
void vr_set_view(const struct vr_uniforms *u, const struct brick_view *view);

/* shaders/ray.glsl */
void vr_frame_set_rays(const struct vr_frame *frame, const struct vr_uniforms *u);
/* shaders/field.glsl, and page table, macrocell bits and atlas in their units. An upload to the atlas undoes
 * the last: vr_atlas_use again after it. */
void vr_frame_set_field(const struct vr_frame *frame, const struct vr_uniforms *u);
/* For programs with STAND_IN defined: what coarser levels are to the scene's. */
void vr_frame_set_stand_ins(const struct vr_frame *frame, const struct vr_uniforms *u);
/* shaders/shading.glsl */
void vr_frame_set_shading(const struct vr_frame *frame, const struct vr_uniforms *u);
/* shaders/transfer.glsl and shaders/preintegrated.glsl, and their arrays in their units; not for iso. */
int vr_frame_set_transfer(const struct vr_frame *frame, const struct vr_uniforms *u, struct brick_error *err);

#endif
