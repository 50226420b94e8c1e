/* Marching: what takes a ray from sample to sample, in passes. Two loops in turn: the first leaps over inactive blocks by whole
 * samples, the second fetches samples while they stay in one active block. A leap never passes a sample of an active
 * block, and a sample of an inactive block adds nothing, so skipping changes no bit. A ray that needs a brick that is not in the
 * atlas says so, looks which bricks it will meet next, and leaves what the next pass needs.
 *
 * state_image: the picture's colour as bits once progress.x is FINISHED, the ray's packed state before; progress.y counts
 * samples fetched. */
layout(rgba32ui) uniform uimage2D state_image;
layout(rg32ui) uniform uimage2D progress_image;
uniform bool resume;
uniform int look_ahead; /* active bricks that a waiting ray asks for beyond the one it needs */
#define FINISHED 0xffffffffu
#ifdef MESHES
uniform sampler2D mesh_colour; /* of the nearest mesh, or zeros */
#endif

struct March {
    State state;
    uint k, fetched; /* the next sample's number; samples fetched so far */
    Fixed3 at;       /* the next sample's position */
    Block block;     /* and surroundings, after a loop */
    bool done;       /* no sample of it counts any more */
    bool waits;      /* for block.brick */
    bool alone;      /* block supplies this sample, and not the next */
};

/* How many samples, from the one at `at`, lie in the block: at least 1, and never too many: the way to the exit, in steps,
 * is shortened by more than its rounding error. */
uint leap(Ray ray, Fixed3 at, ivec3 home, int shift)
{
    ivec3 low = (home >> shift) << shift;
    vec3 f = fixed_fraction(at);
    vec3 ahead = vec3(low + (1 << shift) - at.cell) - f, behind = vec3(at.cell - low) + f;
    vec3 exits = (mix(behind, ahead, ray.forward) - 1.0e-6) * ray.pace + ray.never;
    float way = min(exits.x, min(exits.y, exits.z)) * 0.99999 + 0.9999;
    return uint(clamp(way, 1.0, 16777216.0));
}

void march_to(inout March m, Ray ray, uint jump)
{
    m.at = ray_next(ray, m.k, m.at, jump);
    m.k += jump;
}

/* What supplies the sample that the march has come to. */
void march_meet(inout March m, Ray ray, ivec3 home)
{
    m.block = locate(home);
    m.alone = false;
#ifdef PREINTEGRATED
    m.block = supplier(ray, m.k, m.at, m.block, m.alone);
#endif
}

/* Over inactive blocks, to a sample of an active one (which m.block then is, and waits says whether its brick is missing)
 * or the ray's end, in `left` leaps at most. */
void march_leap(inout March m, Ray ray, inout uint left)
{
    bool crosses;
    do {
        ivec3 home = owner(m.at.cell);
        march_meet(m, ray, home);
        crosses = false;
        while (!m.block.live && !m.block.missing && !crosses && left > 0u) {
            m.done = state_skip(m.state, m.block);
            if (m.done)
                break;
#ifdef SKIP
            uint jump = min(leap(ray, m.at, home, m.block.shift), ray.count - m.k);
#else
            uint jump = 1u;
#endif
            left--;
            march_to(m, ray, jump);
            if (m.k >= ray.end)
                break;
            home = owner(m.at.cell);
            Block before = m.block;
            m.block = locate(home);
#ifdef PREINTEGRATED
            /* Of a piece from one inactive block to the next only its bricks say whether it counts. */
            crosses = m.block.brick != before.brick && (m.block.wanted || before.wanted);
#endif
        }
    } while (crosses && left > 0u);
    m.waits = !m.done && m.k < ray.end && m.block.missing;
}

