/* What a ray gathers on its way, by mode: State, what a sample and a leap over an inactive block add to it, its four words
 * between passes, and the picture's colour in the end. A sample is looked at first; only one that counts is taken. Samples have numbers and the state between two of them is kept whole,
 * so it does not matter which method marches, nor where its passes end. */
/* A position in a block as the atlas holds it. */
struct Spot {
    ivec3 texel;
    vec3 fraction;
};

#ifdef STAND_IN
/* A place of the level in the voxels of the brick that it is seen in: index0 = 2^h index + (2^h - 1) / 2. */
Fixed3 place_in(Block block, Fixed3 at)
{
    const uvec3 half_voxel = uvec3(0x80000000u);
    uvec3 carry, borrow, fraction = uaddCarry(at.fraction, half_voxel, carry);
    ivec3 cell = at.cell + ivec3(carry);
    uvec3 rest = uvec3(cell) & ((uvec3(1u) << block.halvings) - 1u);
    fraction = (fraction >> block.halvings) | (rest << 1 << (31 - block.halvings));
    fraction = usubBorrow(fraction, half_voxel, borrow);
    return Fixed3((cell >> block.halvings) - ivec3(borrow), fraction, uvec3(0u));
}

Spot spot_of(Block block, Fixed3 at)
{
    at = place_in(block, at);
    return Spot(at.cell + block.offset, fixed_fraction(at));
}

Spot spot_of(Block block, Near3 at)
{
    return spot_of(block, fixed_near(at, block.place));
}

vec3 gradient_in(Block block, vec3 gradient)
{
    return gradient / vec3(ivec3(1) << block.halvings);
}

/* Samples that one stands for: a coarse brick is looked at as often as it has voxels. */
uint samples_in(Block block)
{
    ivec3 h = block.halvings;
    return MODE == MODE_ISO ? 1u : 1u << min(h.x, min(h.y, h.z));
}
#else
Spot spot_of(Block block, Fixed3 at)
{
    return Spot(at.cell + block.offset, fixed_fraction(at));
}

Spot spot_of(Block block, Near3 at)
{
    return Spot(near_cell(at) + (block.place + block.offset), near_fraction(at));
}

#define gradient_in(block, gradient) (gradient)
#define samples_in(block)            1u
#endif

#if MODE == MODE_MIP || MODE == MODE_ISO
struct Look {
    bool nothing;
};
#endif

#if MODE == MODE_DVR || MODE == MODE_SHADED
uniform float depth_end; /* optical depth at which a ray ends */
float depth_limit = HELD(depth_end);

/* Emission and absorption; optical depth rather than transmittance is summed, which loses nothing however thin. */
struct State {
    vec3 rgb;
    float depth, transmittance;
#ifdef PREINTEGRATED
    bool known; /* that the sample before has a value: */
    End front;
    bool lacks; /* the piece at hand a brick for its gradient */
#endif
};

State state_of(vec4 v, float transmittance)
{
    State s;
    s.rgb = v.rgb;
    s.depth = v.a;
    s.transmittance = transmittance;
    return s;
}

State state_init()
{
    return state_of(vec4(0.0), 1.0);
}

uvec4 state_pack(State s)
{
    return floatBitsToUint(vec4(s.rgb, s.depth));
}

State state_unpack(uvec4 bits)
{
    vec4 v = uintBitsToFloat(bits);
    return state_of(v, exponential(-v.a));
}

/* This, state_add and state_take answer: is the ray done? */
bool state_skip(inout State s, Block block)
{
    return false;
}

/* A piece of the ray of optical depth x and opacity alpha. */
bool state_add(inout State s, float x, float alpha, vec3 rgb)
{
    precise vec3 sum = s.rgb + (s.transmittance * alpha) * rgb;
    s.rgb = sum;
    s.depth += x;
    s.transmittance = exponential(-s.depth);
    return s.depth > depth_limit;
}

#ifdef PREINTEGRATED
bool end_at(Spot spot, out End end)
{
    Cell c = cell_fetch(spot.texel);
    bool valid = cell_valid(c);
    end = end_of(valid ? cell_value(c, spot.fraction) : 0.0);
    return valid;
}

/* Before the first sample that `block` supplies: the one before that. */
void state_enter(inout State s, Ray ray, uint k, Block block)
{
    s.known = k > 0u;
    if (s.known)
        s.known = end_at(spot_of(block, ray_sample(ray, k - 1u)), s.front);
}

#define Look Stretch

/* The piece of the ray between the sample before and this one. Where one of them has no value it is transparent. The light
 * falls on it as on its middle. */
bool state_look(inout State s, Ray ray, uint k, Near3 at, Block block, out Look look)
{
    End front = s.front;
    bool known = s.known;
    s.known = end_at(spot_of(block, at), s.front);
    s.lacks = false;
    look = stretch_of(front, s.front, ray_length(ray, k));
    return known && s.known && look.depth > 0.0;
}

