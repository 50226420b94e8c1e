/* However a conversion is carried out - threads, memory, tiles, spools, vectors or none - the file is the
 * same; and the memory it is given is a limit that the system can enforce. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <brick/threads.h>
#include <xxhash.h>

#include "../support/memory_source.h"

static uint64_t hash_file(const char *path)
{
    size_t n;
    void *data = read_file(path, &n);
    assert_non_null(data);
    uint64_t hash = XXH3_64bits(data, n);
    free(data);
    return hash;
}

/* A ball with noise in it, in air of one value; floats with some NaN, and zeros of both signs. */
static void *ball(enum brick_type type, uint64_t nx, uint64_t ny, uint64_t nz)
{
    size_t width = brick_type_bytes(type);
    unsigned char *voxels = malloc((size_t)(nx * ny * nz) * width), *to = voxels;
    for (uint64_t z = 0, i = 0; z < nz; z++)
        for (uint64_t y = 0; y < ny; y++)
            for (uint64_t x = 0; x < nx; x++, i++, to += width) {
                double dx = (double)x / (double)nx - 0.4, dy = (double)y / (double)ny - 0.5,
                       dz = (double)z / (double)nz - 0.5;
                bool inside = dx * dx + dy * dy + dz * dz < 0.12;
                uint64_t r = noise64(11, i);
                float f = r % 997 == 0 ? NAN : r % 5 == 0 ? -0.0f : (float)(r % 4096) * 0.37f;
                if (!inside)
                    f = 0.0f;
                uint64_t integer = inside ? r % 4096 : 7;
                memcpy(to, type == BRICK_F32 ? (const void *)&f : (const void *)&integer, width);
            }
    return voxels;
}

struct seen {
    bool ring, tiles, spools, spools_with_ring;
};

/* Build with a memory cap; false if that is too little. */
static bool build(struct memory_source *source, const struct brick_build_params *params, struct seen *seen,
                  uint64_t *hash)
{
    struct brick_build_report report;
    struct brick_error err = {0};
    int code = brick_build(&source->base, test_path("plan.brick"), params, &report, &err);
    if (code == BRICK_ERR_MEMORY)
        return false;
    if (code)
        fail_msg("%s", err.message);
    assert_true(report.memory_bytes <= params->memory_bytes);
    /* Every byte is read once, but for the borders of tiles: at worst of one brick, twice `border` on each
     * axis. */
    uint64_t read = report.stage[BRICK_STAGE_READ].bytes;
    double border = 1.0 + 2.0 * params->border / params->edge;
    assert_true(report.tiled ? (double)read < (double)report.input_bytes * border * border * border
                             : read == report.input_bytes);
    assert_int_equal(report.stage[BRICK_STAGE_COMPRESS].bytes == 0, report.bricks == report.bricks_constant);
    for (int stage = 0; stage < BRICK_STAGES; stage++)
        assert_int_equal(report.stage[stage].ns == 0, report.stage[stage].bytes == 0);
    assert_non_null(brick_build_stage_name(brick_build_limit(&report)));
    seen->ring = seen->ring || !report.tiled;
    seen->tiles = seen->tiles || report.tiled;
    seen->spools = seen->spools || report.spooled_bytes;
    seen->spools_with_ring = seen->spools_with_ring || (!report.tiled && report.spooled_bytes);
    *hash = hash_file(test_path("plan.brick"));
    return true;
}

static void same_file_by_any_plan(void **state)
{
    (void)state;
    const struct {
        enum brick_type type;
        uint64_t dims[3];
        double spacing_z;
        uint32_t edge;
    } volumes[] = {
        {BRICK_U16, {397, 381, 43}, 1.0, 32}, /* odd everywhere, levels of odd sizes too */
        {BRICK_I8, {700, 500, 40}, 2.5, 16},  /* z is not halved at first */
        {BRICK_F32, {230, 250, 30}, 1.0, 8},
        {BRICK_U8, {9000, 70, 36}, 0.4, 32}, /* lines of bricks in parts; z is halved alone */
    };
    for (size_t v = 0; v < sizeof volumes / sizeof volumes[0]; v++) {
        const uint64_t *n = volumes[v].dims;
        void *voxels = ball(volumes[v].type, n[0], n[1], n[2]);
        struct memory_source source;
        memory_source_init(&source, volumes[v].type, n[0], n[1], n[2], voxels);
        source.base.geometry.affine[2][2] = volumes[v].spacing_z;
        struct brick_build_params params = brick_build_defaults;
        params.edge = volumes[v].edge;
        params.plain = true;
        params.threads = 1;
        struct seen seen = {0};
        uint64_t first, hash;
        assert_true(build(&source, &params, &seen, &first));
        params.plain = false;
        for (unsigned threads = 1; threads <= 5; threads++) {
            params.threads = threads;
            assert_true(build(&source, &params, &seen, &hash));
            assert_int_equal(hash, first);
        }
        int (*boxes)(struct brick_source *, const uint64_t[3], const uint64_t[3], void *,
                     struct brick_error *) = source.base.read_box;
        unsigned runs = 0;
        /* From too little memory to enough for everything, by way of all plans. */
        bool spooled = true;
        for (uint64_t cap = UINT64_C(15) << 20; spooled; cap += cap / 16) {
            struct seen now = {0};
            params.memory_bytes = cap;
            params.threads = 1 + runs % 3;
            source.base.read_box = runs % 2 ? boxes : NULL;
            if (!build(&source, &params, &now, &hash))
                continue;
            assert_int_equal(hash, first);
            runs++;
            spooled = now.tiles || now.spools;
            seen.tiles = seen.tiles || now.tiles;
            seen.spools = seen.spools || now.spools;
            seen.spools_with_ring = seen.spools_with_ring || now.spools_with_ring;
        }
        assert_true(seen.ring && seen.tiles && seen.spools && seen.spools_with_ring);
        free(voxels);
    }
}

