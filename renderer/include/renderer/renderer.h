/* From an open volume to a picture. */
#ifndef RENDERER_RENDERER_H
#define RENDERER_RENDERER_H

#include <stdbool.h>
#include <stdint.h>

#include <brick/active.h>
#include <brick/camera.h>
#include <brick/image.h>
#include <brick/mesh.h>
#include <brick/transfer.h>
#include <brick/volume.h>

enum vr_context_kind {
    VR_CONTEXT_AUTO, /* EGL or, if it gives none, OSMesa */
    VR_CONTEXT_EGL,
    VR_CONTEXT_OSMESA,
    VR_CONTEXT_CPU /* no OpenGL: the raycast method's dvr, shaded and mip, on the processor; of pictures'
                      bytes those of an OpenGL that rounds as IEEE 754 says, but where meshes are seen */
};

/* Keeps the points of the world with normal . x >= offset. */
struct vr_plane {
    double normal[3]; /* of any length but 0 */
    double offset_mm; /* times the normal's length */
};
#define VR_MAX_CLIP_PLANES 12

/* Opaque triangles, seen from both sides and shaded as the volume is. */
struct vr_mesh {
    const struct brick_mesh *mesh; /* the caller's; lives for the call */
    double rgb[3];                 /* linear, [0,1]; of vertices without colours */
};
#define VR_MAX_MESHES 16

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
    /* Only what all of them keep of the volume is there; an isosurface has no caps where it is cut. */
    struct vr_plane clip[VR_MAX_CLIP_PLANES];
    uint32_t clip_count;
    /* Whole, whether inside the volume or not: what lies behind one on a ray is hidden. Vertices without
     * normals get their triangle's. */
    const struct vr_mesh *meshes; /* the caller's; lives for the call */
    uint32_t mesh_count;
    /* 0, or a number that the caller gives: if it is that of the renderer's last picture with meshes, their
     * arrays are as they were then, and are not taken over again. rgb may be another. */
    uint64_t meshes_number;
};
extern const struct vr_scene vr_scene_defaults;

/* Methods on the GPU, drawn by vr_render. */
enum vr_method {
    VR_METHOD_RAYCAST,   /* Scharsach 2005 */
    VR_METHOD_MULTIPASS, /* Krueger and Westermann 2003, section 2 */
    VR_METHOD_SLICES,    /* Wilson, Van Gelder and Wilhelms 1994 */
    VR_METHOD_CELLS,     /* Maximo, Marroquim, Farias and Esperanca 2008 */
    VR_METHODS
};

/* How a ray finds where it begins and ends. */
enum vr_setup {
    VR_SETUP_BOX,     /* the volume's box */
    VR_SETUP_GEOMETRY /* the faces between active and inactive blocks, rasterised (Scharsach 2005, section 3)
                       */
};

/* How cells make a colour of the scalars where a ray enters and leaves a tetrahedron and of the length
 * between (Maximo et al. 2008). */
enum vr_cells_integration {
    VR_CELLS_PREFIX, /* better than the paper: all of the transfer function between the ends by its prefix
                        integrals, depth exactly, colour by its first two moments, as
                        VR_CLASSIFY_PREINTEGRATED */
    VR_CELLS_EXACT,  /* cut at the transfer function's knots, partial pre-integration in between: no error but
                        rounding; up to 3000 pieces of the transfer function, 1000 in a perspective */
    VR_CELLS_PSI,    /* partial pre-integration between the ends' colours and extinctions, by a table of 512 x
                        512 (section 4.2.2, Moreland and Angel 2004) */
    VR_CELLS_EXP,    /* the ends' mean colour and extinction, exp from a table of 256 (4.2.2) */
    VR_CELLS_AVERAGE, /* the same, exp computed (4.2.2) */
    VR_CELLS_SCALAR,  /* colour and extinction at the ends' mean scalar (section 3, Shirley and Tuchman 1990)
                       */
    VR_CELLS_INTEGRATIONS
};

