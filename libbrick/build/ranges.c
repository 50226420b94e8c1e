/* Smallest and largest are separable: slices are folded along z for a layer of macrocells, then rows along y,
 * then what is left, one row for each row of macrocells, along x. Nearly all work is in the first, on long
 * contiguous rows. */
#include "ranges.h"

#include <math.h>
#include <stdint.h>

size_t ranges_scratch_bytes(const struct brick_grid *grid)
{
    size_t side = (size_t)grid->edge + 2 * grid->border;
    return 2 * (side * side + side) * brick_type_bytes(grid->type);
}

#define T            uint8_t
#define NAME(f)      f##_u8
#define LOWEST       0
#define HIGHEST      UINT8_MAX
#define CANONICAL(v) (v)
#include "ranges_typed.h"
#define T            int8_t
#define NAME(f)      f##_i8
#define LOWEST       INT8_MIN
#define HIGHEST      INT8_MAX
#define CANONICAL(v) (v)
#include "ranges_typed.h"
#define T            uint16_t
#define NAME(f)      f##_u16
#define LOWEST       0
#define HIGHEST      UINT16_MAX
#define CANONICAL(v) (v)
#include "ranges_typed.h"
#define T            int16_t
#define NAME(f)      f##_i16
#define LOWEST       INT16_MIN
#define HIGHEST      INT16_MAX
#define CANONICAL(v) (v)
#include "ranges_typed.h"
#define T            float
#define NAME(f)      f##_f32
#define LOWEST       (-INFINITY)
#define HIGHEST      INFINITY
#define CANONICAL(v) ((v) + 0.0f)
#include "ranges_typed.h"

void ranges_of_brick(const struct kernels *k, const struct brick_grid *grid, const struct brick_place *place,
                     const void *lo, const void *hi, size_t sx, size_t sy, void *macrocells, void *scratch,
                     struct brick_entry *entry)
{
    switch (grid->type) {
    case BRICK_U8:
        ranges_u8(k, grid, place, lo, hi, sx, sy, macrocells, scratch, entry);
        break;
    case BRICK_I8:
        ranges_i8(k, grid, place, lo, hi, sx, sy, macrocells, scratch, entry);
        break;
    case BRICK_U16:
        ranges_u16(k, grid, place, lo, hi, sx, sy, macrocells, scratch, entry);
        break;
    case BRICK_I16:
        ranges_i16(k, grid, place, lo, hi, sx, sy, macrocells, scratch, entry);
        break;
    default:
        ranges_f32(k, grid, place, lo, hi, sx, sy, macrocells, scratch, entry);
        break;
    }
}
