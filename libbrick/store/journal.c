/* Entries are written some time after their payloads, never before, and notes after the entries of all bricks
 * put until then, which is all the order that a kill needs. A power cut keeps no order: a block that is not
 * whole ends the journal, and so does one with a payload that is not (the writer's user looks at each). So
 * nothing waits for the disk here. */
#include "journal.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum {
    HEADER_BYTES = 24,
    BUFFER_BYTES = 1 << 18,
    PAYLOAD_BYTES = 1 << 20 /* a kill loses what it takes to make this much */
};
static const unsigned char magic[8] = {0x89, 'B', 'R', 'K', 'N', '\r', '\n', 0x1a};

static void begin(struct journal *j, uint64_t start)
{
    j->start = j->end = start;
    memset(j->bricks, 0, sizeof j->bricks);
    j->note_bytes = j->payload = 0;
    j->waiting = 0;
}

static int set_up(struct journal *j, const char *path, const struct brick_grid *grid, struct brick_error *err)
{
    j->grid = grid;
    if (!j->hash)
        j->hash = XXH3_createState();
    return j->hash ? BRICK_OK : brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", path);
}

int journal_create(struct journal *j, const char *path, const struct brick_grid *grid, const char *identity,
                   struct brick_error *err)
{
    uint64_t n = strlen(identity), numbers[2] = {n, XXH3_64bits(identity, n)};
    unsigned char header[HEADER_BYTES];
    memcpy(header, magic, sizeof magic);
    memcpy(header + sizeof magic, numbers, sizeof numbers);
    begin(j, HEADER_BYTES + n);
    int code = set_up(j, path, grid, err);
    if (code || (code = brick_io_create(&j->io, path, err)))
        return code;
    if (((code = brick_io_write_at(&j->io, 0, header, sizeof header, err)) ||
         (code = brick_io_write_at(&j->io, sizeof header, identity, n, err))))
        journal_close(j);
    return code;
}

/* The first line in which two texts differ; false when there is none. */
static bool find_difference(const char *a, const char *b, const char *line[2], int bytes[2])
{
    while (*a || *b) {
        size_t n = strcspn(a, "\n"), m = strcspn(b, "\n");
        if (n != m || memcmp(a, b, n) != 0) {
            line[0] = a;
            line[1] = b;
            bytes[0] = n < 200 ? (int)n : 200;
            bytes[1] = m < 200 ? (int)m : 200;
            return true;
        }
        a += n + (a[n] == '\n');
        b += m + (b[m] == '\n');
    }
    return false;
}

/* *known: the journal begins as one does. */
static int read_identity(struct journal *j, const char *identity, const char *part, bool *known,
                         struct brick_error *err)
{
    unsigned char header[HEADER_BYTES];
    uint64_t numbers[2], size;
    *known = false;
    int code = brick_io_size(&j->io, &size, err);
    if (code || size < sizeof header)
        return code;
    if ((code = brick_io_read_at(&j->io, 0, header, sizeof header, err)))
        return code;
    memcpy(numbers, header + sizeof magic, sizeof numbers);
    if (memcmp(header, magic, sizeof magic) != 0 || numbers[0] > 2 * LAYOUT_MAX_TEXT ||
        numbers[0] > size - sizeof header)
        return BRICK_OK;
    char *text = malloc(numbers[0] + 1);
    if (!text)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", j->io.path);
    text[numbers[0]] = 0;
    code = brick_io_read_at(&j->io, sizeof header, text, numbers[0], err);
    *known = !code && XXH3_64bits(text, numbers[0]) == numbers[1];
    const char *line[2];
    int bytes[2];
    if (*known && find_difference(text, identity, line, bytes))
        code = brick_fail(err, BRICK_ERR_ARGUMENT,
                          "%s: was begun with '%.*s', but now it is '%.*s': not resumed; without --resume it "
                          "starts again",
                          part, bytes[0], line[0], bytes[1], line[1]);
    free(text);
    begin(j, sizeof header + numbers[0]);
    return code;
}

/* So that no block is taken for one elsewhere, or of something else. */
static uint64_t block_checksum_seed(uint64_t at, uint64_t what)
{
    return 256 * at + what;
}

/* Of what is in the file. */
static int checksum_of(const struct journal *j, uint64_t at, uint64_t bytes, uint64_t seed,
                       unsigned char *buffer, uint64_t *checksum, struct brick_error *err)
{
    int code = BRICK_OK;
    XXH3_64bits_reset_withSeed(j->hash, seed);
    while (!code && bytes) {
        size_t n = bytes < BUFFER_BYTES ? (size_t)bytes : BUFFER_BYTES;
        if (!(code = brick_io_read_at(&j->io, at, buffer, n, err)))
            XXH3_64bits_update(j->hash, buffer, n);
        at += n;
        bytes -= n;
    }
    *checksum = XXH3_64bits_digest(j->hash);
    return code;
}

