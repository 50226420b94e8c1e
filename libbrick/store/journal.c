/* Entries are written some time after their payloads, never before, which is all the order that a kill needs.
 * A power cut keeps no order: a block that is not whole ends the journal, and a payload that is not ends what
 * is kept of it (the writer's user looks at each). So nothing waits for the disk here. */
#include "journal.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

enum {
    HEADER_BYTES = 24,
    PAYLOAD_BYTES = 1 << 20 /* a kill loses what it takes to make this much */
};
static const unsigned char magic[8] = {0x89, 'B', 'R', 'K', 'J', '\r', '\n', 0x1a};

static void begin(struct journal *j, uint64_t start)
{
    j->start = j->end = start;
    j->entries = j->payload = 0;
    j->waiting = 0;
}

int journal_create(struct journal *j, const char *path, const char *identity, struct brick_error *err)
{
    uint64_t n = strlen(identity), numbers[2] = {n, XXH3_64bits(identity, n)};
    unsigned char header[HEADER_BYTES];
    memcpy(header, magic, sizeof magic);
    memcpy(header + sizeof magic, numbers, sizeof numbers);
    begin(j, HEADER_BYTES + n);
    int code = brick_io_create(&j->io, path, err);
    if (!code && ((code = brick_io_write_at(&j->io, 0, header, sizeof header, err)) ||
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

/* The next whole block to the buffer; *count 0 when there is none. */
static int read_block(struct journal *j, uint64_t size, uint64_t *count, struct brick_error *err)
{
    uint64_t numbers[2];
    *count = 0;
    if (size - j->end < sizeof numbers)
        return BRICK_OK;
    int code = brick_io_read_at(&j->io, j->end, numbers, sizeof numbers, err);
    uint64_t bytes = numbers[0] * LAYOUT_ENTRY_BYTES;
    if (code || numbers[0] > JOURNAL_BLOCK_ENTRIES || size - j->end - sizeof numbers < bytes ||
        (code = brick_io_read_at(&j->io, j->end + sizeof numbers, j->block, bytes, err)))
        return code;
    if (XXH3_64bits_withSeed(j->block, bytes, j->entries) == numbers[1])
        *count = numbers[0];
    return BRICK_OK;
}

static int read_entries(struct journal *j, struct brick_entry *entries, uint64_t most,
                        struct brick_error *err)
{
    uint64_t size, count, offset = 0;
    int code = brick_io_size(&j->io, &size, err);
    while (!code && !(code = read_block(j, size, &count, err)) && count && count <= most - j->entries) {
        for (uint64_t i = 0; i < count; i++) {
            struct brick_entry *e = &entries[j->entries + i];
            layout_get_entry(e, j->block + i * LAYOUT_ENTRY_BYTES);
            bool constant = e->flags & BRICK_FLAG_CONSTANT;
            if (constant != (e->bytes == 0) || e->offset != (constant ? 0 : offset))
                return BRICK_OK;
            offset += e->bytes;
        }
        j->entries += count;
        j->end += JOURNAL_BLOCK_BYTES + count * LAYOUT_ENTRY_BYTES;
    }
    return code;
}

int journal_open(struct journal *j, const char *path, const char *identity, const char *part,
                 struct brick_entry *entries, uint64_t most, uint64_t *count, struct brick_error *err)
{
    bool known;
    *count = 0;
    int code = brick_io_update(&j->io, path, err);
    if (code)
        return code;
    if (!(code = read_identity(j, identity, part, &known, err)) && !known) {
        journal_close(j);
        return journal_create(j, path, identity, err);
    }
    if (!code)
        code = read_entries(j, entries, most, err);
    if (!code)
        code = brick_io_truncate(&j->io, j->end, err);
    *count = j->entries;
    if (code)
        journal_close(j);
    return code;
}

int journal_put(struct journal *j, const struct brick_entry *e, struct brick_error *err)
{
    int code = j->waiting == JOURNAL_BLOCK_ENTRIES ? journal_flush(j, err) : BRICK_OK;
    if (code)
        return code;
    layout_put_entry(e, j->block + JOURNAL_BLOCK_BYTES + j->waiting++ * LAYOUT_ENTRY_BYTES);
    j->payload += e->bytes;
    return j->payload >= PAYLOAD_BYTES ? journal_flush(j, err) : BRICK_OK;
}

int journal_flush(struct journal *j, struct brick_error *err)
{
    if (j->waiting == 0)
        return BRICK_OK;
    size_t bytes = j->waiting * LAYOUT_ENTRY_BYTES;
    uint64_t numbers[2] = {j->waiting,
                           XXH3_64bits_withSeed(j->block + JOURNAL_BLOCK_BYTES, bytes, j->entries)};
    memcpy(j->block, numbers, sizeof numbers);
    int code = brick_io_write_at(&j->io, j->end, j->block, JOURNAL_BLOCK_BYTES + bytes, err);
    if (code)
        return code;
    j->end += JOURNAL_BLOCK_BYTES + bytes;
    j->entries += j->waiting;
    j->payload = 0;
    j->waiting = 0;
    return BRICK_OK;
}

int journal_cut(struct journal *j, const struct brick_entry *entries, uint64_t count, struct brick_error *err)
{
    uint64_t in_block = 0;
    int code = journal_flush(j, err);
    begin(j, j->start);
    /* Whole blocks before the cut stay as they are. */
    while (!code && !(code = brick_io_read_at(&j->io, j->end, &in_block, sizeof in_block, err)) &&
           in_block <= count - j->entries) {
        j->entries += in_block;
        j->end += JOURNAL_BLOCK_BYTES + in_block * LAYOUT_ENTRY_BYTES;
        if (j->entries == count)
            break;
    }
    if (!code)
        code = brick_io_truncate(&j->io, j->end, err);
    for (uint64_t i = j->entries; !code && i < count; i++)
        code = journal_put(j, &entries[i], err);
    return code ? code : journal_flush(j, err);
}

void journal_close(struct journal *j)
{
    brick_io_close(&j->io);
}
