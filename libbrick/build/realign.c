/* Payloads whose index entries are lost. They lie one behind the other in the order of the bricks, and a
 * Blosc chunk tells its own length, so their sequence is known; constant bricks, which have none, leave gaps
 * in it. Where a payload belongs is what it must agree with: its size, the volume's edge, the voxels that it
 * shares with its neighbours, and the mean that the next level has of it. A payload is placed only where
 * there is one place for it; a brick before it becomes constant only if everything around it is.
 *
 * Where the file's end is known, work goes backward, so that coarser levels are placed before the finer ones
 * they vouch for. */
#include "salvage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum { FACES = 6, SCAN = 1 << 16, HEADER_BYTES = 512 };

/* A payload, decoded as a brick of some shape. */
struct piece {
    uint64_t start, bytes;
    bool tried, whole, complete;
    struct brick_place place; /* whose shape was tried */
    struct brick_entry entry;
    struct agree_face face[FACES];
};

struct finder {
    struct salvage *s;
    const struct brick_grid *grid;
    struct agree_face *face; /* FACES of each known brick: 2 * axis + high */
    enum brick_codec codec[2];
    int codecs;
    uint64_t *start; /* of payloads, ascending, as far as their lengths tell, and the end; NULL: codec none */
    uint64_t starts;
    struct piece piece;
    uint64_t parent; /* whose payload `above` holds */
    unsigned char *above, *stored;
    size_t stored_bytes;
    uint64_t passed[2]; /* bricks [.., ..) not known are constant, if the payload belongs where it is tried */
    bool mean, nearest; /* which of the two levels above may be made of */
};

static bool known(const struct finder *f, uint64_t id)
{
    return f->s->state[id] & SALVAGE_VOXELS;
}

static void faces_of(const struct finder *f, struct salvage_worker *w, const struct brick_place *place,
                     struct agree_face face[FACES])
{
    for (int i = 0; i < FACES; i++)
        face[i] = agree_face(f->grid, place, w->encoder.payload, i / 2, i % 2, true, w->face);
}

static int learn_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct finder *f = context;
    struct salvage_worker *w = &f->s->workers[worker];
    uint64_t id = f->s->first + item;
    struct brick_place place;
    if (!known(f, id))
        return BRICK_OK;
    brick_grid_place(f->grid, id, &place);
    int code = brick_volume_read(f->s->volume, id, w->encoder.payload, &w->scratch, err);
    if (!code)
        faces_of(f, w, &place, &f->face[id * FACES]);
    return code;
}

/* The neighbour beyond face i, or BRICK_NO_BRICK. */
static uint64_t neighbour(const struct finder *f, const struct brick_place *place, int i)
{
    uint64_t at[3] = {place->at[0], place->at[1], place->at[2]};
    at[i / 2] += i % 2 ? 1 : UINT64_MAX;
    if (at[i / 2] >= f->grid->level[place->level].bricks[i / 2])
        return BRICK_NO_BRICK;
    return brick_grid_id(f->grid, place->level, at[0], at[1], at[2]);
}

/* What the next level has of a brick, to worker 0's part[0]: its voxels' number, 0 where that is not known.
 */
static size_t seen_from_above(struct finder *f, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    if (place->level + 1 >= f->grid->levels)
        return 0;
    struct agree_part part = agree_part(f->grid, place);
    if (!known(f, part.parent))
        return 0;
    if (f->parent != part.parent && brick_volume_read(f->s->volume, part.parent, f->above, &w->scratch, NULL))
        return 0;
    f->parent = part.parent;
    struct brick_place parent;
    brick_grid_place(f->grid, part.parent, &parent);
    agree_take_part(f->grid, &parent, f->above, &part, w->part[0]);
    return (size_t)part.size[0] * part.size[1] * part.size[2];
}

