/* A payload whose index entry is lost has no checksum either: it belongs to a brick if it decodes, its ranges
 * are those of its voxels, and all that other bricks share with it agrees. */
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

bool fit_known(const struct fit *f, uint64_t id)
{
    return f->s->state[id] & SALVAGE_VOXELS;
}

void fit_faces_of(const struct fit *f, struct salvage_worker *w, const struct brick_place *place,
                  struct agree_face face[FIT_FACES])
{
    for (int i = 0; i < FIT_FACES; i++)
        face[i] = agree_face(f->grid, place, w->encoder.payload, i / 2, i % 2, true, w->face);
}

/* The neighbour beyond face i, or BRICK_NO_BRICK. */
static uint64_t neighbour(const struct fit *f, const struct brick_place *place, int i)
{
    uint64_t at[3] = {place->at[0], place->at[1], place->at[2]};
    at[i / 2] += i % 2 ? 1 : UINT64_MAX;
    if (at[i / 2] >= f->grid->level[place->level].bricks[i / 2])
        return BRICK_NO_BRICK;
    return brick_grid_id(f->grid, place->level, at[0], at[1], at[2]);
}

/* What the next level has of a brick, to worker 0's part[0]: its voxels' number, 0 where that is not known.
 */
static size_t seen_from_above(struct fit *f, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    if (place->level + 1 >= f->grid->levels)
        return 0;
    struct agree_part part = agree_part(f->grid, place);
    if (!fit_known(f, part.parent))
        return 0;
    if (f->parent != part.parent && brick_volume_read(f->s->volume, part.parent, f->above, &w->scratch, NULL))
        return 0;
    f->parent = part.parent;
    struct brick_place parent;
    brick_grid_place(f->grid, part.parent, &parent);
    agree_take_part(f->grid, &parent, f->above, &part, w->part[0]);
    return (size_t)part.size[0] * part.size[1] * part.size[2];
}

bool fit_constant(struct fit *f, const struct brick_place *place, bool *sure, unsigned char value[8])
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
    for (int i = 0; i < FIT_FACES; i++) {
        uint64_t id = neighbour(f, place, i);
        if (id == BRICK_NO_BRICK || !fit_known(f, id))
            continue;
        const struct agree_face *face = &f->face[id * FIT_FACES + (unsigned)(i ^ 1)];
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

void fit_try(struct fit *f, uint64_t start, uint64_t bytes, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    struct piece *p = &f->piece;
    if (p->tried && p->start == start && p->bytes == bytes && (p->place.level == 0) == (place->level == 0) &&
        memcmp(p->place.stored, place->stored, sizeof place->stored) == 0)
        return;
    f->decoded++;
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
        fit_faces_of(f, w, place, p->face);
}

bool fit_payload(struct fit *f, uint64_t start, uint64_t bytes, const struct brick_place *place)
{
    struct salvage_worker *w = &f->s->workers[0];
    size_t width = brick_type_bytes(f->grid->type), n = seen_from_above(f, place);
    fit_try(f, start, bytes, place);
    if (!f->piece.whole)
        return false;
    for (int i = 0; i < FIT_FACES; i++) {
        uint64_t id = neighbour(f, place, i);
        if (id == BRICK_NO_BRICK)
            continue;
        if (fit_known(f, id) ? f->face[id * FIT_FACES + (unsigned)(i ^ 1)].hash != f->piece.face[i].hash
                             : id >= f->passed[0] && id < f->passed[1] && !f->piece.face[i].flat)
            return false;
    }
    if (!agree_edge_repeats(f->grid, place, w->encoder.payload, 0.0))
        return false;
    if (!n)
        return true;
    bool agrees = false; /* as a mean or as voxels 2i: which of them the file has may not be known */
    for (int nearest = 0; nearest < 2 && !agrees; nearest++) {
        agree_make_part(w->encoder.kernels, f->grid, place, w->encoder.payload, nearest, w->part[1],
                        w->coarse);
        agrees = memcmp(w->part[0], w->part[1], n * width) == 0;
    }
    return agrees;
}

void fit_set_constant(struct fit *f, uint64_t id)
{
    struct brick_place place;
    unsigned char bytes[8];
    bool sure;
    brick_grid_place(f->grid, id, &place);
    if (fit_known(f, id) || !fit_constant(f, &place, &sure, bytes) || !sure)
        return;
    float value = (float)brick_type_load(f->grid->type, bytes, 0);
    struct brick_entry e = {.flags = BRICK_FLAG_CONSTANT,
                            .min = isfinite(value) ? value : INFINITY,
                            .max = isfinite(value) ? value : -INFINITY,
                            .mask = isfinite(value)};
    memcpy(&e.value, &value, sizeof value);
    brick_volume_set_entry(f->s->volume, id, &e);
    f->s->state[id] = place.level == 0 ? SALVAGE_VOXELS | SALVAGE_ENTRY : SALVAGE_VOXELS;
    f->journal[f->set++] = id;
    struct agree_face face = {XXH3_64bits(bytes, brick_type_bytes(f->grid->type)), true};
    for (int i = 0; i < FIT_FACES; i++)
        f->face[id * FIT_FACES + (unsigned)i] = face;
}

void fit_set_piece(struct fit *f, uint64_t id)
{
    const struct piece *p = &f->piece;
    brick_volume_set_entry(f->s->volume, id, &p->entry);
    f->s->state[id] = SALVAGE_VOXELS | (p->complete ? SALVAGE_ENTRY : 0);
    f->journal[f->set++] = id;
    memcpy(&f->face[id * FIT_FACES], p->face, sizeof p->face);
}

void fit_take_back(struct fit *f, uint64_t to)
{
    static const struct brick_entry unknown;
    struct salvage *s = f->s;
    for (; f->set > to; f->set--) {
        uint64_t id = f->journal[f->set - 1];
        brick_volume_set_entry(s->volume, id, &unknown);
        s->state[id] = 0;
        f->parent = BRICK_NO_BRICK;
    }
}