/* A source whose voxels are cheap to read twice, and what it is told and asked for. */
static struct {
    int (*read_box)(struct brick_source *, const uint64_t[3], const uint64_t[3], void *,
                    struct brick_error *);
    uint64_t told; /* slices */
    bool parts;    /* of lines were asked for */
} fetching;

static void note_fetch(struct brick_source *source, uint64_t z, uint64_t count)
{
    assert_int_equal(z, fetching.told);
    assert_true(count > 0 && count <= source->geometry.dims[2] - z);
    fetching.told += count;
}

static int read_fetched(struct brick_source *source, const uint64_t lo[3], const uint64_t hi[3], void *dst,
                        struct brick_error *err)
{
    assert_true(hi[2] <= fetching.told);
    fetching.parts = fetching.parts || hi[0] - lo[0] < source->geometry.dims[0];
    return fetching.read_box(source, lo, hi, dst, err);
}

/* Where whole slices leave no room for coarser levels, tiles of whole lines go before scratch files, if their
 * borders are cheap to read. */
static void cheap_borders_go_before_scratch_files(void **state)
{
    (void)state;
    void *voxels = ball(BRICK_U16, 397, 381, 43);
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, 397, 381, 43, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.edge = 16;
    params.threads = 2;
    fetching.read_box = source.base.read_box;
    unsigned better = 0;
    for (params.memory_bytes = UINT64_C(20) << 20; params.memory_bytes < UINT64_C(60) << 20;
         params.memory_bytes += UINT64_C(1) << 20) {
        struct seen without = {0}, with = {0};
        uint64_t first, second;
        source.base.read_box = fetching.read_box;
        source.base.fetch = NULL;
        if (!build(&source, &params, &without, &first))
            continue;
        source.base.read_box = read_fetched;
        source.base.fetch = note_fetch;
        fetching.told = 0;
        fetching.parts = false;
        assert_true(build(&source, &params, &with, &second));
        assert_int_equal(first, second);
        assert_int_equal(fetching.told, with.tiles ? 43 : 0);
        if (without.spools_with_ring) {
            assert_true(with.tiles && !fetching.parts);
            better += !with.spools;
        } else {
            assert_int_equal(with.ring, without.ring);
        }
    }
    assert_true(better > 0);
    free(voxels);
}

/* Bytes of a file that depends on no library: what a change of the format or of a definition changes, and
 * nothing else. */
static void golden_file(void **state)
{
    (void)state;
    void *voxels = ball(BRICK_U16, 70, 60, 50);
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, 70, 60, 50, voxels);
    struct brick_build_params params = brick_build_defaults;
    params.codec = BRICK_CODEC_NONE;
    struct seen seen;
    uint64_t hash;
    assert_true(build(&source, &params, &seen, &hash));
    assert_int_equal(hash, UINT64_C(0xb3c3b47751078409));
    free(voxels);
}

/* A volume that is computed, so that it takes no memory itself. */
static int read_computed(struct brick_source *base, const uint64_t lo[3], const uint64_t hi[3], void *dst,
                         struct brick_error *err)
{
    (void)base;
    (void)err;
    uint16_t *to = dst;
    for (uint64_t z = lo[2]; z < hi[2]; z++)
        for (uint64_t y = lo[1]; y < hi[1]; y++)
            for (uint64_t x = lo[0]; x < hi[0]; x++)
                *to++ = (uint16_t)((x ^ y) + 31 * z);
    return BRICK_OK;
}

enum { CAP_MIB = 128 };