/* Could a brick be constant? If its value is known *value is it, else NaN stays and *sure is false. */
static bool constant_possible(struct finder *f, const struct brick_place *place, bool *sure,
                              unsigned char value[8])
{
    struct salvage_worker *w = &f->s->workers[0];
    size_t width = brick_type_bytes(f->grid->type), n = seen_from_above(f, place);
    uint64_t hash = 0;
    *sure = false;
    if (n) {
        if (memcmp(w->part[0], w->part[0] + width, (n - 1) * width) != 0)
            return false;
        memcpy(value, w->part[0], width);
        hash = XXH3_64bits(value, width);
        *sure = true;
    }
    for (int i = 0; i < FACES; i++) {
        uint64_t id = neighbour(f, place, i);
        if (id == BRICK_NO_BRICK || !known(f, id))
            continue;
        const struct agree_face *face = &f->face[id * FACES + (unsigned)(i ^ 1)];
        if (!face->flat || (*sure && face->hash != hash))
            return false;
        if (!*sure) {
            struct brick_place its;
            brick_grid_place(f->grid, id, &its);
            size_t all = brick_place_voxel_bytes(f->grid, &its);
            if (brick_volume_read(f->s->volume, id, w->encoder.payload, &w->scratch, NULL))
                return false;
            f->piece.tried = false;
            memcpy(value, w->encoder.payload + (i % 2 ? 0 : all - width), width);
            hash = face->hash;
            *sure = true;
        }
    }
    return true;
}

/* Decode the payload at [start, start + bytes) as a brick of this shape. */
static void try_piece(struct finder *f, uint64_t start, uint64_t bytes, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    struct piece *p = &f->piece;
    if (p->tried && p->start == start && p->bytes == bytes && (p->place.level == 0) == (place->level == 0) &&
        memcmp(p->place.stored, place->stored, sizeof place->stored) == 0)
        return;
    *p = (struct piece){.start = start, .bytes = bytes, .tried = true, .place = *place};
    struct brick_codec_shape shape = brick_codec_shape(f->grid, place);
    if (bytes > f->stored_bytes ||
        brick_volume_read_bytes(f->s->volume, start, f->stored, (size_t)bytes, NULL))
        return;
    for (int c = 0; c < f->codecs && !p->whole; c++) {
        p->entry = (struct brick_entry){.offset = start,
                                        .bytes = (uint32_t)bytes,
                                        .codec = (uint8_t)f->codec[c],
                                        .checksum = XXH3_64bits(f->stored, (size_t)bytes)};
        p->whole =
            brick_codec_measure(f->codec[c], &shape, f->stored, (size_t)bytes) == bytes &&
            !brick_codec_decode(f->codec[c], &shape, f->stored, (size_t)bytes, w->encoder.payload, NULL) &&
            salvage_judge(f->s, w, place, &p->entry, &p->complete);
    }
    if (p->whole)
        faces_of(f, w, place, p->face);
}

/* Could the payload be this brick's? */
static bool fits(struct finder *f, uint64_t start, uint64_t bytes, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    size_t width = brick_type_bytes(f->grid->type), n = seen_from_above(f, place);
    try_piece(f, start, bytes, place);
    if (!f->piece.whole)
        return false;
    for (int i = 0; i < FACES; i++) {
        uint64_t id = neighbour(f, place, i);
        if (id == BRICK_NO_BRICK)
            continue;
        if (known(f, id) ? f->face[id * FACES + (unsigned)(i ^ 1)].hash != f->piece.face[i].hash
                         : id >= f->passed[0] && id < f->passed[1] && !f->piece.face[i].flat)
            return false;
    }
    if (!agree_edge_repeats(f->grid, place, w->encoder.payload, 0.0))
        return false;
    if (!n)
        return true;
    bool made[2] = {false, false};
    for (int nearest = 0; nearest < 2; nearest++) {
        agree_make_part(w->encoder.kernels, f->grid, place, w->encoder.payload, nearest, w->part[1],
                        w->coarse);
        made[nearest] = memcmp(w->part[0], w->part[1], n * width) == 0;
    }
    return (made[0] && f->mean) || (made[1] && f->nearest);
}

static void set_constant(struct finder *f, uint64_t id)
{
    struct brick_place place;
    unsigned char bytes[8];
    bool sure;
    brick_grid_place(f->grid, id, &place);
    if (known(f, id) || !constant_possible(f, &place, &sure, bytes) || !sure)
        return;
    float value = (float)brick_type_load(f->grid->type, bytes, 0);
    struct brick_entry e = {.flags = BRICK_FLAG_CONSTANT,
                            .min = isfinite(value) ? value : INFINITY,
                            .max = isfinite(value) ? value : -INFINITY,
                            .mask = isfinite(value)};
    memcpy(&e.value, &value, sizeof value);
    brick_volume_set_entry(f->s->volume, id, &e);
    f->s->state[id] = place.level == 0 ? SALVAGE_VOXELS | SALVAGE_ENTRY : SALVAGE_VOXELS;
    f->s->unconfirmed += place.level == 0;
    struct agree_face face = {XXH3_64bits(bytes, brick_type_bytes(f->grid->type)), true};
    for (int i = 0; i < FACES; i++)
        f->face[id * FACES + (unsigned)i] = face;
}