/* A block of a level's entries that is in the buffer: false when they do not follow what was read before. */
static bool take_entries(struct journal *j, uint64_t level, uint64_t bytes, const unsigned char *buffer,
                         struct brick_entry *entries, const uint64_t limit[], uint64_t offset[])
{
    uint64_t count = bytes / LAYOUT_ENTRY_BYTES;
    if (level >= j->grid->levels || bytes % LAYOUT_ENTRY_BYTES || count > JOURNAL_BLOCK_ENTRIES ||
        count > limit[level] - j->bricks[level])
        return false;
    struct brick_entry *e = entries + j->grid->level[level].first_brick + j->bricks[level];
    for (uint64_t i = 0; i < count; i++, e++) {
        layout_get_entry(e, buffer + i * LAYOUT_ENTRY_BYTES);
        bool constant = e->flags & BRICK_FLAG_CONSTANT;
        if (constant != (e->bytes == 0) || e->offset != (constant ? 0 : offset[level]))
            return false;
        offset[level] += e->bytes;
    }
    j->bricks[level] += count;
    return true;
}

int journal_read(struct journal *j, struct brick_entry *entries, const uint64_t limit[],
                 struct brick_error *err)
{
    uint64_t size, numbers[3], checksum, offset[BRICK_MAX_LEVELS] = {0};
    unsigned char *buffer = malloc(BUFFER_BYTES);
    if (!buffer)
        return brick_fail(err, BRICK_ERR_MEMORY, "%s: out of memory", j->io.path);
    begin(j, j->start);
    int code = brick_io_size(&j->io, &size, err);
    while (!code && size - j->end >= sizeof numbers &&
           !(code = brick_io_read_at(&j->io, j->end, numbers, sizeof numbers, err))) {
        uint64_t what = numbers[0], bytes = numbers[1], at = j->end + sizeof numbers;
        if (bytes == 0 || bytes > size - at ||
            (code = checksum_of(j, at, bytes, block_checksum_seed(j->end, what), buffer, &checksum, err)) ||
            checksum != numbers[2])
            break;
        if (what == JOURNAL_NOTE) {
            j->note = at;
            j->note_bytes = bytes;
        } else if (!take_entries(j, what, bytes, buffer, entries, limit, offset)) {
            break;
        }
        j->end = at + bytes;
    }
    free(buffer);
    return code ? code : brick_io_truncate(&j->io, j->end, err);
}

int journal_open(struct journal *j, const char *path, const struct brick_grid *grid, const char *identity,
                 const char *part, struct brick_error *err)
{
    bool known;
    int code = set_up(j, path, grid, err);
    if (code || (code = brick_io_update(&j->io, path, err)))
        return code;
    if (!(code = read_identity(j, identity, part, &known, err)) && known)
        return BRICK_OK;
    journal_close(j);
    return code ? code : journal_create(j, path, grid, identity, err);
}

int journal_put(struct journal *j, uint32_t level, const struct brick_entry *e, struct brick_error *err)
{
    bool full = j->waiting == JOURNAL_BLOCK_ENTRIES || (j->waiting && j->level != level);
    int code = full ? journal_flush(j, err) : BRICK_OK;
    if (code)
        return code;
    j->level = level;
    layout_put_entry(e, j->block + JOURNAL_BLOCK_BYTES + j->waiting++ * LAYOUT_ENTRY_BYTES);
    j->payload += e->bytes;
    return j->payload >= PAYLOAD_BYTES ? journal_flush(j, err) : BRICK_OK;
}

int journal_flush(struct journal *j, struct brick_error *err)
{
    if (j->waiting == 0)
        return BRICK_OK;
    size_t bytes = j->waiting * LAYOUT_ENTRY_BYTES;
    uint64_t numbers[3] = {
        j->level, bytes,
        XXH3_64bits_withSeed(j->block + JOURNAL_BLOCK_BYTES, bytes, block_checksum_seed(j->end, j->level))};
    memcpy(j->block, numbers, sizeof numbers);
    int code = brick_io_write_at(&j->io, j->end, j->block, JOURNAL_BLOCK_BYTES + bytes, err);
    if (code)
        return code;
    j->end += JOURNAL_BLOCK_BYTES + bytes;
    j->bricks[j->level] += j->waiting;
    j->payload = 0;
    j->waiting = 0;
    return BRICK_OK;
}

int journal_note_begin(struct journal *j, struct brick_error *err)
{
    int code = journal_flush(j, err);
    j->note = j->end + JOURNAL_BLOCK_BYTES;
    j->note_bytes = 0;
    XXH3_64bits_reset_withSeed(j->hash, block_checksum_seed(j->end, JOURNAL_NOTE));
    return code;
}

int journal_note_add(struct journal *j, const void *bytes, size_t n, struct brick_error *err)
{
    XXH3_64bits_update(j->hash, bytes, n);
    int code = brick_io_write_at(&j->io, j->note + j->note_bytes, bytes, n, err);
    j->note_bytes += n;
    return code;
}

int journal_note_end(struct journal *j, struct brick_error *err)
{
    uint64_t numbers[3] = {JOURNAL_NOTE, j->note_bytes, XXH3_64bits_digest(j->hash)};
    int code = brick_io_write_at(&j->io, j->end, numbers, sizeof numbers, err);
    j->end = code ? j->end : j->note + j->note_bytes;
    return code;
}

int journal_note_read(const struct journal *j, uint64_t at, void *bytes, size_t n, struct brick_error *err)
{
    if (at > j->note_bytes || n > j->note_bytes - at)
        return brick_fail(err, BRICK_ERR_FORMAT, "%s: a note is too short", j->io.path);
    return brick_io_read_at(&j->io, j->note + at, bytes, n, err);
}

void journal_close(struct journal *j)
{
    brick_io_close(&j->io);
    XXH3_freeState(j->hash);
    j->hash = NULL;
}
