/* Number by number, little endian, independent of the host's own layout of structs. */
#include "layout.h"

#include <math.h>
#include <string.h>
#include <xxhash.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "big-endian hosts need a byte swap in number()");

static const unsigned char magic[8] = {0x89, 'B', 'R', 'K', '\r', '\n', 0x1a, '\n'};

/* A walk over numbers in the file, each as wide as its member: one list of members serves both ways. One
 * pointer is NULL, the other is where the next number goes to or comes from. */
struct walk {
    unsigned char *to;
    const unsigned char *from;
};

static inline void number(struct walk *w, void *member, size_t bytes)
{
    if (w->to) {
        memcpy(w->to, member, bytes);
        w->to += bytes;
    } else {
        memcpy(member, w->from, bytes);
        w->from += bytes;
    }
}
#define NUMBER(walk, member) number(walk, &(member), sizeof(member))

/* Of a header, what a version fixes. */
struct fixed {
    uint32_t version, header_bytes, channels, times, entry_bytes;
};
static const struct fixed fixed = {LAYOUT_VERSION, LAYOUT_HEADER_BYTES, 1, 1, LAYOUT_ENTRY_BYTES};

/* All between the magic bytes and the reserved ones. */
static void walk_header(struct walk *w, struct layout_header *h, struct fixed *f)
{
    NUMBER(w, f->version);
    NUMBER(w, f->header_bytes);
    NUMBER(w, h->file_bytes);
    NUMBER(w, h->type);
    NUMBER(w, h->edge);
    NUMBER(w, h->border);
    NUMBER(w, h->macrocell);
    NUMBER(w, h->levels);
    NUMBER(w, f->channels);
    NUMBER(w, f->times);
    NUMBER(w, f->entry_bytes);
    for (int a = 0; a < 3; a++)
        NUMBER(w, h->geometry.dims[a]);
    NUMBER(w, h->geometry.slope);
    NUMBER(w, h->geometry.intercept);
    for (int i = 0; i < 12; i++)
        NUMBER(w, h->geometry.affine[i / 4][i % 4]);
    for (int t = 0; t < LAYOUT_TABLES; t++) {
        NUMBER(w, h->table[t].offset);
        NUMBER(w, h->table[t].bytes);
        NUMBER(w, h->table[t].checksum);
    }
    NUMBER(w, h->tolerance);
}

static uint64_t header_sum(const unsigned char bytes[LAYOUT_HEADER_BYTES])
{
    uint64_t sum;
    NUMBER(&(struct walk){.from = bytes + LAYOUT_HEADER_BYTES - 8}, sum);
    return sum;
}

static void put_header_sum(unsigned char bytes[LAYOUT_HEADER_BYTES], uint64_t sum)
{
    NUMBER(&(struct walk){.to = bytes + LAYOUT_HEADER_BYTES - 8}, sum);
}

void layout_put_header(const struct layout_header *h, unsigned char dst[LAYOUT_HEADER_BYTES])
{
    struct layout_header copy = *h;
    struct fixed own = fixed;
    memset(dst, 0, LAYOUT_HEADER_BYTES);
    memcpy(dst, magic, sizeof magic);
    walk_header(&(struct walk){.to = dst + sizeof magic}, &copy, &own);
    put_header_sum(dst, XXH3_64bits(dst, LAYOUT_HEADER_BYTES - 8));
}

int layout_get_header(struct layout_header *h, const unsigned char src[LAYOUT_HEADER_BYTES], const char *file,
                      struct brick_error *err)
{
    static const unsigned char zeros[LAYOUT_HEADER_BYTES];
    if (memcmp(src, zeros, LAYOUT_HEADER_BYTES) == 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 0, BRICK_NO_BRICK,
                             "%s: an unfinished .brick file: its conversion was interrupted", file);
    if (memcmp(src, magic, sizeof magic) != 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 0, BRICK_NO_BRICK, "%s: not a .brick file", file);
    struct walk walk = {.from = src + sizeof magic};
    struct fixed found;
    walk_header(&walk, h, &found);
    if (found.version != LAYOUT_VERSION)
        return brick_fail_at(err, BRICK_ERR_UNSUPPORTED, 8, BRICK_NO_BRICK,
                             "%s: .brick version %u; this program reads version %u", file, found.version,
                             LAYOUT_VERSION);
    if (header_sum(src) != XXH3_64bits(src, LAYOUT_HEADER_BYTES - 8))
        return brick_fail_at(err, BRICK_ERR_CHECKSUM, 0, BRICK_NO_BRICK,
                             "%s: the header's checksum does not match: the file is damaged", file);
    if (found.header_bytes != LAYOUT_HEADER_BYTES || !(h->tolerance >= 0.0) || isinf(h->tolerance) ||
        found.entry_bytes != LAYOUT_ENTRY_BYTES ||
        memcmp(walk.from, zeros, (size_t)(src + LAYOUT_HEADER_BYTES - 8 - walk.from)) != 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 12, BRICK_NO_BRICK,
                             "%s: the header contradicts version %u", file, LAYOUT_VERSION);
    if (found.channels != 1 || found.times != 1)
        return brick_fail_at(err, BRICK_ERR_UNSUPPORTED, 44, BRICK_NO_BRICK,
                             "%s: %u channels and %u time steps; this program reads one of each", file,
                             found.channels, found.times);
    return BRICK_OK;
}

