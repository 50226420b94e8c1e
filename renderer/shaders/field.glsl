/* The trilinear field out of bricks: page table, atlas, and exact fetches. All values are stored values (times the sign of
 * the slope, so that they ascend with the physical ones).
 *
 * Page, one word a brick of the level (residency/page_table.h): bits 30-31 state, 24-29 level, 16-23, 8-15, 0-7 the
 * slot's z, y, x in the atlas. */
#define STATE_EMPTY    0u
#define STATE_ABOVE    1u
#define STATE_RESIDENT 2u
#define STATE_MISSING  3u

uniform usamplerBuffer pages;
/* Two planes of bits a slot: macrocell is active; macrocell is above the isovalue. */
uniform usamplerBuffer macrocells;
uniform VOXEL_SAMPLER atlas;
uniform ivec3 level_last;   /* the last voxel's index */
uniform ivec3 level_bricks; /* bricks on each axis */
uniform ivec3 slots;        /* slots on each axis */
uniform ivec3 slot_size;    /* voxels */
uniform ivec3 slot_cells;   /* macrocells a slot has room for on each axis */
uniform int plane_words;    /* words of one plane of a slot */
uniform int brick_shift, macro_shift, border;
uniform float value_sign;

/* What a sample's surroundings are. */
struct Block {
    bool live;    /* samples are to be fetched */
    bool missing; /* they would be, but the brick is not in the atlas */
    bool above;   /* iso, inactive: on which side */
    int brick;    /* its place in the page table */
    int shift;    /* edge of the inactive block, log2 */
    ivec3 offset; /* active: atlas texel = voxel + offset */
};

/* The voxel whose brick supplies a cell. */
ivec3 owner(ivec3 cell)
{
    return clamp(cell, ivec3(0), level_last);
}

int brick_of(ivec3 voxel)
{
    ivec3 at = voxel >> brick_shift;
    return (at.z * level_bricks.y + at.y) * level_bricks.x + at.x;
}

Block locate(ivec3 voxel)
{
    Block block;
    block.brick = brick_of(voxel);
    uint page = texelFetch(pages, block.brick).r;
    ivec3 slot = ivec3(page & 255u, page >> 8 & 255u, page >> 16 & 255u);
    ivec3 start = (voxel >> brick_shift) << brick_shift;
    block.live = page >> 30 == STATE_RESIDENT;
    block.missing = page >> 30 == STATE_MISSING;
    block.above = page >> 30 == STATE_ABOVE;
    block.shift = brick_shift;
    block.offset = slot * slot_size + border - start;
#ifdef SKIP
    if (block.live) {
        ivec3 cell = (voxel - start) >> macro_shift;
        int bit = (cell.z * slot_cells.y + cell.y) * slot_cells.x + cell.x;
        int word = ((slot.z * slots.y + slot.y) * slots.x + slot.x) * 2 * plane_words + (bit >> 5);
        block.live = (texelFetch(macrocells, word).r >> (bit & 31) & 1u) != 0u;
#if MODE == MODE_ISO
        if (!block.live)
            block.above = (texelFetch(macrocells, word + plane_words).r >> (bit & 31) & 1u) != 0u;
#endif
        block.shift = macro_shift;
    }
#endif
    return block;
}

/* Corners of a cell: x fastest, z = 0 in low, z = 1 in high. */
struct Cell {
    vec4 low, high;
};

float voxel(ivec3 texel)
{
    return float(texelFetch(atlas, texel, 0).r);
}

uniform vec2 atlas_texel; /* 1 / the atlas's size */

/* The four texels from t on of one layer, in the order of a Cell. A gather takes them as they are, in one go: no filter is
 * involved, and the point that four texels share is half a texel from where the choice of four would change. */
vec4 square(ivec3 t)
{
    return vec4(textureGather(atlas, vec3(vec2(t.xy + 1) * atlas_texel, float(t.z)))).wzxy;
}

Cell cell_fetch(ivec3 t)
{
    return Cell(square(t), square(t + ivec3(0, 0, 1)));
}

#ifdef NONFINITE
bool any_nonfinite(vec4 v)
{
    return any(equal(floatBitsToUint(v) & 0x7f800000u, uvec4(0x7f800000u)));
}
#endif

/* A cell with a corner that is NaN or infinite is transparent. */
bool cell_valid(Cell c)
{
#ifdef NONFINITE
    return !any_nonfinite(c.low) && !any_nonfinite(c.high);
#else
    return true;
#endif
}

float bilinear(vec4 v, vec2 t)
{
    precise vec2 x = v.xz + t.x * (v.yw - v.xz);
    precise float y = x.x + t.y * (x.y - x.x);
    return y;
}

float cell_value(Cell c, vec3 t)
{
    precise vec4 x = vec4(c.low.xz, c.high.xz) + t.x * (vec4(c.low.yw, c.high.yw) - vec4(c.low.xz, c.high.xz));
    precise vec2 y = x.xz + t.y * (x.yw - x.xz);
    precise float z = y.x + t.z * (y.y - y.x);
    return z * value_sign;
}

#if MODE == MODE_SHADED || MODE == MODE_ISO
/* f(p + e) - f(p - e) along one axis: rows of four voxels at the corners of the other two axes. */
float central(vec4 v0, vec4 v1, vec4 v2, vec4 v3, float t, vec2 other)
{
    precise vec4 difference = (v2 + t * (v3 - v2)) - (v0 + t * (v1 - v0));
    return bilinear(difference, other);
}

/* Central differences of the trilinear field at +-1 voxel, in the level's index space. t: the cell's texel. Where a
 * neighbour is not finite the component is 0. */
vec3 cell_gradient(Cell c, ivec3 t, vec3 f)
{
    const ivec3 x = ivec3(1, 0, 0), y = ivec3(0, 1, 0), z = ivec3(0, 0, 1);
    vec4 left0 = square(t - x), left1 = square(t - x + z), right0 = square(t + x), right1 = square(t + x + z);
    vec4 front0 = square(t - y), front1 = square(t - y + z), back0 = square(t + y), back1 = square(t + y + z);
    vec3 g = vec3(central(vec4(left0.xz, left1.xz), vec4(c.low.xz, c.high.xz), vec4(c.low.yw, c.high.yw),
                          vec4(right0.yw, right1.yw), f.x, f.yz),
                  central(vec4(front0.xy, front1.xy), vec4(c.low.xy, c.high.xy), vec4(c.low.zw, c.high.zw),
                          vec4(back0.zw, back1.zw), f.y, f.xz),
                  central(square(t - z), c.low, c.high, square(t + 2 * z), f.z, f.xy));
#ifdef NONFINITE
    for (int i = 0; i < 3; i++)
        if ((floatBitsToUint(g[i]) & 0x7f800000u) == 0x7f800000u)
            g[i] = 0.0;
#endif
    return 0.5 * g;
}
#endif
