/* Single-pass raycasting of bricks in an atlas (Krueger and Westermann 2003, section 2; the two sizes of blocks, for the
 * cache and for skipping, are Scharsach 2005, section 8).
 *
 * Two loops in turn: the first leaps over inactive blocks by whole samples, the second fetches samples while they stay in
 * one active block. A leap never passes a sample of an active block, and a sample of an inactive block adds nothing, so
 * skipping changes no bit. */
/* A pass takes a ray STEPS_A_PASS samples and leaps further and leaves what the next one needs: colour is the picture's
 * once progress.x is FINISHED, the ray's packed state before; progress.y counts samples fetched. Most pictures are done in
 * one pass; without a limit a draw would run into a desktop's watchdog, and into llvmpipe, which ends all loops of a
 * shader after 65535 turns in total (of 8 or 16 rays at once, counting for each). */
layout(location = 0) out vec4 colour;
layout(location = 1) out uvec2 progress;
uniform bool resume;
uniform sampler2D carried;
uniform usampler2D carried_progress;
#define FINISHED 0xffffffffu


/* How many samples, from the one at `at`, lie in the block: at least 1, and never too many: the way to the exit, in steps,
 * is shortened by more than its rounding error. */
uint leap(Ray ray, Fixed3 at, ivec3 home, int shift)
{
#ifdef SKIP
    ivec3 low = (home >> shift) << shift;
    vec3 f = fixed_fraction(at);
    vec3 ahead = vec3(low + (1 << shift) - at.cell) - f, behind = vec3(at.cell - low) + f;
    vec3 exits = (mix(behind, ahead, ray.forward) - 1.0e-6) * ray.pace + ray.never;
    float way = min(exits.x, min(exits.y, exits.z)) * 0.99999 + 0.9999;
    return uint(clamp(way, 1.0, 16777216.0));
#else
    return 1u;
#endif
}

#if MODE == MODE_DVR || MODE == MODE_SHADED
uniform float depth_end; /* optical depth at which a ray ends */

/* Emission and absorption; optical depth rather than transmittance is summed, which loses nothing however thin. */
struct State {
    vec3 rgb;
    float depth, transmittance;
};

State state_init()
{
    return State(vec3(0.0), 0.0, 1.0);
}

vec4 state_pack(State s)
{
    return vec4(s.rgb, s.depth);
}

State state_unpack(vec4 v)
{
    return State(v.rgb, v.a, exponential(-v.a));
}

/* This and the next answer: is the ray done? */
bool state_skip(inout State s, Block block)
{
    return false;
}

bool state_sample(inout State s, Ray ray, uint k, Fixed3 at, Block block)
{
    ivec3 texel = at.cell + block.offset;
    vec3 f = fixed_fraction(at);
    Cell c = cell_fetch(texel);
    if (!cell_valid(c))
        return false;
    float v = cell_value(c, f);
    Piece piece = find_piece(v);
    float sigma = extinction(piece, v);
    if (!(sigma > 0.0))
        return false;
    vec3 rgb = emission(piece, v);
#if MODE == MODE_SHADED
    rgb = shade(rgb, cell_gradient(c, texel, f), ray.view);
#endif
    precise float x = sigma * (k + 1u == ray.count ? ray.last_length_mm : ray.length_mm);
    precise vec3 sum = s.rgb + (s.transmittance * opacity(x)) * rgb;
    s.rgb = sum;
    s.depth += x;
    s.transmittance = exponential(-s.depth);
    return s.depth > depth_end;
}

