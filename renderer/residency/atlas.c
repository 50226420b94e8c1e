/* The cache texture. What is not filtered is of the stored type, so that every value comes back exactly; so
 * it does from 16 normalised bits. Slots have one number of texels for the renderer's life, whatever these
 * hold. */
#include "atlas.h"

#include <string.h>

/* Filtered: coordinates of 2^-13 of a texel are exact in float32 up to here. */
#define MAX_FILTERED 2048

static int less(int a, int b)
{
    return a < b ? a : b;
}

static void slot_limit(const struct vr_context *context, const int size[3], int limit[3])
{
    for (int a = 0; a < 3; a++)
        limit[a] =
            less((a < 2 ? context->max_texture_2d : context->max_layers) / size[a], VR_ATLAS_MAX_SLOTS);
}

bool vr_atlas_arrange(uint64_t want, uint64_t most, const int limit[3], int slots[3])
{
    uint64_t best = 0;
    for (int z = 1; z <= limit[2]; z++)
        for (int y = 1; y <= limit[1]; y++) {
            uint64_t row = (uint64_t)y * (uint64_t)z, x = (want + row - 1) / row;
            if (x > most / row)
                x = most / row;
            if (x > (uint64_t)limit[0])
                x = (uint64_t)limit[0];
            uint64_t n = x * row;
            if (n == 0 || (best >= want ? n < want || n >= best : n <= best))
                continue;
            best = n;
            slots[0] = (int)x, slots[1] = y, slots[2] = z;
        }
    return best > 0;
}

bool vr_atlas_arrange_powers(uint64_t want, uint64_t texels, const int slot_size[3], const int limit[3],
                             int size[2], int slots[3])
{
    uint64_t best = 0, best_texels = 0;
    for (int y = 1; y <= limit[1]; y *= 2)
        for (int x = 1; x <= limit[0]; x *= 2) {
            const int across = less(x / slot_size[0], VR_ATLAS_MAX_SLOTS);
            const int down = less(y / slot_size[1], VR_ATLAS_MAX_SLOTS);
            const uint64_t row = (uint64_t)across * (uint64_t)down;
            const uint64_t slab = (uint64_t)x * (uint64_t)y * (uint64_t)slot_size[2];
            if (!row)
                continue;
            uint64_t z = (want + row - 1) / row;
            z = z < texels / slab ? z : texels / slab;
            z = z < (uint64_t)limit[2] ? z : (uint64_t)limit[2];
            const uint64_t n = z * row < want ? z * row : want; /* more are worth nothing */
            if (n < best || !n || (n == best && z * slab >= best_texels))
                continue;
            best = n;
            best_texels = z * slab;
            size[0] = x, size[1] = y;
            slots[0] = across, slots[1] = down, slots[2] = (int)z;
        }
    return best > 0;
}

static const struct vr_atlas_voxels *voxels_of(enum brick_type type, enum vr_filter filter)
{
    static const struct vr_atlas_voxels formats[][BRICK_TYPE_STORED_COUNT] = {
        [VR_FILTER_EXACT] = {[BRICK_U8] = {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1},
                             [BRICK_I8] = {GL_R8I, GL_RED_INTEGER, GL_BYTE, 1},
                             [BRICK_U16] = {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2},
                             [BRICK_I16] = {GL_R16I, GL_RED_INTEGER, GL_SHORT, 2},
                             [BRICK_F32] = {GL_R32F, GL_RED, GL_FLOAT, 4}},
        /* Rounding in [0,1]: one unit (2^-24) of the texel, and three halves for each of the interpolations
         * along x, y, z: 11 * 2^-25, times scale 0.021 of 16 bits, 0.000084 of 8. */
        [VR_FILTER_FAST] = {[BRICK_U8] = {GL_R16, GL_RED, GL_UNSIGNED_SHORT, 2, 255.0, 0.0, 4096},
                            [BRICK_I8] = {GL_R16, GL_RED, GL_UNSIGNED_SHORT, 2, 255.0, 128.0, 4096},
                            [BRICK_U16] = {GL_R16, GL_RED, GL_UNSIGNED_SHORT, 2, 65535.0, 0.0, 16},
                            [BRICK_I16] = {GL_R16, GL_RED, GL_UNSIGNED_SHORT, 2, 65535.0, 32768.0, 16},
                            [BRICK_F32] = {GL_R32F, GL_RED, GL_FLOAT, 4}},
    };
    return &formats[filter][type];
}

