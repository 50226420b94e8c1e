/* The trilinear field out of bricks: page table, atlas, and what lies between voxels. All values are stored values (times
 * the sign of the slope, so that they ascend with the physical ones).
 *
 * Page, one word a brick of the level (residency/page_table.h): bits 30-31 state, 24-29 level, 16-23, 8-15, 0-7 the
 * slot's z, y, x in the atlas. */
#define STATE_INACTIVE 0u
#define STATE_RESIDENT 1u
#define STATE_WHOLE    2u
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
uniform vec2 atlas_texel; /* 1 / the atlas's size */
#ifdef VOXEL_NORMALISED
uniform float voxel_scale, voxel_offset; /* stored value = texel * scale - offset */
uniform float voxel_grains;              /* a unit of the stored value */
#endif

#define NEAR_SHIFT 7 /* a block is no larger, so that its voxels and those around it have numbers of 8 bits */
ivec3 last_voxel = HELD(level_last), bricks = HELD(level_bricks);
ivec3 slots_held = HELD(slots), slot_voxels = HELD(slot_size), slot_macrocells = HELD(slot_cells);
int macrocell_words = HELD(plane_words), margin = HELD(border);
int edge_shift = HELD(brick_shift), macrocell_shift = HELD(macro_shift), near_shift = min(edge_shift, NEAR_SHIFT);
float sign_held = HELD(value_sign);
vec2 texel_size = HELD(atlas_texel);

/* What a sample's surroundings are. */
struct Block {
    bool live;    /* samples are to be fetched */
    bool missing; /* they would be, but the brick is not in the atlas */
    bool wanted;  /* the brick is resident or missing, whatever the macrocell */
    bool above;   /* iso, inactive: on which side */
    int brick;    /* its place in the page table */
    int shift;    /* edge of the block, log2 */
    ivec3 place;  /* a voxel before it, which near positions count from */
    ivec3 offset; /* active: atlas texel = voxel + offset */
#ifdef STAND_IN
    ivec3 halvings; /* from the level to the brick's own, of which offset counts voxels */
#endif
#ifdef PREINTEGRATED
    int lacks;    /* the brick that a gradient must come from, and that is not in the atlas; or -1 */
#endif
};

#ifdef STAND_IN
/* For a look before the end: nothing is waited for. Where a brick is missing a coarser one stands in, or nothing. */
uniform ivec3 level_halvings[STAND_IN];

void locate_stand_in(inout Block block, uint page, ivec3 slot, ivec3 voxel)
{
    block.halvings = ivec3(0);
    if (!block.missing)
        return;
    block.missing = false;
    block.halvings = level_halvings[page >> 24 & 63u];
    block.live = block.halvings != ivec3(0);
    block.offset = slot * slot_voxels + margin - ((voxel >> edge_shift >> block.halvings) << edge_shift);
}
#endif

/* The voxel whose brick supplies a cell. */
ivec3 owner(ivec3 cell)
{
    return clamp(cell, ivec3(0), last_voxel);
}

int brick_of(ivec3 voxel)
{
    ivec3 at = voxel >> edge_shift;
    return (at.z * bricks.y + at.y) * bricks.x + at.x;
}

Block locate(ivec3 voxel)
{
    Block block;
    block.brick = brick_of(voxel);
    uint page = texelFetch(pages, block.brick).r;
    ivec3 slot = ivec3(page & 255u, page >> 8 & 255u, page >> 16 & 255u);
    ivec3 start = (voxel >> edge_shift) << edge_shift;
    uint state = page >> 30;
    block.live = state == STATE_RESIDENT || state == STATE_WHOLE;
    block.missing = state == STATE_MISSING;
    block.wanted = state != STATE_INACTIVE;
    block.above = (page & 1u) != 0u;
    block.shift = near_shift;
    block.place = ((voxel >> near_shift) << near_shift) - margin;
    block.offset = slot * slot_voxels + margin - start;
#ifdef SKIP
    if (state == STATE_RESIDENT) {
        ivec3 cell = (voxel - start) >> macrocell_shift;
        int bit = (cell.z * slot_macrocells.y + cell.y) * slot_macrocells.x + cell.x;
        int word = ((slot.z * slots_held.y + slot.y) * slots_held.x + slot.x) * 2 * macrocell_words + (bit >> 5);
        block.live = (texelFetch(macrocells, word).r >> (bit & 31) & 1u) != 0u;
#if MODE == MODE_ISO
        if (!block.live)
            block.above = (texelFetch(macrocells, word + macrocell_words).r >> (bit & 31) & 1u) != 0u;
#endif
        block.shift = macrocell_shift;
    }
#endif
#ifdef STAND_IN
    locate_stand_in(block, page, slot, voxel);
#endif
    return block;
}