enum vr_interpolation { VR_INTERPOLATION_TRILINEAR, VR_INTERPOLATION_POINT /* the nearest voxel's value */ };
/* What is blended into: 8 normalised bits, or floating point. */
enum vr_framebuffer { VR_FRAMEBUFFER_8, VR_FRAMEBUFFER_16F, VR_FRAMEBUFFER_32F };

/* As many planes as make one a smallest voxel edge (Wilson et al., section 2.2.4: for voxels that are not
 * cubes the paper takes the edge along z); pre-integrated as many more as let no ray pass over a voxel. */
#define VR_PLANES_PAPER UINT32_MAX

/* What slices alone have. */
struct vr_slices {
    uint32_t planes; /* over the length of the volume's diagonal; 0: one a step */
    enum vr_interpolation interpolation;
    enum vr_framebuffer framebuffer;
    uint32_t classified_bits; /* of each channel of pre-classified voxels: 8, 16 or 32 (floating point) */
    bool back_to_front;       /* as in the paper; no ray ends early then */
};

/* Where along the way from voxels to a colour the transfer function comes. */
enum vr_classification {
    VR_CLASSIFY_POST,         /* of the field's value at each sample */
    VR_CLASSIFY_PRE,          /* of voxels; what is interpolated is colour (Wilson et al. 1994) */
    VR_CLASSIFY_PREINTEGRATED /* of all values between two samples, the field being linear from one to the
                                 other; dvr and shaded, emission scaled by extinction, steps of up to a voxel
                               */
};

/* How it is computed: speed against error. */
struct vr_quality {
    enum vr_method method;
    double step_vox;    /* of the smallest voxel edge, > 0 */
    double termination; /* a ray ends where its transmittance falls below; 0: never */
    bool skip;          /* jump over inactive bricks and macrocells */
    bool interleaved; /* raycast, multipass: the pieces of neighbouring pixels' rays begin at different parts
                         of a step before the box (Scharsach 2005, section 5) */
    uint32_t refinements; /* bisections at an isosurface hit (Scharsach 2005, section 4) */
    bool cubic;           /* iso: instead, bisect into one cell, and solve the cubic along the ray there */
    bool distances; /* iso: for measurements. The image is not colour but t of hits in mm (brick/camera.h), R
                       and, what float32 lacks, G; A is 1 where there is a hit. No meshes. */
    enum vr_setup setup; /* raycast, multipass; the same picture */
    uint32_t pass_steps; /* multipass: samples a ray and pass, 1 to VR_MAX_PASS_STEPS */
    enum vr_classification classification;
    struct vr_slices slices;
    enum vr_cells_integration cells_integration;
};
#define VR_MAX_PASS_STEPS 1500
extern const struct vr_quality vr_quality_defaults;

struct vr_report {
    uint64_t passes;                      /* over unfinished rays */
    uint64_t bricks_total, bricks_active; /* of the level */
    uint64_t bricks_loaded; /* into the GPU cache, or without OpenGL the host's; one that came twice counts
                               twice */
    uint64_t bricks_read, bytes_read;               /* from the file; bytes as stored */
    uint64_t gpu_cache_bytes, gpu_cache_peak_bytes; /* of the cache texture; of its slots ever in use */
    uint64_t host_cache_peak_bytes;                 /* of decoded bricks, ever */
    uint64_t samples;                               /* of the field, fetched */
    uint64_t tetrahedra;                            /* cells: of the level; samples: of those, drawn */
    double seconds_setup, seconds_draw;             /* cells: finding what is drawn; drawing it */
    double seconds_frame;                           /* loading, drawing and reading back */
    char gl_renderer[128];                          /* "" for methods on the CPU */
};

/* What draws one volume: OpenGL with its caches in the GPU or, with VR_CONTEXT_CPU, a cache of bricks and
 * threads. One caller at a time. */
struct vr_renderer;