int vr_atlas_init(struct vr_atlas *atlas, struct vr_context *context, const struct brick_grid *grid,
                  enum vr_filter filter, const struct vr_texels *texels, uint64_t budget_bytes,
                  struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    const struct brick_level *level = &grid->level[0];
    uint64_t bricks = level->bricks[0] * level->bricks[1] * level->bricks[2];
    uint64_t budget = budget_bytes < VR_ATLAS_MAX_BYTES ? budget_bytes : VR_ATLAS_MAX_BYTES;
    const bool filtered = filter == VR_FILTER_FAST && !texels;
    bool fits;
    int limit[3], result;

    *atlas = (struct vr_atlas){.filter = texels ? VR_FILTER_EXACT : filter,
                               .stored = grid->type,
                               .texels = texels,
                               .voxels = texels ? texels->voxels : *voxels_of(grid->type, filter)};
    atlas->slot_bytes = atlas->voxels.bytes;
    for (int a = 0; a < 3; a++) {
        uint64_t core = grid->dims[a] < grid->edge ? grid->dims[a] : grid->edge;
        atlas->slot_size[a] = (int)core + 2 * (int)grid->border;
        atlas->slot_bytes *= (uint64_t)atlas->slot_size[a];
    }
    slot_limit(context, atlas->slot_size, limit);
    if (filtered)
        fits = vr_atlas_arrange_powers(bricks, budget / atlas->voxels.bytes, atlas->slot_size,
                                       (int[]){less(context->max_texture_2d, MAX_FILTERED),
                                               less(context->max_texture_2d, MAX_FILTERED), limit[2]},
                                       atlas->size, atlas->slots);
    else
        fits = vr_atlas_arrange(bricks, budget / atlas->slot_bytes, limit, atlas->slots);
    if (!fits)
        return brick_fail(
            err, BRICK_ERR_MEMORY,
            "a GPU cache of %llu bytes does not hold one brick of %d x %d x %d voxels (%llu bytes%s)",
            (unsigned long long)budget_bytes, atlas->slot_size[0], atlas->slot_size[1], atlas->slot_size[2],
            (unsigned long long)atlas->slot_bytes,
            filtered ? ", width and height filled up to powers of two" : "");
    atlas->count = 1;
    atlas->bytes = atlas->voxels.bytes;
    for (int a = 0; a < 3; a++) {
        if (!filtered || a == 2)
            atlas->size[a] = atlas->slots[a] * atlas->slot_size[a];
        atlas->count *= (uint32_t)atlas->slots[a];
        atlas->bytes *= (uint64_t)atlas->size[a];
    }

    gl->GenTextures(1, &atlas->texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, atlas->texture);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, filtered ? GL_LINEAR : GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, filtered ? GL_LINEAR : GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl->TexStorage3D(GL_TEXTURE_2D_ARRAY, 1, atlas->voxels.internal, atlas->size[0], atlas->size[1],
                     atlas->size[2]);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    result = vr_context_check(context, "GPU cache texture", err);
    if (result)
        vr_atlas_finish(atlas, context);
    return result;
}

void vr_atlas_finish(struct vr_atlas *atlas, struct vr_context *context)
{
    if (atlas->texture)
        context->gl.DeleteTextures(1, &atlas->texture);
    *atlas = (struct vr_atlas){0};
}

void vr_atlas_use(const struct vr_atlas *atlas, struct vr_context *context, GLuint unit)
{
    context->gl.ActiveTexture(GL_TEXTURE0 + unit);
    context->gl.BindTexture(GL_TEXTURE_2D_ARRAY, atlas->texture);
    context->gl.ActiveTexture(GL_TEXTURE0);
}

void vr_atlas_slot_place(const struct vr_atlas *atlas, uint32_t slot, uint32_t at[3])
{
    uint32_t nx = (uint32_t)atlas->slots[0], ny = (uint32_t)atlas->slots[1];
    at[0] = slot % nx;
    at[1] = slot / nx % ny;
    at[2] = slot / (nx * ny);
}

void vr_atlas_convert(const struct vr_atlas *atlas, const void *stored, size_t count, void *out)
{
    const enum brick_type type = atlas->voxels.scale > 0.0 ? atlas->stored : BRICK_F32;
    const uint8_t *narrow = stored;
    const uint16_t *wide = stored;
    uint16_t *texels = out;
    const unsigned flip = atlas->voxels.offset > 0.0; /* the sign bit: lowest value to 0 */
    if (atlas->texels)
        atlas->texels->convert(atlas->texels, stored, count, out);
    else if (type == BRICK_U8 || type == BRICK_I8)
        for (size_t i = 0; i < count; i++)
            texels[i] = (uint16_t)((narrow[i] ^ flip << 7) * 257);
    else if (type == BRICK_I16)
        for (size_t i = 0; i < count; i++)
            texels[i] = (uint16_t)(wide[i] ^ flip << 15);
    else
        memcpy(out, stored, count * atlas->voxels.bytes);
}

void vr_atlas_upload(const struct vr_atlas *atlas, struct vr_context *context, uint32_t slot,
                     const uint32_t stored[3], size_t at_byte)
{
    const struct vr_gl *gl = &context->gl;
    uint32_t at[3];
    vr_atlas_slot_place(atlas, slot, at);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, atlas->texture);
    gl->TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, (GLint)at[0] * atlas->slot_size[0],
                      (GLint)at[1] * atlas->slot_size[1], (GLint)at[2] * atlas->slot_size[2],
                      (GLsizei)stored[0], (GLsizei)stored[1], (GLsizei)stored[2], atlas->voxels.format,
                      atlas->voxels.type, (const void *)(uintptr_t)at_byte);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
}
