/* Opacity A = 1 - exp(-x), x being extinction times a slice's spacing. Colour that is emitted in proportion
 * to extinction is stored as it is, and multiplied by the interpolated opacity when it is drawn; colour that
 * is emitted independently is stored as what a slice lets out of it, E (1 - exp(-x)) / x, as in the paper,
 * with its limit E where nothing is absorbed. Channels of 8 and 16 bits are rounded to the nearest. */
#include "palette.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void classify(const struct vr_palette *p, double stored, double rgba[4])
{
    double sigma, emitted = 1.0;
    memset(rgba, 0, 4 * sizeof *rgba);
    if (!isfinite(stored))
        return;
    brick_transfer_eval(&p->transfer, stored * p->slope + p->intercept, rgba, &sigma);
    double x = sigma * p->spacing_mm;
    rgba[3] = -expm1(-x);
    if (p->transfer.emission == BRICK_EMISSION_INDEPENDENT)
        emitted = p->spacing_mm / p->transfer.unit_mm * (x > 0.0 ? rgba[3] / x : 1.0);
    for (int c = 0; c < 3; c++)
        rgba[c] *= emitted;
}

/* To entry i of a list. */
static void store(const struct vr_palette *p, const double rgba[4], void *list, size_t i)
{
    for (size_t c = 0; c < 4; c++) {
        double v = fmin(rgba[c], 1.0);
        if (p->bits == 8)
            ((uint8_t *)list)[4 * i + c] = (uint8_t)lrint(v * 255.0);
        else if (p->bits == 16)
            ((uint16_t *)list)[4 * i + c] = (uint16_t)lrint(v * 65535.0);
        else
            ((float *)list)[4 * i + c] = (float)rgba[c];
    }
}

static void copy_entry(const struct vr_palette *p, size_t entry, void *out, size_t i)
{
    const size_t bytes = p->texels.voxels.bytes;
    memcpy((char *)out + i * bytes, (const char *)p->entries + entry * bytes, bytes);
}

static void convert(const struct vr_texels *texels, const void *stored, size_t count, void *out)
{
    const struct vr_palette *p = (const struct vr_palette *)texels; /* its first member */
    double rgba[4];
    switch (p->stored) {
    case BRICK_U8:
        for (size_t i = 0; i < count; i++)
            copy_entry(p, ((const uint8_t *)stored)[i], out, i);
        break;
    case BRICK_I8:
        for (size_t i = 0; i < count; i++)
            copy_entry(p, (size_t)(((const int8_t *)stored)[i] - INT8_MIN), out, i);
        break;
    case BRICK_U16:
        for (size_t i = 0; i < count; i++)
            copy_entry(p, ((const uint16_t *)stored)[i], out, i);
        break;
    case BRICK_I16:
        for (size_t i = 0; i < count; i++)
            copy_entry(p, (size_t)(((const int16_t *)stored)[i] - INT16_MIN), out, i);
        break;
    default:
        for (size_t i = 0; i < count; i++) {
            classify(p, (double)((const float *)stored)[i], rgba);
            store(p, rgba, out, i);
        }
    }
}

static bool same(const struct vr_palette *p, const struct brick_transfer *t, double spacing_mm, uint32_t bits)
{
    return p->texels.number && p->bits == bits && p->spacing_mm == spacing_mm &&
           p->transfer.emission == t->emission && p->transfer.unit_mm == t->unit_mm &&
           p->transfer.count == t->count && !memcmp(p->transfer.knots, t->knots, t->count * sizeof *t->knots);
}

static int fill(struct vr_palette *p, struct brick_error *err)
{
    const bool wide = p->stored == BRICK_U16 || p->stored == BRICK_I16;
    const size_t values = wide ? 65536 : 256;
    const double least = p->stored == BRICK_I8 ? INT8_MIN : p->stored == BRICK_I16 ? INT16_MIN : 0;
    double rgba[4];
    if (p->stored == BRICK_F32)
        return BRICK_OK;
    if (values * p->texels.voxels.bytes > p->room) {
        free(p->entries);
        p->room = values * p->texels.voxels.bytes;
        p->entries = malloc(p->room);
    }
    if (!p->entries) {
        p->room = 0;
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for %zu classified values", values);
    }
    for (size_t i = 0; i < values; i++) {
        classify(p, least + (double)i, rgba);
        store(p, rgba, p->entries, i);
    }
    return BRICK_OK;
}

int vr_palette_set(struct vr_palette *p, const struct vr_frame *frame, double spacing_mm, uint32_t bits,
                   struct brick_error *err)
{
    static const struct vr_atlas_voxels eight = {
        .internal = GL_RGBA8, .format = GL_RGBA, .type = GL_UNSIGNED_BYTE, .bytes = 4};
    static const struct vr_atlas_voxels sixteen = {
        .internal = GL_RGBA16, .format = GL_RGBA, .type = GL_UNSIGNED_SHORT, .bytes = 8};
    static const struct vr_atlas_voxels floats = {
        .internal = GL_RGBA32F, .format = GL_RGBA, .type = GL_FLOAT, .bytes = 16};
    const struct brick_transfer *t = frame->scene->transfer;
    if (same(p, t, spacing_mm, bits))
        return BRICK_OK;
    struct brick_transfer_knot *knots = malloc(t->count * sizeof *knots);
    if (!knots)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a transfer function of %zu knots", t->count);
    memcpy(knots, t->knots, t->count * sizeof *knots);
    free(p->transfer.knots);
    p->transfer = (struct brick_transfer){
        .knots = knots, .count = t->count, .unit_mm = t->unit_mm, .emission = t->emission};
    p->stored = frame->grid->type;
    p->slope = frame->grid->slope;
    p->intercept = frame->grid->intercept;
    p->spacing_mm = spacing_mm;
    p->bits = bits;
    p->texels.voxels = bits == 8 ? eight : bits == 16 ? sixteen : floats;
    p->texels.convert = convert;
    p->texels.number++;
    int result = fill(p, err);
    if (result)
        p->bits = 0; /* like nothing that is asked for */
    return result;
}

void vr_palette_finish(struct vr_palette *p)
{
    free(p->transfer.knots);
    free(p->entries);
    *p = (struct vr_palette){0};
}
