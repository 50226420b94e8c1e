/* The anatomy of the "ct" phantom: a trunk from the hips to the neck, arms not in the picture.
 *
 * Not a model of anyone: it has what makes CT hard for a volume renderer in the usual proportions: two fifths
 * exactly constant air, large soft organs of nearly one value, air within, bone as thin dense walls about
 * spongy cores, and contrast-filled vessels from the aorta down to twigs thinner than a voxel. Later parts
 * are painted over earlier ones. Positions are by eye; values in Hounsfield units. */
#include <assert.h>
#include <math.h>

#include "synth_ct.h"

#define CORTEX   1200.0 /* compact bone */
#define MARROW   250.0
#define CONTRAST 340.0 /* arterial blood with contrast medium: soft tissue + 300 */

static struct ct_part *add(struct ct_part_list *list)
{
    assert(list->count < SYNTH_MAX_PARTS);
    struct ct_part *part = &list->part[list->count++];
    *part = (struct ct_part){.kind = CT_ELLIPSOID};
    return part;
}

static void ellipsoid(struct ct_part_list *list, double hu, double x, double y, double z, double rx,
                      double ry, double rz)
{
    struct ct_part *part = add(list);
    part->hu = hu;
    part->a[0] = x, part->a[1] = y, part->a[2] = z;
    part->b[0] = rx, part->b[1] = ry, part->b[2] = rz;
}

static void capsule(struct ct_part_list *list, double hu, const double from[3], const double to[3],
                    double radius)
{
    struct ct_part *part = add(list);
    part->kind = CT_CAPSULE;
    part->hu = hu;
    part->thickness = radius;
    for (int i = 0; i < 3; i++) {
        part->a[i] = from[i];
        part->b[i] = to[i];
    }
}

/* A chain of capsules; side -1 mirrors x. */
static void tube(struct ct_part_list *list, double hu, const double (*points)[3], unsigned count, double side,
                 double radius)
{
    for (unsigned i = 0; i + 1 < count; i++) {
        const double from[3] = {side * points[i][0], points[i][1], points[i][2]};
        const double to[3] = {side * points[i + 1][0], points[i + 1][1], points[i + 1][2]};
        capsule(list, hu, from, to, radius);
    }
}

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* A tree of vessels that stays inside an ellipsoid. */
struct tree {
    struct ct_part_list *list;
    const double *centre, *axes;
    uint32_t state; /* of the generator of directions: the anatomy is the same in every volume */
};

static double tree_uniform(struct tree *tree)
{
    tree->state =
        tree->state * 1664525u + 1013904223u; /* Numerical Recipes' generator; its upper bits are good */
    return (double)(tree->state >> 8) / 8388608.0 - 1; /* [-1, 1) */
}

static void grow(struct tree *tree, const double from[3], const double direction[3], double length,
                 double radius, int depth)
{
    double to[3], turned[3];
    for (int attempt = 0;; attempt++) {
        double norm = 0, inside = 0;
        for (int i = 0; i < 3; i++) {
            turned[i] = direction[i] + (0.55 + 0.12 * attempt) * tree_uniform(tree);
            norm += turned[i] * turned[i];
        }
        norm = 1 / sqrt(norm + 1e-6);
        for (int i = 0; i < 3; i++) {
            turned[i] *= norm;
            to[i] = from[i] + length * turned[i];
            const double at = (to[i] - tree->centre[i]) / tree->axes[i];
            inside += at * at;
        }
        if (inside < 0.9)
            break;
        if (attempt == 12)
            return;
    }
    capsule(tree->list, CONTRAST, from, to, radius);
    if (depth == 0)
        return;
    grow(tree, to, turned, 0.80 * length, 0.76 * radius, depth - 1);
    grow(tree, to, turned, 0.80 * length, 0.68 * radius, depth - 1);
}