static void set_piece(struct finder *f, uint64_t id, const struct brick_place *place)
{
    const struct piece *p = &f->piece;
    brick_volume_set_entry(f->s->volume, id, &p->entry);
    f->s->state[id] = SALVAGE_VOXELS | (p->complete ? SALVAGE_ENTRY : 0);
    f->s->unconfirmed += place->level == 0;
    memcpy(&f->face[id * FACES], p->face, sizeof p->face);
}

/* A stretch of the file and the bricks whose payloads are all that is in it. */
struct gap {
    uint64_t first, end; /* bricks */
    uint64_t from, to;   /* bytes; to: not known when the file was cut there */
    bool closed;
};

/* The payload that begins, or going backward ends, at `at` if it is this brick's; its bytes, 0 if none. */
static uint64_t next_piece(const struct finder *f, const struct gap *gap, const struct brick_place *place,
                           uint64_t at, bool backward, uint64_t *start)
{
    uint64_t bytes = 0;
    if (!f->start) {
        bytes = brick_place_payload_bytes(f->grid, place);
        if (backward ? at - gap->from < bytes : gap->to - at < bytes)
            return 0;
    } else {
        uint64_t lo = 0, hi = f->starts; /* the first start that is not below at */
        while (lo < hi) {
            uint64_t middle = (lo + hi) / 2;
            if (f->start[middle] < at)
                lo = middle + 1;
            else
                hi = middle;
        }
        if (lo >= f->starts || f->start[lo] != at || (backward ? lo == 0 : lo + 1 == f->starts))
            return 0;
        bytes = backward ? at - f->start[lo - 1] : f->start[lo + 1] - at;
    }
    *start = backward ? at - bytes : at;
    return bytes;
}

/* Place what can be placed of a gap. */
static void fill_gap(struct finder *f, const struct gap *gap)
{
    bool backward = gap->closed, stop = false;
    uint64_t at = backward ? gap->to : gap->from, done = 0, all = gap->end - gap->first;
    const uint64_t goal = backward ? gap->from : gap->to;
    while (!stop && done < all && at != goal) {
        uint64_t found = 0, found_step = 0, bytes = 0, step = done;
        for (; step < all && step - done < SCAN && found < 2; step++) {
            uint64_t id = backward ? gap->end - 1 - step : gap->first + step, start;
            unsigned char value[8];
            bool sure;
            struct brick_place place;
            if (known(f, id))
                continue;
            brick_grid_place(f->grid, id, &place);
            f->passed[0] = backward ? id + 1 : gap->first + done;
            f->passed[1] = backward ? gap->end - done : id;
            uint64_t n = next_piece(f, gap, &place, at, backward, &start);
            if (n && fits(f, start, n, &place)) {
                found++;
                found_step = step;
                bytes = n;
            }
            if (id + 1 == f->grid->bricks || !constant_possible(f, &place, &sure, value))
                break;
        }
        stop = found != 1;
        if (stop)
            break;
        uint64_t id = backward ? gap->end - 1 - found_step : gap->first + found_step;
        struct brick_place place;
        brick_grid_place(f->grid, id, &place);
        try_piece(f, backward ? at - bytes : at, bytes, &place);
        set_piece(f, id, &place);
        for (step = done; step < found_step; step++)
            set_constant(f, backward ? gap->end - 1 - step : gap->first + step);
        done = found_step + 1;
        at = backward ? at - bytes : at + bytes;
    }
    if (at == goal && gap->closed) /* nothing is left for the others */
        for (int pass = 0; pass < 2; pass++)
            for (uint64_t i = 0; i < all; i++)
                set_constant(f, pass ? gap->first + i : gap->end - 1 - i);
}

