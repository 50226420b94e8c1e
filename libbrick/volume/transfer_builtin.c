/* The built-in transfer functions: tables of control points, colours linear. All are continuous.
 *
 * Without shading, depth is read from colour alone: each tissue starts dark at its thin, outer values and
 * grows lighter inwards, so that edges seen at a grazing angle are darker than faces seen straight on. */
#include <brick/transfer.h>

#include <stdlib.h>
#include <string.h>

/* HU per mm: nothing below dense soft tissue, then cancellous and cortical bone. */
static const struct brick_transfer_point ct_bone[] = {
    {150.0, 0.07, 0.025, 0.012, 0.0}, {320.0, 0.24, 0.11, 0.055, 0.20}, {580.0, 0.62, 0.45, 0.29, 0.45},
    {950.0, 0.90, 0.82, 0.68, 0.70},  {1450.0, 0.98, 0.96, 0.91, 0.82},
};

/* HU per mm: air clear, the air-skin boundary dark, then skin and fat, muscle, bone. */
static const struct brick_transfer_point ct_skin[] = {
    {-700.0, 0.02, 0.005, 0.003, 0.0}, {-450.0, 0.10, 0.03, 0.015, 0.35}, {-250.0, 0.40, 0.16, 0.08, 0.50},
    {-100.0, 0.85, 0.52, 0.36, 0.50},  {50.0, 0.92, 0.60, 0.44, 0.60},    {150.0, 0.85, 0.40, 0.30, 0.80},
    {400.0, 0.97, 0.92, 0.82, 0.90},
};

/* The volume's range, per mm: background noise clear, brain translucent, fat and vessels bright. */
static const struct brick_transfer_point mri[] = {
    {0.0, 0.0, 0.0, 0.0, 0.0},      {0.10, 0.05, 0.02, 0.02, 0.0}, {0.25, 0.25, 0.12, 0.09, 0.06},
    {0.50, 0.60, 0.42, 0.34, 0.25}, {1.0, 0.98, 0.94, 0.86, 0.60},
};

/* The volume's range, per voxel: a plain ramp, for any volume. */
static const struct brick_transfer_point gray[] = {
    {0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0, 1.0, 1.0, 1.0, 0.2},
};

static const struct {
    const char *name;
    const struct brick_transfer_point *points;
    size_t count;
    enum brick_transfer_unit unit_of;
    bool range_values;
} table[] = {
    {"ct-bone", ct_bone, sizeof ct_bone / sizeof ct_bone[0], BRICK_UNIT_MM, false},
    {"ct-skin", ct_skin, sizeof ct_skin / sizeof ct_skin[0], BRICK_UNIT_MM, false},
    {"mri", mri, sizeof mri / sizeof mri[0], BRICK_UNIT_MM, true},
    {"gray", gray, sizeof gray / sizeof gray[0], BRICK_UNIT_VOXEL, true},
};

int brick_transfer_builtin(const char *name, struct brick_transfer_spec *spec, struct brick_error *err)
{
    memset(spec, 0, sizeof *spec);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (strcmp(name, table[i].name) != 0)
            continue;
        spec->points = malloc(table[i].count * sizeof *spec->points);
        if (!spec->points)
            return brick_fail(err, BRICK_ERR_MEMORY, "no memory for transfer function %s", name);
        memcpy(spec->points, table[i].points, table[i].count * sizeof *spec->points);
        spec->count = table[i].count;
        spec->unit = 1.0;
        spec->unit_of = table[i].unit_of;
        spec->range_values = table[i].range_values;
        return BRICK_OK;
    }
    return brick_fail(err, BRICK_ERR_ARGUMENT,
                      "no transfer function is called '%.64s'; built in: ct-bone, ct-skin, mri, gray", name);
}