static void trunk(struct ct_part_list *list)
{
    ellipsoid(list, 60, 0, 0, 0, 0.96, 0.78, 2.3);           /* skin */
    ellipsoid(list, -100, 0, 0, 0, 0.945, 0.765, 2.28);      /* subcutaneous fat */
    ellipsoid(list, 50, 0, 0, 0, 0.88, 0.69, 2.2);           /* muscle */
    ellipsoid(list, -95, 0, -0.08, -0.72, 0.70, 0.50, 0.50); /* fat about the bowels */
}

static void lungs(struct ct_part_list *list)
{
    for (int side = -1; side <= 1; side += 2) {
        const double centre[3] = {0.40 * side, -0.02, 0.30}, axes[3] = {0.32, 0.47, 0.60};
        ellipsoid(list, -850, centre[0], centre[1], centre[2], axes[0], axes[1], axes[2]);
        struct tree tree = {list, centre, axes, 7};
        const double hilum[3] = {0.17 * side, 0.04, 0.28};
        const double up[3] = {0.7 * side, -0.1, 1.0}, down[3] = {0.6 * side, 0.5, -1.0},
                     front[3] = {0.8 * side, -0.8, -0.2};
        grow(&tree, hilum, up, 0.17, 0.022, 5);
        grow(&tree, hilum, down, 0.17, 0.022, 5);
        grow(&tree, hilum, front, 0.17, 0.020, 5);
    }
}

static void belly(struct ct_part_list *list)
{
    ellipsoid(list, 110, -0.34, -0.06, -0.34, 0.40, 0.46, 0.36);   /* liver under the right dome */
    ellipsoid(list, 45, 0.38, -0.06, -0.40, 0.35, 0.44, 0.34);     /* stomach's wall under the left dome */
    ellipsoid(list, 15, 0.30, -0.18, -0.38, 0.22, 0.22, 0.20);     /* its contents */
    ellipsoid(list, CT_AIR, 0.30, -0.32, -0.34, 0.13, 0.07, 0.11); /* its gas bubble */
    ellipsoid(list, 125, 0.56, 0.22, -0.36, 0.14, 0.18, 0.20);     /* spleen */
    for (int side = -1; side <= 1; side += 2) {
        ellipsoid(list, 190, 0.34 * side, 0.28, -0.62, 0.10, 0.10, 0.17); /* kidney */
        ellipsoid(list, 20, 0.29 * side, 0.27, -0.62, 0.05, 0.04, 0.08);  /* its pelvis */
    }
    static const double bowel[][3] = {{-0.45, -0.1, -0.92}, {-0.42, -0.2, -0.72}, {-0.2, -0.33, -0.70},
                                      {0.05, -0.36, -0.76}, {0.3, -0.3, -0.72},   {0.46, -0.12, -0.74},
                                      {0.48, -0.02, -0.95}};
    tube(list, 40, bowel, COUNT(bowel), 1, 0.085);
    tube(list, -20, bowel, COUNT(bowel), 1, 0.065);
    static const double gas[][3] = {{-0.3, -0.3, -0.70}, {-0.1, -0.37, -0.72}, {0.05, -0.39, -0.755}};
    tube(list, CT_AIR, gas, COUNT(gas), 1, 0.04);
}

static void airways(struct ct_part_list *list)
{
    static const double trachea[][3] = {{0, -0.08, 1.1}, {0, -0.03, 0.52}};
    static const double bronchus[][3] = {{0, -0.03, 0.52}, {0.16, 0.02, 0.36}, {0.28, 0.05, 0.2}};
    tube(list, 30, trachea, COUNT(trachea), 1, 0.055);
    for (int side = -1; side <= 1; side += 2)
        tube(list, 30, bronchus, COUNT(bronchus), side, 0.036);
    tube(list, CT_AIR, trachea, COUNT(trachea), 1, 0.042);
    for (int side = -1; side <= 1; side += 2)
        tube(list, CT_AIR, bronchus, COUNT(bronchus), side, 0.026);
}

