#include "memory_source.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int read_memory(struct brick_source *base, uint64_t z, uint64_t count, void *dst,
                       struct brick_error *err)
{
    (void)err;
    struct memory_source *s = (struct memory_source *)base;
    size_t slice = (size_t)(base->geometry.dims[0] * base->geometry.dims[1]) * brick_type_bytes(base->type);
    memcpy(dst, (const unsigned char *)s->voxels + z * slice, count * slice);
    return BRICK_OK;
}

static int read_box_of_memory(struct brick_source *base, const uint64_t lo[3], const uint64_t hi[3],
                              void *dst, struct brick_error *err)
{
    (void)err;
    struct memory_source *s = (struct memory_source *)base;
    const uint64_t *n = base->geometry.dims;
    size_t width = brick_type_bytes(base->type), line = (size_t)(hi[0] - lo[0]) * width;
    unsigned char *to = dst;
    for (uint64_t z = lo[2]; z < hi[2]; z++)
        for (uint64_t y = lo[1]; y < hi[1]; y++, to += line)
            memcpy(to, (const unsigned char *)s->voxels + ((z * n[1] + y) * n[0] + lo[0]) * width, line);
    return BRICK_OK;
}

static void destroy_nothing(struct brick_source *base)
{
    (void)base;
}

void memory_source_init(struct memory_source *source, enum brick_type type, uint64_t nx, uint64_t ny,
                        uint64_t nz, const void *voxels)
{
    memset(source, 0, sizeof *source);
    source->base.type = type;
    source->base.geometry.dims[0] = nx;
    source->base.geometry.dims[1] = ny;
    source->base.geometry.dims[2] = nz;
    for (int a = 0; a < 3; a++)
        source->base.geometry.affine[a][a] = 1.0;
    source->base.geometry.slope = 1.0;
    source->base.provenance = "format: memory\n";
    source->base.state = "memory";
    source->base.read = read_memory;
    source->base.read_box = read_box_of_memory;
    source->base.destroy = destroy_nothing;
    source->voxels = voxels;
}

static char folder[64];

static int remove_one(const char *path, const struct stat *st, int flag, struct FTW *ftw)
{
    (void)st;
    (void)flag;
    (void)ftw;
    return remove(path);
}

static void remove_folder(void)
{
    nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static void give_up(const char *path)
{
    perror(path);
    exit(99);
}

const char *test_path(const char *name)
{
    static char paths[16][256];
    static unsigned turn;
    if (!folder[0]) {
        strcpy(folder, "/tmp/brick-test-XXXXXX");
        if (!mkdtemp(folder))
            give_up(folder);
        atexit(remove_folder);
    }
    char *path = paths[turn++ % 16];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

void *read_file(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    *bytes = 0;
    if (!f)
        return NULL;
    fseek(f, 0, SEEK_END);
    *bytes = (size_t)ftell(f);
    rewind(f);
    void *data = malloc(*bytes + 1);
    if (!data || fread(data, 1, *bytes, f) != *bytes)
        give_up(path);
    fclose(f);
    return data;
}

void write_file(const char *path, const void *data, size_t bytes)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(data, 1, bytes, f) != bytes || fclose(f))
        give_up(path);
}

struct brick_volume *build_and_open(struct memory_source *source, const char *name,
                                    const struct brick_build_params *params)
{
    struct brick_error err = {0};
    struct brick_volume *volume = NULL;
    const char *path = test_path(name);
    if (brick_build(&source->base, path, params ? params : &brick_build_defaults, NULL, &err) ||
        brick_volume_open(&volume, path, &err)) {
        fprintf(stderr, "build_and_open: %s\n", err.message);
        exit(99);
    }
    return volume;
}

uint64_t noise64(uint64_t seed, uint64_t i)
{
    uint64_t x = seed + (i + 1) * UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}
