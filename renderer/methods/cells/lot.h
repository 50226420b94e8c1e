/* A lot of cells, in traversal order, on its way to the picture: collected, freed of those that show nothing,
 * drawn. */
#ifndef RENDERER_CELLS_LOT_H
#define RENDERER_CELLS_LOT_H

#include "basis.h"
#include "canvas.h"
#include "frame.h"
#include "walk.h"

/* What an entry of the list is drawn as: triangles over so many vertices. */
#define VR_CELL_INDICES (VR_BASIS_SLOTS * 4 * 3)
struct vr_cell_shape {
    uint8_t vertices, indices, index[VR_CELL_INDICES];
    uint8_t tetrahedra[2]; /* of an entry, by its piece's number */
    GLenum cull;           /* GL_FRONT or GL_BACK; 0: neither */
};

/* Cells of one brick, one after the other. */
struct vr_cell_run {
    int first[3];        /* the brick's first voxel, in the level */
    int texel[3];        /* and in the atlas */
    size_t begin, count; /* in the list */
};

struct vr_cell_lot {
    uint32_t *entries; /* walk.h */
    size_t count;
    struct vr_cell_run *runs;
    size_t run_count;
    struct vr_buffer buffer; /* what the shaders read of it */
    struct vr_canvas canvas; /* where cells are looked at */
    float *flags;            /* and what was seen */
    GLuint vertex_array, indices;
    struct vr_cell_shape shape; /* in the indices, as often as 16 bits number its vertices */
};

/* What drawing takes beside the lot. */
struct vr_cell_draw {
    const struct vr_frame *frame;
    const struct vr_canvas *canvas; /* the picture */
    struct vr_uniforms look, draw;  /* cells_shown.glsl; what draws the shape */
    bool select;                    /* leave out what shows nothing */
    GLuint unit;                    /* of the list */
};

/* The context is bound in all of these. A lot of zeros is safe to finish. */
int vr_cell_lot_init(struct vr_cell_lot *lot, struct vr_context *context, struct brick_error *err);
void vr_cell_lot_finish(struct vr_cell_lot *lot, struct vr_context *context);
int vr_cell_lot_set_shape(struct vr_cell_lot *lot, struct vr_context *context,
                          const struct vr_cell_shape *shape, struct brick_error *err);

/* Is there room for so many more entries, and for another run? */
bool vr_cell_lot_has_room(const struct vr_cell_lot *lot, size_t entries);
/* Entries that are appended from now on are of this brick. */
void vr_cell_lot_open_run(struct vr_cell_lot *lot, const int first[3], const int texel[3]);

/* Draw it in its order over what the picture holds, and empty it. Adds tetrahedra drawn and times to the
 * report. Bricks of its runs are in the atlas, and the buffers that the programs read are in their units. */
int vr_cell_lot_draw(struct vr_cell_lot *lot, const struct vr_cell_draw *draw, struct vr_report *report,
                     struct brick_error *err);

/* What shaders/cells_shown.glsl needs to know. */
#define VR_CELL_LOT_ROW 256

#endif