static void heart(struct ct_part_list *list)
{
    ellipsoid(list, -90, 0.12, -0.20, 0.08, 0.30, 0.28, 0.30);      /* fat in the pericardium */
    ellipsoid(list, 110, 0.13, -0.20, 0.06, 0.27, 0.25, 0.27);      /* muscle */
    ellipsoid(list, CONTRAST, 0.21, -0.16, 0.02, 0.11, 0.12, 0.16); /* left ventricle */
    ellipsoid(list, 300, 0.03, -0.28, 0.03, 0.12, 0.11, 0.16);      /* right ventricle */
    ellipsoid(list, 320, 0.10, -0.03, 0.20, 0.16, 0.10, 0.10);      /* left atrium */
    static const double coronary[][3] = {{0.1, -0.2, 0.32},
                                         {0.2, -0.36, 0.25},
                                         {0.25, -0.44, 0.12},
                                         {0.26, -0.43, -0.03},
                                         {0.22, -0.36, -0.15}};
    tube(list, CONTRAST, coronary, COUNT(coronary), 1, 0.010);
    static const double right[][3] = {
        {0.05, -0.25, 0.3}, {-0.08, -0.38, 0.2}, {-0.13, -0.33, 0.02}, {-0.08, -0.25, -0.12}};
    tube(list, CONTRAST, right, COUNT(right), 1, 0.008);
}

/* Where the spine runs: bent forward in the small of the back. */
static double spine_y(double z)
{
    return 0.37 + 0.10 * (z - 0.1) * (z - 0.1) - 0.05 * z;
}

static double vertebra_z(int k)
{
    return -0.98 + 0.155 * k;
}

static void spine(struct ct_part_list *list)
{
    enum { VERTEBRAE = 14 };
    for (int k = 0; k < VERTEBRAE; k++) {
        const double z = vertebra_z(k), y = spine_y(z), size = 1.1 - 0.025 * k;
        ellipsoid(list, 80, 0, y, z + 0.0775, 0.11 * size, 0.09 * size, 0.026); /* disc */
        ellipsoid(list, CORTEX, 0, y, z, 0.125 * size, 0.10 * size, 0.076);
        ellipsoid(list, MARROW, 0, y, z, 0.113 * size, 0.088 * size, 0.064);
        const double spinous[2][3] = {{0, y + 0.19, z}, {0, y + 0.27, z - 0.09}};
        tube(list, CORTEX, spinous, 2, 1, 0.018);
        for (int side = -1; side <= 1; side += 2) {
            const double arch[3][3] = {{0.07, y + 0.06, z}, {0.075, y + 0.13, z}, {0, y + 0.19, z}};
            const double transverse[2][3] = {{0.075, y + 0.11, z}, {0.2, y + 0.15, z}};
            tube(list, CORTEX, arch, 3, side, 0.024);
            tube(list, CORTEX, transverse, 2, side, 0.020);
            tube(list, MARROW, transverse, 2, side, 0.010);
        }
    }
    for (int k = 0; k + 1 < VERTEBRAE; k++) { /* the canal: fluid, and the cord in it */
        const double z = vertebra_z(k), above = vertebra_z(k + 1);
        const double canal[2][3] = {{0, spine_y(z) + 0.125, z}, {0, spine_y(above) + 0.125, above}};
        tube(list, 10, canal, 2, 1, 0.038);
        tube(list, 45, canal, 2, 1, 0.020);
    }
}

/* Half of a cross-section of the rib cage at height z: a cage narrowing towards the neck. */
static double cage(double z)
{
    const double t = (z - 0.05) / 1.12;
    return t * t < 0.96 ? sqrt(1 - t * t) : 0.2;
}

