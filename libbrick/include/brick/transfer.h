/* Transfer functions: physical value -> linear RGB and extinction.
 *
 * Given as control points (value, r, g, b, A), A the opacity of `unit` length. Between points colour and A
 * are linear, outside constant; two points at one value make a jump, and the right one holds at the value.
 * Extinction sigma = -ln(1 - A) / unit, A clamped to 1 - 2^-24. On creation each segment is cut into pieces
 * with sigma linear in the value such that A differs by at most 1e-4; that piecewise-linear function is the
 * transfer function everywhere: in the shaders, in the reference and in culling. */
#ifndef BRICK_TRANSFER_H
#define BRICK_TRANSFER_H

#include <stdbool.h>
#include <stddef.h>

#include <brick/error.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BRICK_TRANSFER_MAX_POINTS 65536

struct brick_transfer_point {
    double value;      /* physical value, or [0,1] of the range when .range_values */
    double r, g, b, a; /* linear, [0,1] */
};

/* What colour means: emission a mm is colour times extinction, or colour a `unit` whatever the extinction
 * (Wilson et al. 1994, section 2.1; Maximo et al. 2008). */
enum brick_emission { BRICK_EMISSION_SCALED, BRICK_EMISSION_INDEPENDENT };

enum brick_transfer_unit { BRICK_UNIT_MM, BRICK_UNIT_VOXEL };

/* What a transfer function file says, before a volume is known. */
struct brick_transfer_spec {
    struct brick_transfer_point
        *points; /* owned by whoever filled it; free with brick_transfer_spec_finish */
    size_t count;
    double unit;                      /* length of A, in unit_of */
    enum brick_transfer_unit unit_of; /* BRICK_UNIT_VOXEL: times the smallest voxel edge */
    bool range_values;                /* values map [0,1] to the volume's own physical range */
};
void brick_transfer_spec_finish(struct brick_transfer_spec *spec);

/* One knot of the piecewise-linear function; a jump is two knots at one value. */
struct brick_transfer_knot {
    double value;   /* physical */
    double r, g, b; /* linear colour */
    double sigma;   /* extinction per mm, >= 0 */
};

struct brick_interval {
    double lo, hi; /* closed; may be infinite */
};

/* Immutable once made; safe to read from any thread. */
struct brick_transfer {
    struct brick_transfer_knot *knots; /* count >= 1, values ascending; constant outside */
    size_t count;
    struct brick_interval *support; /* closed, disjoint, ascending: nothing shows anywhere outside them */
    size_t support_count;
    /* Where something shows: extinction, or with independent emission extinction or colour, is not zero. For
     * ranges whose ends are doubles: something shows somewhere in [lo, hi] iff it meets one of these, that is
     * lo <= visible.hi and hi >= visible.lo. Ascending; an end where nothing shows is moved in by one double.
     */
    struct brick_interval *visible;
    size_t visible_count;
    bool continuous; /* no jump in colour or extinction */
    enum brick_emission emission;
    double unit_mm; /* length that the control points' A belongs to: A = 1 - exp(-sigma * unit_mm) */
};

/* min_edge_mm: the volume's smallest voxel edge; range: its smallest and largest physical value (used only
 * with range_values). BRICK_ERR_ARGUMENT for no points, values not ascending or not finite, three points at
 * one value, components outside [0,1], unit not positive. */
int brick_transfer_create(struct brick_transfer **out, const struct brick_transfer_spec *spec,
                          double min_edge_mm, const double range[2], struct brick_error *err);
void brick_transfer_destroy(struct brick_transfer **transfer);
/* Before anyone else reads it; a new one is BRICK_EMISSION_SCALED. */
void brick_transfer_set_emission(struct brick_transfer *transfer, enum brick_emission emission);
/* Multiply extinction by a global opacity factor, above 0 and finite (Maximo et al. 2008, section 5, call it
 * brightness), before others read it: what gets through a length is raised to that power. Where the function
 * is transparent does not change. */
void brick_transfer_scale(struct brick_transfer *transfer, double factor);

/* Colour and extinction at a physical value; at a jump the right side. NaN gives zero extinction. */
void brick_transfer_eval(const struct brick_transfer *transfer, double value, double rgb[3], double *sigma);
/* Does something show somewhere in [lo, hi]? Exact for the piecewise-linear function. Empty ranges: false.
 */
bool brick_transfer_visible(const struct brick_transfer *transfer, double lo, double hi);

/* Built in: "ct-bone", "ct-skin", "mri", "gray". BRICK_ERR_ARGUMENT (naming them) for another name. */
int brick_transfer_builtin(const char *name, struct brick_transfer_spec *spec, struct brick_error *err);

#ifdef __cplusplus
}
#endif
#endif
