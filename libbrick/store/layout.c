/* Byte by byte, little endian, independent of the host's own layout. */
#include "layout.h"

#include <math.h>
#include <string.h>
#include <xxhash.h>

static const unsigned char magic[8] = {0x89, 'B', 'R', 'K', '\r', '\n', 0x1a, '\n'};

static unsigned char *put_u32(unsigned char *p, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        *p++ = (unsigned char)(v >> 8 * i);
    return p;
}

static unsigned char *put_u64(unsigned char *p, uint64_t v)
{
    for (int i = 0; i < 8; i++)
        *p++ = (unsigned char)(v >> 8 * i);
    return p;
}

static unsigned char *put_f32(unsigned char *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return put_u32(p, bits);
}

static unsigned char *put_f64(unsigned char *p, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return put_u64(p, bits);
}

static uint32_t get_u32(const unsigned char **p)
{
    uint32_t v = 0;
    for (int i = 0; i < 4; i++)
        v |= (uint32_t) * (*p)++ << 8 * i;
    return v;
}

static uint64_t get_u64(const unsigned char **p)
{
    uint64_t v = 0;
    for (int i = 0; i < 8; i++)
        v |= (uint64_t) * (*p)++ << 8 * i;
    return v;
}

static float get_f32(const unsigned char **p)
{
    uint32_t bits = get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static double get_f64(const unsigned char **p)
{
    uint64_t bits = get_u64(p);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

void layout_put_header(const struct layout_header *h, unsigned char dst[LAYOUT_HEADER_BYTES])
{
    memset(dst, 0, LAYOUT_HEADER_BYTES);
    memcpy(dst, magic, sizeof magic);
    unsigned char *p = dst + sizeof magic;
    p = put_u32(p, LAYOUT_VERSION);
    p = put_u32(p, LAYOUT_HEADER_BYTES);
    p = put_u64(p, h->file_bytes);
    p = put_u32(p, (uint32_t)h->type);
    p = put_u32(p, h->edge);
    p = put_u32(p, h->border);
    p = put_u32(p, h->macrocell);
    p = put_u32(p, h->levels);
    p = put_u32(p, 1); /* channels */
    p = put_u32(p, 1); /* time steps */
    p = put_u32(p, LAYOUT_ENTRY_BYTES);
    for (int a = 0; a < 3; a++)
        p = put_u64(p, h->geometry.dims[a]);
    p = put_f64(p, h->geometry.slope);
    p = put_f64(p, h->geometry.intercept);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            p = put_f64(p, h->geometry.affine[r][c]);
    for (int t = 0; t < LAYOUT_TABLES; t++) {
        p = put_u64(p, h->table[t].offset);
        p = put_u64(p, h->table[t].bytes);
        p = put_u64(p, h->table[t].checksum);
    }
    put_f64(p, h->tolerance);
    put_u64(dst + LAYOUT_HEADER_BYTES - 8, XXH3_64bits(dst, LAYOUT_HEADER_BYTES - 8));
}

int layout_get_header(struct layout_header *h, const unsigned char src[LAYOUT_HEADER_BYTES], const char *file,
                      struct brick_error *err)
{
    static const unsigned char zeros[LAYOUT_HEADER_BYTES];
    memset(h, 0, sizeof *h);
    if (memcmp(src, zeros, LAYOUT_HEADER_BYTES) == 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 0, BRICK_NO_BRICK,
                             "%s: an unfinished .brick file: its conversion was interrupted", file);
    if (memcmp(src, magic, sizeof magic) != 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 0, BRICK_NO_BRICK, "%s: not a .brick file", file);
    const unsigned char *p = src + sizeof magic;
    uint32_t version = get_u32(&p);
    if (version != LAYOUT_VERSION)
        return brick_fail_at(err, BRICK_ERR_UNSUPPORTED, 8, BRICK_NO_BRICK,
                             "%s: .brick version %u; this program reads version %u", file, version,
                             LAYOUT_VERSION);
    const unsigned char *end = src + LAYOUT_HEADER_BYTES - 8;
    if (get_u64(&end) != XXH3_64bits(src, LAYOUT_HEADER_BYTES - 8))
        return brick_fail_at(err, BRICK_ERR_CHECKSUM, 0, BRICK_NO_BRICK,
                             "%s: the header's checksum does not match: the file is damaged", file);
    uint32_t header_bytes = get_u32(&p);
    h->file_bytes = get_u64(&p);
    h->type = (enum brick_type)get_u32(&p);
    h->edge = get_u32(&p);
    h->border = get_u32(&p);
    h->macrocell = get_u32(&p);
    h->levels = get_u32(&p);
    uint32_t channels = get_u32(&p), times = get_u32(&p), entry_bytes = get_u32(&p);
    for (int a = 0; a < 3; a++)
        h->geometry.dims[a] = get_u64(&p);
    h->geometry.slope = get_f64(&p);
    h->geometry.intercept = get_f64(&p);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            h->geometry.affine[r][c] = get_f64(&p);
    for (int t = 0; t < LAYOUT_TABLES; t++) {
        h->table[t].offset = get_u64(&p);
        h->table[t].bytes = get_u64(&p);
        h->table[t].checksum = get_u64(&p);
    }
    h->tolerance = get_f64(&p);
    if (header_bytes != LAYOUT_HEADER_BYTES || !(h->tolerance >= 0.0) || isinf(h->tolerance) ||
        entry_bytes != LAYOUT_ENTRY_BYTES ||
        memcmp(p, zeros, (size_t)(src + LAYOUT_HEADER_BYTES - 8 - p)) != 0)
        return brick_fail_at(err, BRICK_ERR_FORMAT, 12, BRICK_NO_BRICK,
                             "%s: the header contradicts version %u", file, LAYOUT_VERSION);
    if (channels != 1 || times != 1)
        return brick_fail_at(err, BRICK_ERR_UNSUPPORTED, 44, BRICK_NO_BRICK,
                             "%s: %u channels and %u time steps; this program reads one of each", file,
                             channels, times);
    return BRICK_OK;
}

static uint64_t header_sum(const unsigned char bytes[LAYOUT_HEADER_BYTES])
{
    const unsigned char *end = bytes + LAYOUT_HEADER_BYTES - 8;
    return get_u64(&end);
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
            put_u64(mended + summed, sum);
            found = true;
        }
    if (found)
        memcpy(bytes, mended, sizeof mended);
    return found;
}

void layout_put_level(const struct brick_level *level, unsigned char dst[LAYOUT_LEVEL_BYTES])
{
    for (int a = 0; a < 3; a++)
        dst = put_u64(dst, level->dims[a]);
    for (int a = 0; a < 3; a++)
        dst = put_u64(dst, level->bricks[a]);
    dst = put_u64(dst, level->first_brick);
    for (int a = 0; a < 3; a++)
        dst = put_f64(dst, level->scale[a]);
    for (int a = 0; a < 3; a++)
        dst = put_f64(dst, level->offset[a]);
}

void layout_put_entry(const struct brick_entry *e, unsigned char dst[LAYOUT_ENTRY_BYTES])
{
    dst = put_u64(dst, e->offset);
    dst = put_u32(dst, e->bytes);
    *dst++ = e->codec;
    *dst++ = e->flags;
    *dst++ = (unsigned char)(e->reserved & 0xff);
    *dst++ = (unsigned char)(e->reserved >> 8);
    dst = put_u64(dst, e->checksum);
    dst = put_f32(dst, e->min);
    dst = put_f32(dst, e->max);
    dst = put_u64(dst, e->mask);
    dst = put_u32(dst, e->value);
    put_u32(dst, e->nonfinite);
}

void layout_get_entry(struct brick_entry *e, const unsigned char src[LAYOUT_ENTRY_BYTES])
{
    e->offset = get_u64(&src);
    e->bytes = get_u32(&src);
    e->codec = *src++;
    e->flags = *src++;
    e->reserved = (uint16_t)(src[0] | src[1] << 8);
    src += 2;
    e->checksum = get_u64(&src);
    e->min = get_f32(&src);
    e->max = get_f32(&src);
    e->mask = get_u64(&src);
    e->value = get_u32(&src);
    e->nonfinite = get_u32(&src);
}

void layout_put_stats(const struct brick_stats *s, unsigned char *dst)
{
    dst = put_u64(dst, s->count);
    dst = put_u64(dst, s->nonfinite);
    dst = put_f64(dst, s->min);
    dst = put_f64(dst, s->max);
    dst = put_f64(dst, s->mean);
    dst = put_f64(dst, s->variance);
    dst = put_u32(dst, s->first_bin);
    dst = put_u32(dst, s->bins);
    for (uint32_t i = 0; i < s->bins; i++)
        dst = put_u64(dst, s->histogram[i]);
}

int layout_get_stats(struct brick_stats *s, uint64_t *histogram, const unsigned char *src, uint64_t bytes,
                     enum brick_type type, const char *file, struct brick_error *err)
{
    s->count = get_u64(&src);
    s->nonfinite = get_u64(&src);
    s->min = get_f64(&src);
    s->max = get_f64(&src);
    s->mean = get_f64(&src);
    s->variance = get_f64(&src);
    s->first_bin = get_u32(&src);
    s->bins = get_u32(&src);
    s->histogram = histogram;
    uint32_t possible = brick_type_bytes(type) == 1 ? 256 : 65536;
    uint64_t sum = 0;
    bool ok = s->bins <= possible && s->first_bin <= possible - s->bins &&
              bytes == LAYOUT_STATS_BYTES + (uint64_t)8 * s->bins;
    for (uint32_t i = 0; ok && i < s->bins; i++) {
        histogram[i] = get_u64(&src);
        ok = !__builtin_add_overflow(sum, histogram[i], &sum);
    }
    ok = ok && sum == s->count && isfinite(s->mean) && s->variance >= 0.0 &&
         (s->count ? isfinite(s->min) && isfinite(s->max) && s->min <= s->max : s->min > s->max);
    return ok ? BRICK_OK
              : brick_fail(err, BRICK_ERR_FORMAT, "%s: the statistics table contradicts itself", file);
}
