/* Fixtures of the volume format tests: a folder of their own, files written byte for byte, volumes read
 * whole. */
#ifndef TESTS_FORMAT_FILES_H
#define TESTS_FORMAT_FILES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <formats/formats.h>

static char folder[] = "/tmp/brick-formats-XXXXXX";

static inline int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

/* Names in the folder; several may be alive at once. */
static inline const char *in_folder(const char *name)
{
    static char paths[8][512];
    static unsigned next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static inline unsigned count_files(void)
{
    unsigned count = 0;
    DIR *d = opendir(folder);
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d));)
        count += e->d_name[0] != '.';
    closedir(d);
    return count;
}

static inline int empty_folder(void **state)
{
    (void)state;
    DIR *d = opendir(folder);
    if (!d)
        return -1;
    for (struct dirent *e; (e = readdir(d));)
        if (e->d_name[0] != '.')
            unlink(in_folder(e->d_name));
    closedir(d);
    return 0;
}

static inline int remove_folder(void **state)
{
    empty_folder(state);
    return rmdir(folder);
}

/* text, then n bytes. */
static inline const char *put_file(const char *name, const char *text, const void *bytes, size_t n)
{
    const char *path = in_folder(name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(text, 1, strlen(text), f), strlen(text));
    if (n)
        assert_int_equal(fwrite(bytes, 1, n, f), n);
    assert_int_equal(fclose(f), 0);
    return path;
}

static inline struct brick_source *open_source(const char *path, const struct fmt_source_params *params)
{
    struct brick_source *source = NULL;
    struct brick_error err = {.message = ""};
    if (fmt_source_open(&source, path, params ? params : &fmt_source_defaults, &err))
        fail_msg("%s", err.message);
    return source;
}

static inline size_t voxel_count(const struct brick_source *source)
{
    const uint64_t *d = source->geometry.dims;
    return (size_t)(d[0] * d[1] * d[2]);
}

/* Read everything, `slab` slices at a time. */
static inline int read_all(struct brick_source *source, uint64_t slab, void *dst, struct brick_error *err)
{
    const uint64_t *d = source->geometry.dims;
    unsigned char *p = dst;
    for (uint64_t z = 0; z < d[2]; z += slab) {
        uint64_t n = d[2] - z < slab ? d[2] - z : slab;
        int code = source->read(source, z, n, p, err);
        if (code)
            return code;
        p += n * d[0] * d[1] * brick_type_bytes(source->type);
    }
    return 0;
}

/* The source holds these voxels, for every way of cutting it into slabs; path is opened anew for each. */
static inline void expect_voxels(const char *path, const struct fmt_source_params *params,
                                 const uint64_t dims[3], enum brick_type type, const void *voxels)
{
    for (uint64_t slab = 1; slab <= dims[2] + 1; slab++) {
        struct brick_source *source = open_source(path, params);
        for (int a = 0; a < 3; a++)
            assert_int_equal(source->geometry.dims[a], dims[a]);
        assert_int_equal(source->type, type);
        size_t bytes = voxel_count(source) * brick_type_bytes(type);
        void *got = calloc(1, bytes);
        assert_non_null(got);
        struct brick_error err = {.message = ""};
        if (read_all(source, slab, got, &err))
            fail_msg("%s", err.message);
        assert_memory_equal(got, voxels, bytes);
        free(got);
        brick_source_destroy(&source);
    }
}

/* Opening, or else reading, fails with this code and a message of one line that holds `says`. */
static inline void expect_failure(const char *path, const struct fmt_source_params *params, int code,
                                  const char *says)
{
    struct brick_source *source = NULL;
    struct brick_error err = {.message = ""};
    int got = fmt_source_open(&source, path, params ? params : &fmt_source_defaults, &err);
    if (got == 0) {
        void *voxels = calloc(voxel_count(source), brick_type_bytes(source->type));
        assert_non_null(voxels);
        got = read_all(source, 1, voxels, &err);
        free(voxels);
        brick_source_destroy(&source);
    }
    assert_null(source);
    if (got != code || !strstr(err.message, says) || strchr(err.message, '\n'))
        fail_msg("expected %d with '%s', got %d: %s", code, says, got, err.message);
}

/* |difference| at most tolerance in every element. */
static inline void expect_affine(const char *path, const struct fmt_source_params *params,
                                 const double affine[3][4], double tolerance)
{
    struct brick_source *source = open_source(path, params);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) {
            double d = source->geometry.affine[r][c] - affine[r][c];
            if (!(d <= tolerance && -d <= tolerance))
                fail_msg("%s: affine[%d][%d] is %.17g, expected %.17g", path, r, c,
                         source->geometry.affine[r][c], affine[r][c]);
        }
    brick_source_destroy(&source);
}

#endif
