/* Damaged headers: whatever bytes are changed, removed or repeated in a good file, opening and reading it
 * ends in success or in one line of explanation, and reads stay inside their files. Seeded: every run does
 * the same. */
#include "../unit/format_files.h"

static const char *const good[][2] = {
    {"v.nrrd",
     "NRRD0004\n# a comment\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 3 2 2\n"
     "space directions: (0.5,0,0) (0,0.5,0) (0,0,2)\nkinds: domain domain domain\nendian: little\n"
     "encoding: raw\nspace origin: (-1,2.5,1e1)\nslope:=2\nintercept:=-1024\n\n"},
    {"v.nrrd", "NRRD0003\ntype: unsigned char\ndimension: 4\nsizes: 1 3 2 2\nspacings: nan 1 1 2\n"
               "kinds: vector domain domain domain\nunits: \"\" \"mm\" \"mm\" \"cm\"\nencoding: gzip\n\n"},
    {"v.nhdr", "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 2 2\nendian: big\nencoding: raw\nline skip: 1\n"
               "byte skip: 4\ndata file: d%02d 1 2 1\n"},
    {"v.nhdr", "NRRD0005\ntype: int8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nbyte skip: -1\n"
               "data file: LIST\nd01\nd02\n"},
    {"v.mha",
     "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = True\n"
     "CompressedData = False\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = -1 2.5 1e1\n"
     "ElementSpacing = 0.5 0.5 2\nDimSize = 3 2 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"},
    {"v.mhd", "NDims = 3\nDimSize = 2 2 2\nHeaderSize = 3\nElementType = MET_UCHAR\nElementDataFile = "
              "LIST\nd01\nd02\n"},
    {"v.mhd",
     "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementSize = 1 1 1\nCompressedData = True\n"
     "CompressedDataSize = 9\nElementDataFile = d%02d 1 2 1\n"},
};

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Bytes that mean something to a parser. */
static const char spice[] = "0123456789-+.,:=%()\"\n\r\t #eExn\xff";

static size_t damage(uint32_t *state, const char *text, char *out, size_t room)
{
    size_t n = strlen(text);
    memcpy(out, text, n);
    for (uint32_t times = 1 + next_random(state) % 3; times--;) {
        size_t at = next_random(state) % n, length = 1 + next_random(state) % 12;
        if (length > n - at)
            length = n - at;
        switch (next_random(state) % 4) {
        case 0: /* another byte, zero included */
            out[at] = spice[next_random(state) % sizeof spice];
            break;
        case 1: /* a gap */
            memmove(out + at, out + at + length, n - at - length);
            n -= length;
            break;
        case 2: /* an echo */
            if (n + length <= room) {
                memmove(out + at + length, out + at, n - at);
                n += length;
            }
            break;
        default: /* an end */
            n = at;
        }
        if (n == 0)
            break;
    }
    return n;
}

static void any_damage_ends_in_a_result(void **state)
{
    (void)state;
    uint32_t seed = 2024;
    char text[1024];
    unsigned char data[64];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (unsigned char)(i * 37);
    data[3] = '\n';
    for (int round = 0; round < 1500; round++) {
        size_t pick = next_random(&seed) % (sizeof good / sizeof *good);
        size_t n = damage(&seed, good[pick][1], text, sizeof text - sizeof data);
        put_file("d01", "", data, sizeof data);
        put_file("d02", "", data, 24);
        size_t tail = next_random(&seed) % sizeof data;
        memcpy(text + n, data, tail);
        const char *path = put_file(good[pick][0], "", text, n + tail);

        struct brick_source *source = NULL;
        struct brick_error err = {.message = ""};
        int code = fmt_source_open(&source, path, &fmt_source_defaults, &err);
        if (code == 0) {
            /* Sizes were checked against the files, so a few hundred bytes of file cannot ask for much. */
            size_t bytes = voxel_count(source) * brick_type_bytes(source->type);
            assert_true(bytes <= 1032 * (sizeof text + 2 * sizeof data));
            void *voxels = malloc(bytes);
            assert_non_null(voxels);
            code = read_all(source, 1, voxels, &err);
            free(voxels);
            brick_source_destroy(&source);
        }
        assert_null(source);
        assert_true(code <= 0);
        if (code)
            assert_true(err.code == code && *err.message && !strchr(err.message, '\n'));
        empty_folder(NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(any_damage_ends_in_a_result, empty_folder)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