float voxel(ivec3 texel)
{
#ifdef VOXEL_NORMALISED
    return floor(texelFetch(atlas, texel, 0).r * voxel_scale + 0.5) - voxel_offset;
#else
    return float(texelFetch(atlas, texel, 0).r);
#endif
}

#ifdef FILTER_FAST
/* The sampler interpolates in layers. Its bits depend on voxels and fraction only, wherever the slot is: the edges of layers
 * are powers of two and the fraction has 12 bits, so the coordinate is exact and the sampler finds that fraction in it
 * again. The fraction stays below 1: no voxel beyond the cell is read. */
struct Cell {
    ivec3 texel;
};

Cell cell_fetch(ivec3 t)
{
    return Cell(t);
}

/* As the atlas holds it. */
float cell_filter(Cell c, vec3 t)
{
    vec3 fraction = min(floor(t * 4096.0 + 0.5), 4095.0) / 4096.0;
    vec2 at = (vec2(c.texel.xy) + (fraction.xy + 0.5)) * texel_size;
    float low = textureLod(atlas, vec3(at, float(c.texel.z)), 0.0).r;
    float high = textureLod(atlas, vec3(at, float(c.texel.z + 1)), 0.0).r;
    precise float v = low + fraction.z * (high - low);
    return v;
}

bool cell_valid(Cell c)
{
    return true; /* volumes with voxels that are not finite are not filtered */
}

/* Integers normalised to [0,1] lose what they lie above zero by. Taken to the nearest grain, which is more than twice as
 * large as the rounding error, a value stays between its corners, and so culling by ranges stays right. */
float cell_value(Cell c, vec3 t)
{
    float v = cell_filter(c, t);
#ifdef VOXEL_NORMALISED
    v = floor(v * (voxel_scale * voxel_grains) + 0.5) / voxel_grains - voxel_offset;
#endif
    return v * sign_held;
}

void cell_range(Cell c, out float low, out float high)
{
    low = voxel(c.texel);
    high = low;
    for (int i = 1; i < 8; i++) {
        float v = voxel(c.texel + (ivec3(i, i >> 1, i >> 2) & 1));
        low = min(low, v);
        high = max(high, v);
    }
}

#if MODE == MODE_SHADED || MODE == MODE_ISO
/* Central differences of the filtered field at +-1 voxel, in the level's index space but for a positive factor. */
vec3 cell_gradient(Cell c, ivec3 t, vec3 f)
{
    const ivec3 x = ivec3(1, 0, 0), y = ivec3(0, 1, 0), z = ivec3(0, 0, 1);
    return vec3(cell_filter(Cell(t + x), f) - cell_filter(Cell(t - x), f),
                cell_filter(Cell(t + y), f) - cell_filter(Cell(t - y), f),
                cell_filter(Cell(t + z), f) - cell_filter(Cell(t - z), f));
}
#endif
#else
/* Corners of a cell: x fastest, z = 0 in low, z = 1 in high. */
struct Cell {
    vec4 low, high;
};

/* The four texels from t on of one layer, in the order of a Cell. A gather takes them as they are, in one go: no filter is
 * involved, and the point that four texels share is half a texel from where the choice of four would change. */
vec4 square(ivec3 t)
{
    return vec4(textureGather(atlas, vec3(vec2(t.xy + 1) * texel_size, float(t.z)))).wzxy;
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
    return z * sign_held;
}

/* The least and the greatest of the corners' stored values. */
void cell_range(Cell c, out float low, out float high)
{
    vec4 low4 = min(c.low, c.high), high4 = max(c.low, c.high);
    low = min(min(low4.x, low4.y), min(low4.z, low4.w));
    high = max(max(high4.x, high4.y), max(high4.z, high4.w));
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
#endif
