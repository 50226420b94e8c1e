/* Payloads whose index entries are lost. They lie one behind the other in the order of the bricks, and a
 * Blosc chunk tells its own length, so their sequence is known; constant bricks, which have none, leave gaps
 * in it. Where a payload belongs is what it must agree with: its size, the volume's edge, the voxels that it
 * shares with its neighbours, and the mean that the next level has of it. A payload is placed only where
 * there is one place for it; a brick before it becomes constant only if everything around it is.
 *
 * Where the file's end is known, work goes backward, so that coarser levels are placed before the finer ones
 * they vouch for. */
#include "fit.h"

#include <stdlib.h>
#include <string.h>

enum {
    HEADER_BYTES = 512,
    SCAN = 1 << 16,   /* bricks that may be constant before the next payload's */
    CHOICES = 256,    /* places of a payload that are looked at */
    FEW_CHOICES = 8,  /* while another choice is being looked at */
    LOOK_AHEAD = 512, /* payloads placed to see whether a choice was right */
    EFFORT = 64,      /* payloads decoded for each brick, at most */
    DEPTH = 2         /* choices within choices */
};

static int learn_one(void *context, uint64_t item, unsigned worker, struct brick_error *err)
{
    struct fit *f = context;
    struct salvage_worker *w = &f->s->workers[worker];
    uint64_t id = f->s->first + item;
    struct brick_place place;
    if (!fit_known(f, id))
        return BRICK_OK;
    brick_grid_place(f->grid, id, &place);
    int code = brick_volume_read(f->s->volume, id, w->encoder.payload, &w->scratch, err);
    if (!code)
        fit_faces_of(f, w, &place, &f->face[id * FIT_FACES]);
    return code;
}

/* A stretch of the file and the bricks whose payloads are all that is in it. */
struct gap {
    uint64_t first, end; /* bricks */
    uint64_t from, to;   /* bytes; to: not known when the file was cut there */
    bool closed;
};