/* How values between voxels are found. Either way the picture has the same bytes for all sizes of the caches
 * and bricks, but those of the second depend on the driver's sampler. */
enum vr_filter {
    VR_FILTER_EXACT, /* eight voxels as they are, interpolated in float32 */
    VR_FILTER_FAST   /* the texture unit's filter, at the fraction rounded to 2^-12; volumes with voxels that
                        are   not finite are drawn as with VR_FILTER_EXACT */
};

struct vr_renderer_params {
    enum vr_context_kind context;
    enum vr_filter filter; /* it decides how the GPU cache holds bricks, so it is the renderer's */
    uint64_t gpu_cache_bytes;
    uint64_t host_cache_bytes; /* of decoded bricks */
    unsigned threads;          /* 0: one a core */
};
extern const struct vr_renderer_params vr_renderer_defaults;

/* Is VR_CONTEXT_CPU the faster way to draw this: params leave the context open, there is no GPU for OpenGL to
 * run on, and the scene is one that the processor draws? */
bool vr_prefers_cpu(const struct vr_scene *scene, const struct vr_quality *quality,
                    const struct vr_renderer_params *params);

/* BRICK_ERR_UNSUPPORTED when no such context can be had, saying what is missing. */
int vr_renderer_create(struct vr_renderer **renderer, const struct brick_volume *volume,
                       const struct vr_renderer_params *params, struct brick_error *err);
void vr_renderer_destroy(struct vr_renderer **renderer);

/* Draw by quality->method. image has scene->width x scene->height. Bricks come from the file while drawing,
 * into caches of any size that holds a brick, and stay for the next picture. Errors of reading name the
 * brick; the image is then undefined. BRICK_ERR_UNSUPPORTED for what a method does not do.
 *
 * raycast and multipass: in passes, between which the bricks come that rays need; the picture is the same
 * bytes for both, and for all sizes of the caches. Pre-integrated classification goes with dvr and shaded,
 * and with steps that move by a voxel of the level at most along each of its axes.
 *
 * slices: planes of one depth each, blended brick by brick in batches that the cache holds; the same bytes
 * for all sizes of the caches and bricks. No isosurfaces. Pre-classified voxels go with dvr; the GPU's cache
 * then holds colours, four channels a voxel.
 *
 * cells: dvr through a parallel camera; of the quality only skip and cells_integration. Each cell is five
 * tetrahedra, on which the field is linear: vr_render_exact with VR_FIELD_TETRAHEDRA is what they are exact
 * of. The picture is the same bytes for all sizes of the caches, and with skip on or off. */
int vr_render(struct vr_renderer *renderer, const struct vr_scene *scene, const struct vr_quality *quality,
              struct brick_image *image, struct vr_report *report, struct brick_error *err);

/* The same in steps, for who shows a picture while it is made. Begin says what, and ends any picture before
 * it, finished or not: a camera that moves begins anew. Each call of continue then draws until the picture is
 * final or the budget is used up, and leaves in `image` the picture as far as it goes: of what is not in the
 * GPU cache coarser bricks stand in, which take up to an eighth of it. Every call is given the same image,
 * untouched since the last. The final picture has the bytes of vr_render, which is begin, and continue
 * without a budget.
 *
 * scene->transfer and scene->meshes live until the picture is final or another begins. report counts from
 * begin on. After an error of continue, or a final picture, the next call is begin. Slices,
 * cells, and whatever is drawn without OpenGL know no budget: their first picture is final. */
struct vr_budget {
    double seconds;        /* kept but for a pass over the rays and a look; 0: any */
    uint64_t upload_bytes; /* of bricks into the GPU cache, one brick at least and those that stand in apart;
                              0: any */
};
int vr_render_begin(struct vr_renderer *renderer, const struct vr_scene *scene,
                    const struct vr_quality *quality, struct brick_error *err);
