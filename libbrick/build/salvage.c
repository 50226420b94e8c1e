/* A brick's payload is right if its checksum says so and, at level 0, its ranges are those of its voxels. Of
 * an index whose checksum is wrong no more is believed than what a payload confirms. */
#include "salvage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH = 4096 };

uint64_t salvage_bytes(const struct brick_grid *grid, unsigned threads)
{
    uint64_t payload = brick_grid_max_payload_bytes(grid);
    return grid->bricks + threads * (encoder_bytes(grid) + 3 * payload + agree_face_bytes(grid) +
                                     agree_coarse_bytes(grid) + 2 * payload);
}

int salvage_init(struct salvage *s, struct brick_volume *volume, const struct brick_damage *damage,
                 unsigned threads, struct brick_error *err)
{
    *s = (struct salvage){.volume = volume, .grid = brick_volume_grid(volume), .damage = *damage};
    double tolerance = brick_volume_tolerance(volume);
    if (tolerance > 0.0)
        s->tolerance = brick_codec_tolerance(s->grid->type, s->grid->slope, tolerance);
    int code = brick_pool_create(&s->pool, threads, err);
    if (code)
        return code;
    s->threads = brick_pool_threads(s->pool);
    size_t payload = brick_grid_max_payload_bytes(s->grid);
    s->state = calloc(s->grid->bricks, 1);
    s->workers = calloc(s->threads, sizeof *s->workers);
    bool ok = s->state && s->workers;
    for (unsigned t = 0; ok && t < s->threads; t++) {
        struct salvage_worker *w = &s->workers[t];
        if ((code = encoder_init(&w->encoder, kernels_best(), s->grid, err)))
            return code;
        w->macrocells = malloc(payload);
        w->face = malloc(agree_face_bytes(s->grid));
        w->coarse = malloc(agree_coarse_bytes(s->grid));
        w->part[0] = malloc(payload);
        w->part[1] = malloc(payload);
        ok = w->macrocells && w->face && w->coarse && w->part[0] && w->part[1];
    }
    return ok ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", brick_volume_path(volume));
}

void salvage_finish(struct salvage *s)
{
    for (unsigned t = 0; s->workers && t < s->threads; t++) {
        struct salvage_worker *w = &s->workers[t];
        encoder_finish(&w->encoder);
        brick_scratch_finish(&w->scratch);
        free(w->macrocells);
        free(w->face);
        free(w->coarse);
        free(w->part[0]);
        free(w->part[1]);
    }
    free(s->workers);
    free(s->state);
    brick_pool_destroy(&s->pool);
    *s = (struct salvage){0};
}

bool salvage_judge(const struct salvage *s, struct salvage_worker *w, const struct brick_place *place,
                   struct brick_entry *entry, bool *complete)
{
    enum brick_type type = s->grid->type;
    struct brick_entry own = {0};
    const unsigned char *stored = w->encoder.payload + brick_place_voxel_bytes(s->grid, place);
    size_t cells = (size_t)place->macrocells[0] * place->macrocells[1] * place->macrocells[2];
    double min = INFINITY, max = -INFINITY;
    for (size_t i = 0; i < cells; i++) {
        min = fmin(min, brick_type_load(type, stored, 2 * i));
        max = fmax(max, brick_type_load(type, stored, 2 * i + 1));
    }
    struct brick_entry claimed = *entry;
    claimed.min = (float)min;
    claimed.max = (float)max;
    claimed.nonfinite = 0;
    /* Above level 0 a mask depends on level 0; without NaN and Inf it is full, and which files have them
     * this brick does not know. */
    claimed.mask = !(min <= max) ? 0 : min == max ? 1 : ~UINT64_C(0);
    *complete = place->level == 0 || (type != BRICK_F32 && s->tolerance == 0.0);
    if (place->level == 0) { /* of its range and mask the voxels are the judges */
        encode_ranges(s->grid, place, w->encoder.payload, NULL, NULL, w->macrocells, &w->encoder, &own);
        claimed.mask = own.mask;
    }
    if (agree_ranges(s->grid, place, &claimed, &w->encoder, w->macrocells, &own))
        return false;
    *entry = claimed;
    return true;
}

/* A codec's number is confirmed by the payload; zstd and zstd-delta are told apart by the ranges. */
static bool codec_agrees(const struct salvage *s, const struct salvage_worker *w,
                         const struct brick_place *place, const struct brick_entry *e)
{
    struct brick_codec_shape shape = brick_codec_shape(s->grid, place);
    return e->flags & BRICK_FLAG_CONSTANT || brick_codec_is_lossy((enum brick_codec)e->codec) ||
           brick_codec_measure((enum brick_codec)e->codec, &shape, w->scratch.data, e->bytes) == e->bytes;
}

static int read_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct salvage *s = context;
    struct salvage_worker *w = &s->workers[worker];
    uint64_t id = s->first + item;
    struct brick_entry entry = *brick_volume_entry(s->volume, id), was = entry;
    struct brick_place place;
    struct brick_error inner = {0};
    bool constant = entry.flags & BRICK_FLAG_CONSTANT, complete, sure = !s->damage.index;
    if (!constant && !entry.bytes)
        return BRICK_OK;
    brick_grid_place(s->grid, id, &place);
    int code = brick_volume_read(s->volume, id, w->encoder.payload, &w->scratch, &inner);
    if (code == BRICK_ERR_MEMORY || code == BRICK_ERR_UNSUPPORTED) {
        if (err)
            *err = inner;
        return code;
    }
    if (sure && !code && place.level > 0) { /* as it was written */
        s->state[id] = SALVAGE_VOXELS | SALVAGE_ENTRY;
    } else if (!code && salvage_judge(s, w, &place, &entry, &complete) &&
               (sure || constant ? entry.min == was.min && entry.max == was.max && entry.mask == was.mask
                                 : codec_agrees(s, w, &place, &entry))) {
        s->state[id] = SALVAGE_VOXELS;
        if (complete && !(constant && place.level > 0))
            s->state[id] |= SALVAGE_ENTRY;
        if (!sure)
            brick_volume_set_entry(s->volume, id, &entry);
    } else if (sure) {
        s->state[id] = SALVAGE_GONE;
    }
    return BRICK_OK;
}

int salvage_read(struct salvage *s, struct brick_error *err)
{
    int code = BRICK_OK;
    for (s->first = 0; !code && s->first < s->grid->bricks; s->first += BATCH) {
        uint64_t rest = s->grid->bricks - s->first;
        code = brick_pool_run(s->pool, rest < BATCH ? rest : BATCH, read_one, s, err);
        if (s->progress)
            s->progress(s->progress_context, s->first, s->grid->bricks);
    }
    return code;
}