bool state_take(inout State s, Ray ray, uint k, Near3 at, Block block, Look look)
{
    float alpha = opacity(look.depth);
    vec3 rgb = stretch_colour(look, alpha);
#if MODE == MODE_SHADED
    s.lacks = block.lacks >= 0;
    if (s.lacks)
        return false;
    Spot middle = spot_of(block, ray_middle(ray, k, fixed_near(at, block.place)));
    rgb = shade(rgb, cell_gradient(cell_fetch(middle.texel), middle.texel, middle.fraction), ray.view);
#endif
    return state_add(s, look.depth, alpha, rgb);
}
#else
struct Look {
    float value;
    Cell cell;
};

/* All values outside visible_held are transparent; of the others the function itself says it. */
bool state_look(inout State s, Ray ray, uint k, Near3 at, Block block, out Look look)
{
    Spot spot = spot_of(block, at);
    look.cell = cell_fetch(spot.texel);
    look.value = cell_value(look.cell, spot.fraction);
    return cell_valid(look.cell) && look.value >= visible_held.x && look.value <= visible_held.y;
}

bool state_take(inout State s, Ray ray, uint k, Near3 at, Block block, Look look)
{
    float v = look.value;
    Piece piece = find_piece(v);
    float sigma = extinction(piece, v);
    if (!(sigma > 0.0))
        return false;
    vec3 rgb = emission(piece, v);
#if MODE == MODE_SHADED
    Spot spot = spot_of(block, at);
    rgb = shade(rgb, gradient_in(block, cell_gradient(look.cell, spot.texel, spot.fraction)), ray.view);
#endif
    precise float x = sigma * ray_length(ray, k);
#ifdef STAND_IN
    x *= float(samples_in(block));
#endif
    return state_add(s, x, opacity(x), rgb);
}
#endif

/* The picture's colour, of a ray that has ended; false when the brick in `block` must come first. */
bool state_end(inout State s, Ray ray, uint k, inout uint fetched, inout Block block, out vec4 colour)
{
    colour = vec4(s.rgb, opacity(s.depth));
    return true;
}

#elif MODE == MODE_MIP
uniform float unit_mm; /* length that a control point's opacity belongs to */

struct State {
    float largest;
    bool any;
};

State state_init()
{
    return State(0.0, false);
}

uvec4 state_pack(State s)
{
    return uvec4(floatBitsToUint(s.largest), s.any, 0u, 0u);
}

State state_unpack(uvec4 bits)
{
    return State(uintBitsToFloat(bits.x), bits.y != 0u);
}

bool state_skip(inout State s, Block block)
{
    return false;
}

bool state_look(inout State s, Ray ray, uint k, Near3 at, Block block, out Look look)
{
    Spot spot = spot_of(block, at);
    Cell c = cell_fetch(spot.texel);
    if (!cell_valid(c))
        return false;
    float v = cell_value(c, spot.fraction);
    if ((floatBitsToUint(v) & 0x7fffffffu) > 0x7f800000u) /* what overflowed to no number does not count */
        return false;
    if (!s.any || v > s.largest)
        s.largest = v;
    s.any = true;
    return false;
}

bool state_end(inout State s, Ray ray, uint k, inout uint fetched, inout Block block, out vec4 colour)
{
    colour = vec4(0.0);
    if (s.any) {
        Piece piece = find_piece(s.largest);
        float a = opacity(extinction(piece, s.largest) * unit_mm);
        colour = vec4(a * emission(piece, s.largest), a);
    }
    return true;
}

#elif MODE == MODE_ISO
uniform float isovalue;    /* stored; a value is above when it is not less */
uniform vec3 surface;      /* colour */
uniform int refinements;   /* bisections */
float threshold = HELD(isovalue);

#define SIDE_NONE  0 /* a cell that is not finite has none, and bounds no surface */
#define SIDE_BELOW 1
#define SIDE_ABOVE 2

/* A ray marches until two samples lie on different sides, then halves the way between them, then looks whether the far end's
 * cell holds the surface, or else the near end's. Each step needs one brick and may have to wait for it. */
#define STAGE_MARCH 0u
#define STAGE_HALVE 1u
#define STAGE_FAR   2u
#define STAGE_NEAR  3u

struct State {
    int side;     /* of the sample before; of the near end */
    uint stage;
    uint halved;  /* times */
    uvec3 path;   /* a bit for each: did the near end move? */
};

State state_init()
{
    return State(SIDE_NONE, STAGE_MARCH, 0u, uvec3(0u));
}

uvec4 state_pack(State s)
{
    return uvec4(uint(s.side) | s.stage << 2 | s.halved << 8, s.path);
}

State state_unpack(uvec4 bits)
{
    return State(int(bits.x & 3u), bits.x >> 2 & 3u, bits.x >> 8, bits.yzw);
}

bool sides_differ(int a, int b)
{
    return a != SIDE_NONE && b != SIDE_NONE && a != b;
}

