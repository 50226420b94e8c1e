/* The table of voxel types. */
#include <brick/type.h>

#include <string.h>

static const struct {
    const char *name;
    size_t bytes;
    bool integer;
} types[BRICK_TYPE_COUNT] = {
    [BRICK_U8] = {"u8", 1, true},   [BRICK_I8] = {"i8", 1, true},    [BRICK_U16] = {"u16", 2, true},
    [BRICK_I16] = {"i16", 2, true}, [BRICK_F32] = {"f32", 4, false}, [BRICK_U32] = {"u32", 4, true},
    [BRICK_I32] = {"i32", 4, true}, [BRICK_F64] = {"f64", 8, false},
};

static bool known(enum brick_type type)
{
    return (unsigned)type < BRICK_TYPE_COUNT;
}

size_t brick_type_bytes(enum brick_type type)
{
    return known(type) ? types[type].bytes : 0;
}

const char *brick_type_name(enum brick_type type)
{
    return known(type) ? types[type].name : NULL;
}

enum brick_type brick_type_from_name(const char *name)
{
    unsigned t = 0;
    while (t < BRICK_TYPE_COUNT && strcmp(name, types[t].name) != 0)
        t++;
    return (enum brick_type)t;
}

bool brick_type_is_integer(enum brick_type type)
{
    return known(type) && types[type].integer;
}

double brick_type_load(enum brick_type type, const void *voxels, size_t i)
{
    switch (type) {
    case BRICK_U8:
        return ((const uint8_t *)voxels)[i];
    case BRICK_I8:
        return ((const int8_t *)voxels)[i];
    case BRICK_U16:
        return ((const uint16_t *)voxels)[i];
    case BRICK_I16:
        return ((const int16_t *)voxels)[i];
    case BRICK_F32:
        return (double)((const float *)voxels)[i];
    case BRICK_U32:
        return ((const uint32_t *)voxels)[i];
    case BRICK_I32:
        return ((const int32_t *)voxels)[i];
    case BRICK_F64:
        return ((const double *)voxels)[i];
    default:
        return 0.0;
    }
}

void brick_type_store(enum brick_type type, void *voxels, size_t i, double v)
{
    switch (type) {
    case BRICK_U8:
        ((uint8_t *)voxels)[i] = (uint8_t)v;
        break;
    case BRICK_I8:
        ((int8_t *)voxels)[i] = (int8_t)v;
        break;
    case BRICK_U16:
        ((uint16_t *)voxels)[i] = (uint16_t)v;
        break;
    case BRICK_I16:
        ((int16_t *)voxels)[i] = (int16_t)v;
        break;
    default:
        ((float *)voxels)[i] = (float)v;
        break;
    }
}

void brick_type_swap_bytes(enum brick_type type, void *voxels, size_t n)
{
    switch (brick_type_bytes(type)) {
    case 2:
        for (uint16_t *p = voxels, *end = p + n; p != end; p++)
            *p = __builtin_bswap16(*p);
        break;
    case 4:
        for (uint32_t *p = voxels, *end = p + n; p != end; p++)
            *p = __builtin_bswap32(*p);
        break;
    case 8:
        for (uint64_t *p = voxels, *end = p + n; p != end; p++)
            *p = __builtin_bswap64(*p);
        break;
    default:
        break;
    }
}
