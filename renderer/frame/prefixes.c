/* Prefix integrals in closed form: extinction and colour are linear in a piece. Sums are in long double, so
 * what a difference of two prefixes lacks is their rounding to double. */
#include "prefixes.h"

#include <math.h>
#include <stdlib.h>

/* Colour moments are taken about the middle of S over the piece, where a constant colour has none, and then
 * moved: for colour c0 + t (c1 - c0) and extinction linear from s0 to s1 over a width w,
 *
 *     integral of t (S - middle) dS = w^2 (m^2 / 12 - h^2 / 60),   m = (s0 + s1) / 2, h = (s1 - s0) / 2. */
int vr_prefixes_create(struct vr_prefix **prefixes, const struct vr_transfer_table *table,
                       struct brick_error *err)
{
    struct vr_prefix *out = calloc(table->count, sizeof *out);
    long double depth = 0.0L, colour[3] = {0.0L}, moment[3] = {0.0L};
    *prefixes = out;
    if (!out)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for the integrals of %u pieces", table->count);
    for (uint32_t i = 1; i + 1 < table->count; i++) {
        const struct vr_piece *p = &table->pieces[i];
        double w = (double)p->end - (double)p->start, along = (double)p->end - (double)p->origin;
        double s0 = fmax(0.0, (double)p->sigma),
               s1 = fmax(0.0, (double)p->sigma + (double)p->sigma_slope * along);
        double m = 0.5 * (s0 + s1), h = 0.5 * (s1 - s0), grown = w * m;
        for (int c = 0; c < 3; c++) {
            double c0 = (double)p->rgb[c], c1 = fmin(fmax(c0 + (double)p->rgb_slope[c] * along, 0.0), 1.0);
            double sum = w * (c0 * (2.0 * s0 + s1) + c1 * (s0 + 2.0 * s1)) / 6.0;
            moment[c] += (c1 - c0) * w * w * (m * m / 12.0 - h * h / 60.0) + sum * (depth + 0.5 * grown);
            colour[c] += sum;
            out[i + 1].colour[c] = (double)colour[c];
            out[i + 1].moment[c] = (double)moment[c];
        }
        depth += grown;
        out[i + 1].depth = (double)depth;
    }
    return BRICK_OK;
}
