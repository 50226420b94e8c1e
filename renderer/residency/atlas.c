/* The cache texture. Integer types are integer textures, fetched without filtering, so that every stored
 * value comes back exactly; slots keep their size for the renderer's life. */
#include "atlas.h"

static void slot_shape(const struct brick_grid *grid, int size[3], uint64_t *bytes)
{
    *bytes = brick_type_bytes(grid->type);
    for (int a = 0; a < 3; a++) {
        uint64_t core = grid->dims[a] < grid->edge ? grid->dims[a] : grid->edge;
        size[a] = (int)core + 2 * (int)grid->border;
        *bytes *= (uint64_t)size[a];
    }
}

static void slot_limit(const struct vr_context *context, const int size[3], int limit[3])
{
    for (int a = 0; a < 3; a++) {
        limit[a] = (a < 2 ? context->max_texture_2d : context->max_layers) / size[a];
        if (limit[a] > VR_ATLAS_MAX_SLOTS)
            limit[a] = VR_ATLAS_MAX_SLOTS;
    }
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

int vr_atlas_init(struct vr_atlas *atlas, struct vr_context *context, const struct brick_grid *grid,
                  uint64_t budget_bytes, struct brick_error *err)
{
    static const struct {
        GLenum internal, format, type;
    } formats[BRICK_TYPE_STORED_COUNT] = {
        [BRICK_U8] = {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE},
        [BRICK_I8] = {GL_R8I, GL_RED_INTEGER, GL_BYTE},
        [BRICK_U16] = {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT},
        [BRICK_I16] = {GL_R16I, GL_RED_INTEGER, GL_SHORT},
        [BRICK_F32] = {GL_R32F, GL_RED, GL_FLOAT},
    };
    const struct vr_gl *gl = &context->gl;
    const struct brick_level *level = &grid->level[0];
    uint64_t bricks = level->bricks[0] * level->bricks[1] * level->bricks[2];
    uint64_t budget = budget_bytes < VR_ATLAS_MAX_BYTES ? budget_bytes : VR_ATLAS_MAX_BYTES;
    int limit[3], result;

    *atlas = (struct vr_atlas){.format = formats[grid->type].format, .type = formats[grid->type].type};
    slot_shape(grid, atlas->slot_size, &atlas->slot_bytes);
    slot_limit(context, atlas->slot_size, limit);
    if (!vr_atlas_arrange(bricks, budget / atlas->slot_bytes, limit, atlas->slots))
        return brick_fail(
            err, BRICK_ERR_MEMORY,
            "a GPU cache of %llu bytes does not hold one brick of %d x %d x %d voxels (%llu bytes)",
            (unsigned long long)budget_bytes, atlas->slot_size[0], atlas->slot_size[1], atlas->slot_size[2],
            (unsigned long long)atlas->slot_bytes);
    atlas->count = (uint32_t)(atlas->slots[0] * atlas->slots[1] * atlas->slots[2]);

    gl->GenTextures(1, &atlas->texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, atlas->texture);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->TexStorage3D(GL_TEXTURE_2D_ARRAY, 1, formats[grid->type].internal,
                     atlas->slots[0] * atlas->slot_size[0], atlas->slots[1] * atlas->slot_size[1],
                     atlas->slots[2] * atlas->slot_size[2]);
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
                      (GLsizei)stored[0], (GLsizei)stored[1], (GLsizei)stored[2], atlas->format, atlas->type,
                      (const void *)(uintptr_t)at_byte);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
}