bool state_side(inout State s, int side)
{
    if (sides_differ(side, s.side))
        s.stage = STAGE_HALVE;
    else
        s.side = side;
    return s.stage != STAGE_MARCH;
}

bool state_skip(inout State s, Block block)
{
    return state_side(s, block.above ? SIDE_ABOVE : SIDE_BELOW);
}

int side_of(Spot spot)
{
    Cell c = cell_fetch(spot.texel);
    if (!cell_valid(c))
        return SIDE_NONE;
    return cell_value(c, spot.fraction) >= threshold ? SIDE_ABOVE : SIDE_BELOW;
}

bool state_look(inout State s, Ray ray, uint k, Near3 at, Block block, out Look look)
{
    state_side(s, side_of(spot_of(block, at)));
    return false;
}

/* Does the isovalue lie between the cell's corners, give or take the interpolation's rounding? */
bool straddles(Fixed3 at, Block block)
{
    if (!block.live)
        return false;
    Cell c = cell_fetch(spot_of(block, at).texel);
    if (!cell_valid(c))
        return false;
    float a, b;
    cell_range(c, a, b);
    float low = min(a * value_sign, b * value_sign), high = max(a * value_sign, b * value_sign);
    float slack = low == high ? 0.0 : max(abs(low), abs(high)) * 4.8e-7;
    return low - slack < isovalue && high + slack >= isovalue;
}

/* Halve by side only, and if cubic until both ends are in one cell, in which the crossing is solved. The hit is the far end if
 * its cell holds the surface, else the near end: of two samples on different sides in cells that touch, one does. That rule
 * knows cells, not bricks. */
bool state_end(inout State s, Ray ray, uint k, inout uint fetched, inout Block block, out vec4 colour)
{
    colour = vec4(0.0);
    if (s.stage == STAGE_MARCH)
        return true;
    Fixed3 near = ray_sample(ray, k - 1u), far = ray_sample(ray, k);
    Fixed3 width = fixed_subtract(far, near);
    for (uint i = 0u; i < uint(refinements); i++) {
#ifdef CUBIC
        if (near.cell == far.cell)
            break;
#endif
        Fixed3 narrow = fixed_half(width), middle = fixed_add(near, narrow);
        if (i >= s.halved) { /* else it was done in an earlier pass */
            if (s.stage != STAGE_HALVE)
                break;
            block = locate(owner(middle.cell));
            if (block.missing)
                return false;
            int side = block.above ? SIDE_ABOVE : SIDE_BELOW;
            if (block.live) {
                side = side_of(spot_of(block, middle));
                fetched++;
            }
            if (side == SIDE_NONE)
                break;
            s.path[i >> 5] |= uint(side == s.side) << (i & 31u);
            s.halved++;
        }
        width = narrow;
        if ((s.path[i >> 5] >> (i & 31u) & 1u) != 0u)
            near = middle;
        else
            far = middle;
    }
    if (s.stage == STAGE_HALVE)
        s.stage = STAGE_FAR;
    bool found = false, one_cell = near.cell == far.cell;
    if (s.stage == STAGE_FAR) {
        block = locate(owner(far.cell));
        if (block.missing)
            return false;
        found = straddles(far, block);
        if (!found)
            s.stage = STAGE_NEAR;
    }
    if (s.stage == STAGE_NEAR) {
        far = near;
        block = locate(owner(far.cell));
        if (block.missing)
            return false;
        found = straddles(far, block);
    }
#ifdef CUBIC
    if (found && one_cell) {
        Fixed3 cell = Fixed3(near.cell, uvec3(0u), uvec3(0u));
        dvec3 from = fixed_to(fixed_subtract(near, cell)), way = fixed_to(width);
        dvec4 c = cubic_in_cell(cell_fetch(near.cell + block.offset), from, way);
        c *= double(value_sign);
        c[0] -= double(isovalue);
        far = fixed_add(near, fixed_from(cubic_crossing(c, s.side == SIDE_ABOVE) * way));
    }
#endif
#ifdef DISTANCES
    double distance_mm = ray_distance_mm(ivec2(gl_FragCoord.xy) + tile_origin, far);
    colour = vec4(float(distance_mm), float(distance_mm - double(float(distance_mm))), 0.0, 1.0);
    return true;
#endif
    vec3 gradient = vec3(0.0);
    if (found) {
        Spot spot = spot_of(block, far);
        gradient = gradient_in(block, cell_gradient(cell_fetch(spot.texel), spot.texel, spot.fraction));
    }
    colour = vec4(shade(surface, gradient, ray.view), 1.0);
    return true;
}
#endif

#if MODE == MODE_MIP || MODE == MODE_ISO
bool state_take(inout State s, Ray ray, uint k, Near3 at, Block block, Look look)
{
    return false; /* a look is all that a sample needs */
}
#endif

bool state_marching(State s)
{
#if MODE == MODE_ISO
    return s.stage == STAGE_MARCH;
#else
    return true;
#endif
}