/* The payload that begins, or going backward ends, at `at` if it is this brick's; its bytes, 0 if none. */
static uint64_t next_piece(const struct fit *f, const struct gap *gap, const struct brick_place *place,
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

/* How far a gap is filled. */
struct progress {
    uint64_t at;   /* byte: where the next payload begins, or, going backward, ends */
    uint64_t done; /* bricks */
};

static uint64_t brick_of(const struct gap *gap, uint64_t step)
{
    return gap->closed ? gap->end - 1 - step : gap->first + step;
}

/* The payload is that of brick `step`, and those passed on the way to it are constant. */
static void place_piece(struct fit *f, const struct gap *gap, struct progress *p, uint64_t step)
{
    uint64_t id = brick_of(gap, step), start, bytes;
    struct brick_place place;
    brick_grid_place(f->grid, id, &place);
    bytes = next_piece(f, gap, &place, p->at, gap->closed, &start);
    fit_try(f, start, bytes, &place);
    fit_set_piece(f, id);
    for (uint64_t passed = p->done; passed < step; passed++)
        fit_set_constant(f, brick_of(gap, passed));
    p->done = step + 1;
    p->at = gap->closed ? start : start + bytes;
}

/* Steps at which the next payload could be: how many, at most CHOICES. */
static int choices(struct fit *f, const struct gap *gap, const struct progress *p, uint64_t step[CHOICES])
{
    int found = 0;
    for (uint64_t i = p->done; i < gap->end - gap->first && i - p->done < SCAN && found < CHOICES; i++) {
        uint64_t id = brick_of(gap, i), start;
        unsigned char value[8];
        bool sure;
        struct brick_place place;
        if (fit_known(f, id))
            continue;
        brick_grid_place(f->grid, id, &place);
        f->passed[0] = gap->closed ? id + 1 : gap->first + p->done;
        f->passed[1] = gap->closed ? gap->end - p->done : id;
        uint64_t n = next_piece(f, gap, &place, p->at, gap->closed, &start);
        if (n && fit_payload(f, start, n, &place))
            step[found++] = i;
        if (id + 1 == f->grid->bricks || !fit_constant(f, &place, &sure, value))
            break;
    }
    return found;
}

static bool at_goal(const struct gap *gap, const struct progress *p)
{
    return p->at == (gap->closed ? gap->from : gap->to);
}

static bool choose(struct fit *f, const struct gap *gap, const struct progress *p, int depth, uint64_t *step);

/* Does placing go on from here without a contradiction, as far as it is looked at? */
static bool goes_on(struct fit *f, const struct gap *gap, struct progress p, int depth)
{
    uint64_t step[CHOICES];
    for (int i = 0; i < LOOK_AHEAD && !at_goal(gap, &p); i++) {
        int n = choices(f, gap, &p, step);
        if (n == 0)
            return false;
        if (n > 1 && !choose(f, gap, &p, depth, step))
            return true;
        place_piece(f, gap, &p, step[0]);
    }
    bool possible = true;
    for (uint64_t i = p.done; at_goal(gap, &p) && gap->closed && possible && i < gap->end - gap->first; i++) {
        struct brick_place place;
        unsigned char value[8];
        bool sure;
        brick_grid_place(f->grid, brick_of(gap, i), &place);
        possible = fit_known(f, brick_of(gap, i)) || fit_constant(f, &place, &sure, value);
    }
    return possible;
}

/* The one place for the next payload, if there is only one from which the following ones have places. */
static bool choose(struct fit *f, const struct gap *gap, const struct progress *p, int depth, uint64_t *step)
{
    uint64_t possible[CHOICES];
    int n = choices(f, gap, p, possible), good = 0;
    if (n == 0 || n == CHOICES || (n > 1 && depth == 0) || (n > FEW_CHOICES && depth < DEPTH) ||
        f->decoded > f->decode_most)
        return false;
    *step = possible[0];
    for (int i = 0; n > 1 && i < n && good < 2; i++) {
        struct progress next = *p;
        uint64_t mark = f->set;
        place_piece(f, gap, &next, possible[i]);
        if (goes_on(f, gap, next, depth - 1)) {
            good++;
            *step = possible[i];
        }
        fit_take_back(f, mark);
    }
    return n == 1 || good == 1;
}

/* A file that was cut: if every payload fits the brick of its own number, none before it is constant, for one
 * would move all that follow, and faces that are not flat would not meet. Without such faces along y or z
 * nothing is proved. */
static bool one_to_one(struct fit *f, const struct gap *gap, struct progress *p)
{
    uint64_t mark = f->set, met = 0, end = f->grid->levels > 1 ? f->grid->level[1].first_brick : gap->end;
    struct progress next = *p;
    f->passed[0] = f->passed[1] = 0;
    for (; next.done < end; next.done++) {
        uint64_t id = gap->first + next.done, start;
        struct brick_place place;
        brick_grid_place(f->grid, id, &place);
        uint64_t n = next_piece(f, gap, &place, next.at, false, &start);
        if (!n) /* the last payload is not whole */
            break;
        if (fit_known(f, id) || !fit_payload(f, start, n, &place)) {
            fit_take_back(f, mark);
            return false;
        }
        met += (place.at[1] && !f->piece.face[2].flat) || (place.at[2] && !f->piece.face[4].flat);
        fit_set_piece(f, id);
        next.at += n;
    }
    if (met)
        *p = next;
    else
        fit_take_back(f, mark);
    return met > 0;
}

/* Place what can be placed of a gap. */
static void fill_gap(struct fit *f, const struct gap *gap)
{
    struct progress p = {.at = gap->closed ? gap->to : gap->from};
    uint64_t step, all = gap->end - gap->first;
    if (gap->first == 0 && !gap->closed && one_to_one(f, gap, &p))
        return;
    while (p.done < all && !at_goal(gap, &p) && choose(f, gap, &p, DEPTH, &step))
        place_piece(f, gap, &p, step);
    if (at_goal(gap, &p) && gap->closed) /* nothing is left for the others */
        for (int pass = 0; pass < 2; pass++)
            for (uint64_t i = 0; i < all; i++)
                fit_set_constant(f, pass ? gap->first + i : gap->end - 1 - i);
}

/* Lengths of the payloads in [from, to): false when they do not add up. */
static bool walk(struct fit *f, uint64_t from, uint64_t to)
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
static void choose_codecs(struct fit *f, uint64_t from)
{
    unsigned char header[64];
    for (uint64_t id = 0; id < f->grid->bricks; id++) {
        const struct brick_entry *e = brick_volume_entry(f->s->volume, id);
        if (fit_known(f, id) && !(e->flags & BRICK_FLAG_CONSTANT)) {
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
    if (n < 2)
        return;
    /* Two that look alike: one of them decodes the first payload, whose shape is one of eight. */
    uint64_t bytes = brick_codec_measure(f->codec[0], NULL, header, sizeof header);
    const uint64_t *bricks = f->grid->level[0].bricks;
    for (int i = 0; i < 8; i++) {
        struct brick_place place;
        brick_grid_place(f->grid,
                         brick_grid_id(f->grid, 0, i & 1 ? bricks[0] - 1 : 0, i & 2 ? bricks[1] - 1 : 0,
                                       i & 4 ? bricks[2] - 1 : 0),
                         &place);
        fit_try(f, from, bytes, &place);
        if (f->piece.whole) {
            f->codec[0] = (enum brick_codec)f->piece.entry.codec;
            f->codecs = 1;
            return;
        }
    }
}

static void find(struct fit *f)
{
    const struct salvage *s = f->s;
    uint64_t payload_end = brick_volume_payload_end(s->volume), file_end = s->damage.bytes;
    struct gap gap = {.from = HEADER_BYTES};
    choose_codecs(f, gap.from);
    for (uint64_t id = 0, unknown = 0; id <= f->grid->bricks; id++) {
        const struct brick_entry *e = id < f->grid->bricks ? brick_volume_entry(s->volume, id) : NULL;
        if (e && (!fit_known(f, id) || e->flags & BRICK_FLAG_CONSTANT)) {
            unknown += !fit_known(f, id);
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
    struct fit f = {.s = s,
                    .grid = s->grid,
                    .face = malloc(s->grid->bricks * FIT_FACES * sizeof *f.face),
                    .decode_most = EFFORT * (s->grid->bricks + CHOICES),
                    .parent = BRICK_NO_BRICK,
                    .above = malloc(payload),
                    .journal = malloc(s->grid->bricks * sizeof *f.journal),
                    .stored_bytes = brick_codec_bound(BRICK_CODEC_ZSTD, payload)};
    f.stored = malloc(f.stored_bytes);
    int code = f.face && f.above && f.stored && f.journal
                   ? BRICK_OK
                   : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", brick_volume_path(s->volume));
    s->first = 0;
    if (!code)
        code = brick_pool_run(s->pool, s->grid->bricks, learn_one, &f, err);
    if (!code)
        find(&f);
    for (uint64_t i = 0; !code && i < f.set; i++)
        s->unconfirmed += s->grid->levels < 2 || f.journal[i] < s->grid->level[1].first_brick;
    free(f.journal);
    free(f.face);
    free(f.above);
    free(f.stored);
    free(f.start);
    return code;
}

uint64_t salvage_find_bytes(const struct brick_grid *grid)
{
    return grid->bricks * (FIT_FACES * sizeof(struct agree_face) + 2 * sizeof(uint64_t)) +
           3 * (uint64_t)brick_grid_max_payload_bytes(grid);
}