int vr_render_continue(struct vr_renderer *renderer, const struct vr_budget *budget,
                       struct brick_image *image, bool *final, struct vr_report *report,
                       struct brick_error *err);

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
    double *hit_mm; /* iso: t of every pixel's hit of the surface (brick/camera.h), infinite where there is
                       none; width * height, the caller's; NULL: not wanted */
};
extern const struct vr_exact_params vr_exact_defaults;
int vr_render_exact(const struct brick_volume *volume, const struct vr_scene *scene,
                    const struct vr_exact_params *params, struct brick_image *image, struct vr_report *report,
                    struct brick_error *err);

/* Isosurfaces by ray tracing on the CPU, straight from the bricks (Parker, Shirley, Livnat, Hansen and Sloan,
 * "Interactive Ray Tracing for Isosurface Rendering", 1998). Of the scene it takes all but mode; isovalue,
 * transfer and iso_rgb give the surface when params->surface_count is 0: opaque, coloured by the transfer
 * function there.
 *
 * The hit is where the trilinear field itself changes side, no step size: the cubic along the ray in its cell
 * is solved in double precision. No ray slips between cells, and the picture has the same bytes for every
 * size of bricks, macrocells and cache, any number of threads, and with skipping on or off. */
#define VR_ISO_MAX_SURFACES 16
struct vr_iso_surface {
    double isovalue; /* physical, finite */
    double rgb[3];   /* linear */
    double opacity;  /* of one crossing, [0,1] */
};

/* How a brick's voxels lie in memory while rays read them. All but the first hold the whole level in memory,
 * within host_cache_bytes, and are there to be measured against it. */
enum vr_iso_layout {
    VR_ISO_BRICKS, /* as decoded: x fastest inside a brick */
    VR_ISO_TILED,  /* two levels of tiles inside a brick, through address tables (the paper's appendix B) */
    VR_ISO_FLAT /* no bricks: the level as one array, x fastest, and no hierarchy (the paper's "initial") */
};

/* Where the time went, as samples of what the threads were doing (the paper's table 1). */
struct vr_iso_profile {
    uint64_t traversal, intersection, shading;
};

struct vr_isotrace_params {
    const struct vr_iso_surface *surfaces; /* seen through one another in their order along each ray */
    uint32_t surface_count;                /* up to VR_ISO_MAX_SURFACES */
    bool shadows;                          /* surfaces keep the light from each other, each by its opacity */
    bool lit; /* light is given; otherwise the light is at the eye, for shadows above the eye's left shoulder
               */
    double light[3];                /* from the volume towards the light, world; parallel light */
    double termination;             /* a ray ends where its transmittance falls below, [0,1) */
    bool skip;                      /* the hierarchy of bricks and macrocells; off: cell after cell */
    struct vr_iso_profile *profile; /* may be NULL; added to. Takes a thread of its own */
};
extern const struct vr_isotrace_params vr_isotrace_defaults;

/* A volume's cache of bricks and threads, kept from frame to frame. One caller at a time. */
struct vr_isotracer;
struct vr_isotracer_params {
    uint64_t host_cache_bytes; /* room for one brick at least; no more threads run than it has bricks */
    unsigned threads;          /* 0: one a core */
    enum vr_iso_layout layout;
};
extern const struct vr_isotracer_params vr_isotracer_defaults;
int vr_isotracer_create(struct vr_isotracer **tracer, const struct brick_volume *volume,
                        const struct vr_isotracer_params *params, struct brick_error *err);
void vr_isotracer_destroy(struct vr_isotracer **tracer);

/* image has scene->width x scene->height. BRICK_ERR_ARGUMENT for what the structs above exclude, and
 * the errors of reading bricks. Meshes and surfaces shade each other. report->samples counts the cells whose
 * cubic was formed. */
int vr_render_isotrace(struct vr_isotracer *tracer, const struct vr_scene *scene,
                       const struct vr_isotrace_params *params, struct brick_image *image,
                       struct vr_report *report, struct brick_error *err);

#endif