bool layout_mend_header(unsigned char bytes[LAYOUT_HEADER_BYTES])
{
    static const unsigned char zeros[LAYOUT_HEADER_BYTES];
    const size_t summed = LAYOUT_HEADER_BYTES - 8;
    uint64_t sum = XXH3_64bits(bytes, summed);
    if (sum == header_sum(bytes) || memcmp(bytes, zeros, LAYOUT_HEADER_BYTES) == 0)
        return false;
    /* What is common to all headers is what an empty one has. */
    unsigned char common[LAYOUT_HEADER_BYTES], mended[LAYOUT_HEADER_BYTES];
    layout_put_header(&(struct layout_header){0}, common);
    memcpy(mended, bytes, sizeof mended);
    memcpy(mended, common, 16);
    memcpy(mended + 44, common + 44, 12);
    memset(mended + 296, 0, summed - 296);
    sum = XXH3_64bits(mended, summed);
    bool found = sum == header_sum(mended);
    for (size_t i = 16; !found && i < 296; i++)
        for (unsigned v = 0, was = mended[i]; !found && v < 256; v++) {
            mended[i] = (unsigned char)v;
            found = XXH3_64bits(mended, summed) == header_sum(mended);
            if (!found)
                mended[i] = (unsigned char)was;
        }
    for (int shift = 0; !found && shift < 64; shift += 8) /* a byte of the checksum itself? */
        if (((sum ^ header_sum(mended)) & ~(UINT64_C(255) << shift)) == 0) {
            put_header_sum(mended, sum);
            found = true;
        }
    if (found)
        memcpy(bytes, mended, sizeof mended);
    return found;
}

void layout_put_level(const struct brick_level *level, unsigned char dst[LAYOUT_LEVEL_BYTES])
{
    struct brick_level l = *level;
    struct walk w = {.to = dst};
    for (int a = 0; a < 3; a++)
        NUMBER(&w, l.dims[a]);
    for (int a = 0; a < 3; a++)
        NUMBER(&w, l.bricks[a]);
    NUMBER(&w, l.first_brick);
    for (int a = 0; a < 3; a++)
        NUMBER(&w, l.scale[a]);
    for (int a = 0; a < 3; a++)
        NUMBER(&w, l.offset[a]);
}

static inline void walk_entry(struct walk *w, struct brick_entry *e)
{
    NUMBER(w, e->offset);
    NUMBER(w, e->bytes);
    NUMBER(w, e->codec);
    NUMBER(w, e->flags);
    NUMBER(w, e->reserved);
    NUMBER(w, e->checksum);
    NUMBER(w, e->min);
    NUMBER(w, e->max);
    NUMBER(w, e->mask);
    NUMBER(w, e->value);
    NUMBER(w, e->nonfinite);
}

void layout_put_entry(const struct brick_entry *e, unsigned char dst[LAYOUT_ENTRY_BYTES])
{
    struct brick_entry copy = *e;
    walk_entry(&(struct walk){.to = dst}, &copy);
}

void layout_get_entry(struct brick_entry *e, const unsigned char src[LAYOUT_ENTRY_BYTES])
{
    walk_entry(&(struct walk){.from = src}, e);
}

/* All but the histogram. */
static void walk_stats(struct walk *w, struct brick_stats *s)
{
    NUMBER(w, s->count);
    NUMBER(w, s->nonfinite);
    NUMBER(w, s->min);
    NUMBER(w, s->max);
    NUMBER(w, s->mean);
    NUMBER(w, s->variance);
    NUMBER(w, s->first_bin);
    NUMBER(w, s->bins);
}

void layout_put_stats(const struct brick_stats *s, unsigned char *dst)
{
    struct brick_stats copy = *s;
    struct walk w = {.to = dst};
    walk_stats(&w, &copy);
    for (uint32_t i = 0; i < s->bins; i++) {
        uint64_t count = s->histogram[i];
        NUMBER(&w, count);
    }
}

int layout_get_stats(struct brick_stats *s, uint64_t *histogram, const unsigned char *src, uint64_t bytes,
                     enum brick_type type, const char *file, struct brick_error *err)
{
    struct walk w = {.from = src};
    walk_stats(&w, s);
    s->histogram = histogram;
    uint32_t possible = brick_type_bytes(type) == 1 ? 256 : 65536;
    uint64_t sum = 0;
    bool ok = s->bins <= possible && s->first_bin <= possible - s->bins &&
              bytes == LAYOUT_STATS_BYTES + (uint64_t)8 * s->bins;
    for (uint32_t i = 0; ok && i < s->bins; i++) {
        NUMBER(&w, histogram[i]);
        ok = !__builtin_add_overflow(sum, histogram[i], &sum);
    }
    ok = ok && sum == s->count && isfinite(s->mean) && s->variance >= 0.0 &&
         (s->count ? isfinite(s->min) && isfinite(s->max) && s->min <= s->max : s->min > s->max);
    return ok ? BRICK_OK
              : brick_fail(err, BRICK_ERR_FORMAT, "%s: the statistics table contradicts itself", file);
}