vec4 state_colour(inout State s, Ray ray, uint k)
{
    return vec4(s.rgb, opacity(s.depth));
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

vec4 state_pack(State s)
{
    return vec4(s.largest, s.any, 0.0, 0.0);
}

State state_unpack(vec4 v)
{
    return State(v.x, v.y != 0.0);
}

bool state_skip(inout State s, Block block)
{
    return false;
}

bool state_sample(inout State s, Ray ray, uint k, Fixed3 at, Block block)
{
    Cell c = cell_fetch(at.cell + block.offset);
    if (!cell_valid(c))
        return false;
    float v = cell_value(c, fixed_fraction(at));
    if (!s.any || v > s.largest)
        s.largest = v;
    s.any = true;
    return false;
}

vec4 state_colour(inout State s, Ray ray, uint k)
{
    if (!s.any)
        return vec4(0.0);
    Piece piece = find_piece(s.largest);
    float a = opacity(extinction(piece, s.largest) * unit_mm);
    return vec4(a * emission(piece, s.largest), a);
}

#elif MODE == MODE_ISO
uniform float isovalue;    /* stored; a value is above when it is not less */
uniform vec3 surface;      /* colour */
uniform uint refinements;  /* bisections */

#define SIDE_NONE  0 /* a cell that is not finite has none, and bounds no surface */
#define SIDE_BELOW 1
#define SIDE_ABOVE 2

struct State {
    int side;  /* of the sample before */
    bool hit;  /* between the sample before and this one */
    uint refined;
};

State state_init()
{
    return State(SIDE_NONE, false, 0u);
}

vec4 state_pack(State s)
{
    return vec4(s.side, 0.0, 0.0, 0.0);
}

State state_unpack(vec4 v)
{
    return State(int(v.x), false, 0u);
}

bool state_side(inout State s, int side)
{
    s.hit = s.side != SIDE_NONE && side != SIDE_NONE && side != s.side;
    if (!s.hit)
        s.side = side;
    return s.hit;
}

bool state_skip(inout State s, Block block)
{
    return state_side(s, block.above ? SIDE_ABOVE : SIDE_BELOW);
}

int side_of(Fixed3 at, ivec3 offset)
{
    Cell c = cell_fetch(at.cell + offset);
    if (!cell_valid(c))
        return SIDE_NONE;
    return cell_value(c, fixed_fraction(at)) >= isovalue ? SIDE_ABOVE : SIDE_BELOW;
}

bool state_sample(inout State s, Ray ray, uint k, Fixed3 at, Block block)
{
    return state_side(s, side_of(at, block.offset));
}

/* Does the isovalue lie between the cell's corners, give or take the interpolation's rounding? */
bool straddles(Fixed3 at)
{
    Block block = locate(owner(at.cell));
    if (!block.live)
        return false;
    Cell c = cell_fetch(at.cell + block.offset);
    if (!cell_valid(c))
        return false;
    vec4 low4 = min(c.low * value_sign, c.high * value_sign), high4 = max(c.low * value_sign, c.high * value_sign);
    float low = min(min(low4.x, low4.y), min(low4.z, low4.w));
    float high = max(max(high4.x, high4.y), max(high4.z, high4.w));
    float slack = low == high ? 0.0 : max(abs(low), abs(high)) * 4.8e-7;
    return low - slack < isovalue && high + slack >= isovalue;
}

/* Bisect by side only. The hit is the far end if its cell holds the surface, else the near end: of two samples on
 * different sides in cells that touch, one does. That rule knows cells, not bricks. */
vec4 state_colour(inout State s, Ray ray, uint k)
{
    if (!s.hit)
        return vec4(0.0);
    Fixed3 near = ray_sample(ray, k - 1u), far = ray_sample(ray, k);
    Fixed3 width = fixed_subtract(far, near);
    for (uint i = 0u; i < refinements; i++) {
        width = fixed_half(width);
        Fixed3 middle = fixed_add(near, width);
        Block block = locate(owner(middle.cell));
        int side = block.above ? SIDE_ABOVE : SIDE_BELOW;
        if (block.live) {
            side = side_of(middle, block.offset);
            s.refined++;
        }
        if (side == SIDE_NONE)
            break;
        if (side == s.side)
            near = middle;
        else
            far = middle;
    }
    bool at_far = straddles(far);
    if (!at_far)
        far = near;
    vec3 gradient = vec3(0.0);
    if (at_far || straddles(near)) {
        ivec3 texel = far.cell + locate(owner(far.cell)).offset;
        gradient = cell_gradient(cell_fetch(texel), texel, fixed_fraction(far));
    }
    return vec4(shade(surface, gradient, ray.view), 1.0);
}
#endif

void main()
{
    Ray ray;
    State state = state_init();
    uint k = 0u, fetched = 0u, left = uint(STEPS_A_PASS);
    bool done = false;
    if (resume) {
        colour = texelFetch(carried, ivec2(gl_FragCoord.xy), 0);
        progress = texelFetch(carried_progress, ivec2(gl_FragCoord.xy), 0).xy;
        if (progress.x == FINISHED)
            return;
        state = state_unpack(colour);
        k = progress.x;
        fetched = progress.y;
    }
    colour = vec4(0.0);
    progress = uvec2(FINISHED, 0u);
    if (!ray_init(ivec2(gl_FragCoord.xy) + tile_origin, ray))
        return;

    Fixed3 at = ray_sample(ray, k);
    while (!done && k < ray.count && left > 0u) {
        ivec3 home = owner(at.cell);
        Block block = locate(home);
        while (!block.live && left > 0u) {
            done = state_skip(state, block);
            if (done)
                break;
            uint jump = min(leap(ray, at, home, block.shift), ray.count - k);
            k += jump;
            left--;
            if (k >= ray.count)
                break;
            at = k + 1u == ray.count ? ray.last : fixed_add(at, fixed_times(ray.step, jump));
            home = owner(at.cell);
            block = locate(home);
        }
        if (done || k >= ray.count || left == 0u)
            break;
        ivec3 inside = home >> block.shift;
        do {
            done = state_sample(state, ray, k, at, block);
            fetched++;
            if (done)
                break;
            k++;
            left--;
            at = fixed_add(at, ray.step);
            if (k + 1u == ray.count)
                at = ray.last;
        } while (k < ray.count && left > 0u && owner(at.cell) >> block.shift == inside);
    }
    if (done || k >= ray.count) {
        colour = state_colour(state, ray, k);
#if MODE == MODE_ISO
        fetched += state.refined;
#endif
        progress = uvec2(FINISHED, fetched);
    } else {
        colour = state_pack(state);
        progress = uvec2(k, fetched);
    }
}