/* Lengths of the payloads in [from, to): false when they do not add up. */
static bool walk(struct finder *f, uint64_t from, uint64_t to)
{
    uint64_t room = f->starts;
    unsigned char header[64];
    for (uint64_t at = from;;) {
        if (f->starts >= room) {
            room = room ? 2 * room : 1024;
            uint64_t *grown = realloc(f->start, room * sizeof *grown);
            if (!grown)
                return false;
            f->start = grown;
        }
        f->start[f->starts++] = at;
        size_t n = to - at < sizeof header ? (size_t)(to - at) : sizeof header;
        if (at >= to || brick_volume_read_bytes(f->s->volume, at, header, n, NULL))
            return at == to;
        uint64_t bytes = 0;
        for (int c = 0; c < f->codecs && !bytes; c++)
            bytes = brick_codec_measure(f->codec[c], NULL, header, n);
        if (!bytes || bytes > to - at)
            return false;
        at += bytes;
    }
}

/* The codec of the bricks that are known, or what the first payload looks like. */
static void choose_codecs(struct finder *f, uint64_t from)
{
    unsigned char header[64];
    for (uint64_t id = 0; id < f->grid->bricks; id++) {
        const struct brick_entry *e = brick_volume_entry(f->s->volume, id);
        if (known(f, id) && !(e->flags & BRICK_FLAG_CONSTANT)) {
            f->codec[0] = (enum brick_codec)e->codec;
            f->codecs = 1;
            return;
        }
    }
    f->codec[0] = BRICK_CODEC_NONE;
    f->codecs = 1;
    if (brick_volume_read_bytes(f->s->volume, from, header, sizeof header, NULL))
        return;
    int n = 0;
    for (int c = BRICK_CODEC_NONE + 1; c < BRICK_CODEC_COUNT && n < 2; c++)
        if (brick_codec_measure((enum brick_codec)c, NULL, header, sizeof header))
            f->codec[n++] = (enum brick_codec)c;
    f->codecs = n ? n : 1;
}

static void find(struct finder *f)
{
    const struct salvage *s = f->s;
    uint64_t payload_end = brick_volume_payload_end(s->volume), file_end = s->damage.bytes;
    struct gap gap = {.from = HEADER_BYTES};
    choose_codecs(f, gap.from);
    for (uint64_t id = 0, unknown = 0; id <= f->grid->bricks; id++) {
        const struct brick_entry *e = id < f->grid->bricks ? brick_volume_entry(s->volume, id) : NULL;
        if (e && (!known(f, id) || e->flags & BRICK_FLAG_CONSTANT)) {
            unknown += !known(f, id);
            continue;
        }
        gap.end = id;
        gap.to = e ? e->offset : payload_end;
        gap.closed = gap.to <= file_end;
        if (!gap.closed)
            gap.to = file_end;
        if (unknown && gap.from <= gap.to) {
            f->starts = 0;
            if (f->codec[0] != BRICK_CODEC_NONE)
                gap.closed = walk(f, gap.from, gap.to) && gap.closed;
            fill_gap(f, &gap);
        }
        gap.first = id + 1;
        gap.from = e ? e->offset + e->bytes : payload_end;
        unknown = 0;
    }
}

int salvage_find(struct salvage *s, struct brick_error *err)
{
    size_t payload = brick_grid_max_payload_bytes(s->grid);
    struct finder f = {.s = s,
                       .grid = s->grid,
                       .face = malloc(s->grid->bricks * FACES * sizeof *f.face),
                       .parent = BRICK_NO_BRICK,
                       .above = malloc(payload),
                       .stored_bytes = brick_codec_bound(BRICK_CODEC_ZSTD, payload),
                       .mean = true,
                       .nearest = true};
    f.stored = malloc(f.stored_bytes);
    int code = f.face && f.above && f.stored
                   ? BRICK_OK
                   : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", brick_volume_path(s->volume));
    s->first = 0;
    if (!code)
        code = brick_pool_run(s->pool, s->grid->bricks, learn_one, &f, err);
    if (!code)
        find(&f);
    free(f.face);
    free(f.above);
    free(f.stored);
    free(f.start);
    return code;
}

uint64_t salvage_find_bytes(const struct brick_grid *grid)
{
    return grid->bricks * (FACES * sizeof(struct agree_face) + sizeof(uint64_t)) +
           3 * (uint64_t)brick_grid_max_payload_bytes(grid);
}