static void ribs(struct ct_part_list *list)
{
    enum { RIBS = 11, POINTS = 13 };
    const double x_axis = 0.79, y_axis = 0.60;
    for (int pass = 0; pass < 2; pass++) /* all walls, then all cores, so that no wall crosses a core */
        for (int k = 0; k < RIBS; k++) {
            const double z_back = vertebra_z(k + 3) + 0.03;
            const bool floating = k < 2;
            const unsigned points = floating ? 8 : POINTS;
            double path[POINTS][3];
            for (unsigned i = 0; i < points; i++) {
                const double t = (double)i / (POINTS - 1);
                const double turns = 0.215 - 0.385 * t; /* from beside the spine to beside the breastbone */
                const double z = z_back - 0.40 * t + 0.12 * t * t;
                path[i][0] = x_axis * cage(z) * synth_cos_turns(turns);
                path[i][1] = y_axis * cage(z) * synth_cos_turns(turns - 0.25);
                path[i][2] = z;
            }
            for (int side = -1; side <= 1; side += 2)
                tube(list, pass ? MARROW : CORTEX, path, points, side, pass ? 0.012 : 0.022);
            if (floating || pass)
                continue;
            const double *end = path[POINTS - 1];
            const double z_front = end[2] + 0.10;
            const double cartilage[2][3] = {{end[0], end[1], end[2]},
                                            {0.05, -0.60, z_front < 0.05 ? 0.05 : z_front}};
            for (int side = -1; side <= 1; side += 2)
                tube(list, 130, cartilage, 2, side, 0.018);
        }
    ellipsoid(list, CORTEX, 0, -0.60, 0.36, 0.065, 0.024, 0.32); /* breastbone */
    ellipsoid(list, MARROW, 0, -0.60, 0.36, 0.054, 0.014, 0.308);
}

static void girdles(struct ct_part_list *list)
{
    static const double clavicle[][3] = {
        {0.07, -0.52, 0.70}, {0.25, -0.50, 0.80}, {0.45, -0.36, 0.86}, {0.66, -0.20, 0.86}};
    for (int pass = 0; pass < 2; pass++)
        for (int side = -1; side <= 1; side += 2)
            tube(list, pass ? MARROW : CORTEX, clavicle, COUNT(clavicle), side, pass ? 0.016 : 0.028);
    for (int side = -1; side <= 1; side += 2) {
        struct ct_part *scapula = add(list); /* the rear of a flat egg about the ribs */
        *scapula = (struct ct_part){.kind = CT_SHELL, .hu = 900, .thickness = 0.014};
        const double centre[3] = {0.50 * side, 0.33, 0.52}, axes[3] = {0.20, 0.14, 0.26};
        struct ct_part *hip = add(list); /* half of a bowl */
        *hip = (struct ct_part){.kind = CT_SHELL, .hu = 1000, .thickness = 0.022};
        const double bowl[3] = {0, 0.02, -0.62}, bowl_axes[3] = {0.66, 0.50, 0.60};
        for (int i = 0; i < 3; i++) {
            scapula->a[i] = centre[i], scapula->b[i] = axes[i];
            hip->a[i] = bowl[i], hip->b[i] = bowl_axes[i];
        }
        scapula->plane[0] = (struct ct_plane){{0, 1, 0}, -0.37};
        scapula->plane[1] = (struct ct_plane){{0.6 * side, 0, 0.8}, -0.6 * 0.50 - 0.8 * 0.36};
        hip->plane[0] = (struct ct_plane){{0.8 * side, 0.6, 0}, -0.24};
        hip->plane[1] = (struct ct_plane){{0, 0.28, -0.96}, -0.64};
    }
    ellipsoid(list, CORTEX, 0, 0.50, -1.02, 0.24, 0.07, 0.20); /* sacrum */
    ellipsoid(list, MARROW, 0, 0.50, -1.02, 0.225, 0.055, 0.185);
}