/* On by up to `left` samples and leaps. */
void march(inout March m, Ray ray, uint left)
{
    while (!m.done && !m.waits && m.k < ray.end && left > 0u) {
        march_leap(m, ray, left);
        if (m.done || m.waits || m.k >= ray.end || left == 0u)
            break;
        ivec3 inside = owner(m.at.cell) >> m.block.shift;
#ifdef PREINTEGRATED
        state_enter(m.state, ray, m.k, m.block);
        m.fetched += min(m.k, 1u);
#endif
        do {
            m.done = state_sample(m.state, ray, m.k, m.at, m.block);
            m.fetched++;
            if (m.done)
                break;
#if defined(PREINTEGRATED) && MODE == MODE_SHADED
            if (m.state.lacks) {
                m.block.brick = m.block.lacks;
                m.waits = true;
                break;
            }
#endif
            left--;
#ifdef STAND_IN
            march_to(m, ray, min(samples_in(m.block), ray.count - m.k));
#else
            march_to(m, ray, 1u);
#endif
        } while (m.k < ray.end && left > 0u && !m.alone && owner(m.at.cell) >> m.block.shift == inside);
    }
}

/* The next active bricks on the ray's way from sample k in `brick`, resident or not: what is wanted stays. */
void want_ahead(Ray ray, uint k, Fixed3 at, int brick)
{
    ivec3 home = owner(at.cell);
    int left = look_ahead;
    for (int turn = 0; turn < LOOK_AHEAD_TURNS && left > 0; turn++) {
        uint jump = leap(ray, at, home, brick_shift);
        if (k + jump >= ray.end)
            break;
        at = ray_next(ray, k, at, jump);
        k += jump;
        home = owner(at.cell);
        int next = brick_of(home);
        if (next != brick && texelFetch(pages, next).r >> 30 >= STATE_RESIDENT) {
            want(next, WANT_AHEAD);
            left--;
        }
        brick = next;
    }
}

/* The picture's colour, given the volume's. */
vec4 over_mesh(ivec2 pixel, vec4 colour)
{
#ifdef MESHES
    colour += (1.0 - colour.a) * texelFetch(mesh_colour, pixel, 0);
#endif
    return colour;
}

/* The pixel's ray as the last pass left it; false when it has ended, or meets nothing. */
bool march_load(ivec2 pixel, out Ray ray, out March m)
{
    m.state = state_init();
    m.k = m.fetched = 0u;
    if (resume) {
        uvec2 progress = imageLoad(progress_image, pixel).xy;
        if (progress.x == FINISHED)
            return false;
        m.state = state_unpack(imageLoad(state_image, pixel));
        m.k = progress.x;
        m.fetched = progress.y;
    }
    if (!ray_init(pixel + tile_origin, ray)) {
        imageStore(state_image, pixel, floatBitsToUint(over_mesh(pixel, vec4(0.0))));
        imageStore(progress_image, pixel, uvec4(FINISHED, 0u, 0u, 0u));
        return false;
    }
    if (!resume)
        m.k = ray.begin;
    m.at = ray_sample(ray, m.k);
    m.done = !state_marching(m.state);
    m.waits = false;
    return true;
}

/* Leave what the next pass needs. */
void march_suspend(March m, ivec2 pixel)
{
    imageStore(state_image, pixel, state_pack(m.state));
    imageStore(progress_image, pixel, uvec4(m.k, m.fetched, 0u, 0u));
}

/* Leave the pixel's colour, or what the next round needs and what the ray waits for. */
void march_store(inout March m, Ray ray, ivec2 pixel)
{
    vec4 colour = vec4(0.0);
    bool ended = m.done || m.k >= ray.end;
    if (ended && state_end(m.state, ray, m.k, m.fetched, m.block, colour)) {
        imageStore(state_image, pixel, floatBitsToUint(over_mesh(pixel, colour)));
        imageStore(progress_image, pixel, uvec4(FINISHED, m.fetched, 0u, 0u));
        return;
    }
    march_suspend(m, pixel);
    mark_unfinished(pixel);
#ifndef STAND_IN
    if (ended || m.waits)
        want(m.block.brick, WANT_NEEDED);
    if (m.waits)
        want_ahead(ray, m.k, m.at, m.block.brick);
#endif
}