/* A row of bricks of 3072 x 3072 slices of u16 needs 36 x 18 MiB, five times the limit. */
static void the_system_enforces_the_cap(void **state)
{
    (void)state;
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
    skip(); /* they map terabytes */
#endif
    struct memory_source source;
    memory_source_init(&source, BRICK_U16, 3072, 3072, 40, NULL);
    source.base.read = NULL;
    source.base.read_box = read_computed;
    const char *path = test_path("hard.brick");
    fflush(stdout);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        /* Data and address space: every page the process could touch, its program and libraries included. */
        const struct rlimit limit = {(rlim_t)CAP_MIB << 20, (rlim_t)CAP_MIB << 20};
        struct brick_build_params params = brick_build_defaults;
        params.memory_bytes = (uint64_t)CAP_MIB << 20;
        params.threads = 2;
        struct brick_build_report report;
        struct brick_error err = {0};
        int code = setrlimit(RLIMIT_AS, &limit) ? 1 : brick_build(&source.base, path, &params, &report, &err);
        if (code)
            fprintf(stderr, "%s\n", err.message);
        else if (brick_peak_rss_bytes() > params.memory_bytes || !report.tiled) {
            fprintf(stderr, "peak %llu bytes, planned %llu, tiled %d\n",
                    (unsigned long long)brick_peak_rss_bytes(), (unsigned long long)report.memory_bytes,
                    report.tiled);
            code = 1;
        }
        _exit(code ? 1 : 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    struct brick_error err = {0};
    struct brick_volume *volume;
    assert_int_equal(brick_volume_open(&volume, path, &err), 0);
    uint16_t back[8];
    const uint64_t lo[3] = {3060, 3071, 39}, hi[3] = {3068, 3072, 40};
    assert_int_equal(brick_volume_read_box(volume, 0, lo, hi, back, &err), 0);
    for (uint64_t i = 0; i < 8; i++)
        assert_int_equal(back[i], (uint16_t)(((3060 + i) ^ 3071) + 31 * 39));
    brick_volume_close(&volume);
}

/* Before slice 70 is missed there are bricks of the first ones, worth resuming. */
static const char *gone_part;
static void wait_for_bricks(void)
{
    struct stat file;
    for (int i = 0; i < 60000 && (stat(gone_part, &file) || file.st_size < 1 << 20); i++)
        usleep(1000);
}

static int read_until(struct brick_source *base, uint64_t z, uint64_t count, void *dst,
                      struct brick_error *err)
{
    size_t slice = (size_t)(base->geometry.dims[0] * base->geometry.dims[1]) * 2;
    for (uint64_t i = 0; i < count * slice; i++)
        ((unsigned char *)dst)[i] = (unsigned char)noise64(z, i);
    if (z + count > 70) {
        wait_for_bricks();
        return brick_fail(err, BRICK_ERR_IO, "slice 70 is gone");
    }
    return BRICK_OK;
}

/* A source that fails and a disk that is full end the conversion: no thread waits for another for ever, the
 * message is the first failure's, and nothing is left but what can be resumed. */
static void failures_end_it(void **state)
{
    (void)state;
    struct memory_source source;
    struct brick_build_params params = brick_build_defaults;
    struct brick_error err = {0};
    memory_source_init(&source, BRICK_U16, 200, 200, 120, NULL);
    source.base.read = read_until;
    gone_part = strdup(test_path("gone.brick.part"));
    for (params.threads = 1; params.threads <= 4; params.threads++) {
        const char *path = test_path("gone.brick"), *first = "slice 70 is gone";
        source.base.state = "memory";
        assert_int_equal(brick_build(&source.base, path, &params, NULL, &err), BRICK_ERR_IO);
        assert_memory_equal(err.message, first, strlen(first));
        assert_non_null(strstr(err.message, "for --resume"));
        assert_int_equal(access(path, F_OK), -1);
        assert_int_equal(access(test_path("gone.brick.part"), F_OK), 0);
        source.base.state = NULL;
        assert_int_equal(brick_build(&source.base, path, &params, NULL, &err), BRICK_ERR_IO);
        assert_string_equal(err.message, first);
        assert_int_equal(access(path, F_OK), -1);
        assert_int_equal(access(test_path("gone.brick.part"), F_OK), -1);
    }
    const char *path = test_path("full.brick");
    fflush(stdout);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const struct rlimit limit = {1 << 20, 1 << 20}; /* of every file: all writes beyond fail */
        signal(SIGXFSZ, SIG_IGN);
        int code = setrlimit(RLIMIT_FSIZE, &limit);
        memory_source_init(&source, BRICK_U16, 200, 200, 60, NULL);
        source.base.read = read_until;
        for (params.threads = 1; !code && params.threads <= 4; params.threads++)
            if (brick_build(&source.base, path, &params, NULL, &err) != BRICK_ERR_IO ||
                !strstr(err.message, "write at byte"))
                code = 1;
        _exit(code ? 1 : 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_int_equal(access(path, F_OK), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_system_enforces_the_cap), /* first: what others freed still counts as theirs */
        cmocka_unit_test(failures_end_it),
        cmocka_unit_test(golden_file),
        cmocka_unit_test(same_file_by_any_plan),
        cmocka_unit_test(cheap_borders_go_before_scratch_files),
    };
    return cmocka_run_group_tests_name("plans", tests, NULL, NULL);
}