static void great_vessels(struct ct_part_list *list)
{
    static const double aorta[][3] = {{0.10, -0.12, 0.20}, {0.02, -0.17, 0.42}, {0.03, -0.12, 0.54},
                                      {0.09, 0.04, 0.58},  {0.13, 0.18, 0.50},  {0.13, 0.22, 0.20},
                                      {0.10, 0.21, -0.2},  {0.05, 0.22, -0.72}};
    static const double iliac[][3] = {{0.05, 0.22, -0.72}, {0.16, 0.14, -0.88}, {0.28, 0.0, -1.05}};
    static const double cava[][3] = {{-0.09, 0.20, -1.05}, {-0.10, 0.18, -0.3}, {-0.04, 0.05, 0.12}};
    static const double carotid[][3] = {{0.05, -0.06, 0.56}, {0.10, -0.07, 0.75}, {0.11, -0.05, 1.05}};
    static const double subclavian[][3] = {
        {0.07, 0.0, 0.58}, {0.2, -0.1, 0.78}, {0.42, -0.2, 0.82}, {0.7, -0.1, 0.80}};
    static const double renal[][3] = {{0.05, 0.22, -0.60}, {0.16, 0.24, -0.61}, {0.27, 0.28, -0.62}};
    static const double lumbar[][3] = {{0.05, 0.25, 0}, {0.14, 0.36, 0}, {0.2, 0.52, 0}};
    tube(list, 160, cava, COUNT(cava), 1, 0.048);
    tube(list, CONTRAST, aorta, COUNT(aorta), 1, 0.052);
    for (int side = -1; side <= 1; side += 2) {
        tube(list, CONTRAST, iliac, COUNT(iliac), side, 0.028);
        tube(list, CONTRAST, carotid, COUNT(carotid), side, 0.020);
        tube(list, CONTRAST, subclavian, COUNT(subclavian), side, 0.020);
        tube(list, CONTRAST, renal, COUNT(renal), side, 0.014);
        for (int k = 2; k < 10; k++) { /* a pair of fine arteries at every vertebra */
            double path[COUNT(lumbar)][3];
            for (unsigned i = 0; i < COUNT(lumbar); i++) {
                path[i][0] = lumbar[i][0];
                path[i][1] = lumbar[i][1];
                path[i][2] = vertebra_z(k) + 0.0775 - 0.03 * i;
            }
            tube(list, CONTRAST, path, COUNT(lumbar), side, 0.005);
        }
    }
}

static void organ_vessels(struct ct_part_list *list)
{
    for (int side = -1; side <= 1; side += 2) {
        const double kidney[3] = {0.34 * side, 0.28, -0.62}, kidney_axes[3] = {0.10, 0.10, 0.17};
        struct tree renal = {list, kidney, kidney_axes, 5};
        const double gate[3] = {0.27 * side, 0.28, -0.62}, out[3] = {side, 0, 0};
        grow(&renal, gate, out, 0.05, 0.008, 3);
    }
    const double liver[3] = {-0.34, -0.06, -0.34}, liver_axes[3] = {0.40, 0.46, 0.36};
    struct tree hepatic = {list, liver, liver_axes, 11};
    static const double celiac[][3] = {{0.06, 0.2, -0.42}, {0.0, 0.05, -0.44}, {-0.12, 0.0, -0.42}};
    tube(list, CONTRAST, celiac, COUNT(celiac), 1, 0.018);
    const double right[3] = {-1, 0.3, 0.3}, left[3] = {-0.6, -0.8, 0.2};
    grow(&hepatic, celiac[2], right, 0.16, 0.018, 5);
    grow(&hepatic, celiac[2], left, 0.15, 0.016, 4);
    const double bowels[3] = {0, -0.08, -0.72}, bowel_axes[3] = {0.66, 0.46, 0.46};
    struct tree mesenteric = {list, bowels, bowel_axes, 3};
    const double root[3] = {0.05, 0.2, -0.55}, forward[3] = {0.1, -1, -0.5};
    grow(&mesenteric, root, forward, 0.20, 0.016, 5);
}

void synth_ct_body(struct ct_part_list *list)
{
    list->count = 0;
    trunk(list);
    lungs(list);
    belly(list);
    airways(list);
    heart(list);
    organ_vessels(list);
    great_vessels(list);
    girdles(list);
    ribs(list);
    spine(list);
}
