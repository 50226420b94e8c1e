/* Marching: what takes a ray from sample to sample, in passes. Three loops in turn: the first leaps over inactive blocks by
 * whole samples, the second looks at samples of an active block until one counts, the third takes samples while they count. A
 * leap never passes a sample of an active block, and a sample of an inactive block adds nothing, so skipping changes no bit.
 * Rays that are marched side by side wait for each other at the end of each loop, and so what is dear, a sample that counts, is
 * done for many at once. (Loops have their condition at the end: where there is no branch around what no ray
 * does, as in llvmpipe, one at the beginning costs a turn more.) A ray that needs a brick that is not in the atlas says so, looks
 * which bricks it will meet next, and leaves what the next pass needs.
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
    uint k, run;     /* of `run` samples from k on all is said */
    uint fetched;    /* samples so far */
    Block block;     /* the surroundings of sample k or, after a leap, k + run */
    bool enters;     /* block: from its sample k + run up to sample */
    uint last;
    Near3 at;        /* sample k, from block.place on */
    bool counts;     /* sample k; and how it looks */
    Look look;
    bool done;       /* no sample after k counts any more */
    bool waits;      /* for block.brick */
#ifdef PREINTEGRATED
    Block before;    /* where the sample before was */
#endif
};

uint march_next(March m)
{
    return m.done ? m.k : m.k + m.run;
}

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

#ifdef STAND_IN
/* From one sample that is looked at to the next. */
Near3 march_stride(March m, Ray ray)
{
    Near3 s = ray.stride;
    for (uint n = m.run; n > 1u; n >>= 1)
        s = near_add(s, s);
    return s;
}
#else
#define march_stride(m, ray) (ray.stride)
#endif

/* Over inactive blocks in `left` leaps at most, to a sample of an active one, and on through what is active behind it in the
 * same brick: that is the run. Without a brick for the sample the ray waits. The last sample is not where steps lead, so it has
 * a run of its own. */
void march_leap(inout March m, Ray ray, inout uint left)
{
    m.k += m.run;
    m.run = 0u;
    m.enters = m.waits = false;
    uint next = m.k;
    bool on;
    do {
        Fixed3 at = ray_sample(ray, next);
        ivec3 home = owner(at.cell);
        Block block = locate(home);
        uint run = min(leap(ray, at, home, block.shift), ray.end - min(next, ray.end));
        bool alone = block.shift == near_shift; /* the next block is in another brick */
#ifdef PREINTEGRATED
        Block here = block;
        bool single;
        block = supplier(ray, next, at, here, m.before, single);
        run = single ? min(run, 1u) : run;
        alone = alone || single;
#endif
        bool live = run > 0u && block.live;
        if (m.enters) {
            on = live && !alone && block.place == m.block.place;
        } else {
            on = run > 0u && left > 0u && !block.missing;
            m.waits = run > 0u && block.missing;
            m.enters = on && live;
            m.block = block;
            m.at = near_from(at, block.place);
            if (on && !live) {
                m.done = state_skip(m.state, block);
                on = !m.done;
#ifndef SKIP
                run = 1u;
#endif
                m.k += on ? run : 0u;
                left--;
            }
        }
        if (on) {
            next += run;
#ifdef PREINTEGRATED
            m.before = here;
#endif
        }
        on = on && !(m.enters && (alone || next - m.k >= left));
    } while (on);
    if (m.enters) {
        uint run = min(next - m.k, max(ray.count - 1u - m.k, 1u));
#ifdef CUT
        run = m.k == 0u ? 1u : run;
#endif
        m.last = m.k + min(run, left) - 1u;
        m.run = samples_in(m.block);
        m.at = near_subtract(m.at, march_stride(m, ray));
        m.k -= m.run;
    }
}

/* To the next sample of the run that counts, or the last. */
void march_scan(inout March m, Ray ray, inout uint left)
{
    bool on;
    do {
        m.at = near_add(m.at, march_stride(m, ray));
        m.k += m.run;
        m.fetched++;
        left--;
        m.counts = state_look(m.state, ray, m.k, m.at, m.block, m.look);
        m.done = !state_marching(m.state);
        on = !m.counts && !m.done && m.k + m.run <= m.last;
    } while (on);
}

bool march_goes_on(March m, Ray ray, uint left)
{
    return !m.done && !m.waits && left > 0u && m.k + m.run < ray.end;
}

/* On by up to `left` samples and leaps. */
void march(inout March m, Ray ray, uint left)
{
    bool on = march_goes_on(m, ray, left);
    if (!on)
        return;
    do {
        do {
            march_leap(m, ray, left);
            m.counts = false;
            if (m.enters) {
#ifdef PREINTEGRATED
                state_enter(m.state, ray, m.k + m.run, m.block);
                m.fetched += min(m.k + m.run, 1u);
#endif
                march_scan(m, ray, left);
            }
            on = !m.counts && march_goes_on(m, ray, left);
        } while (on);
        if (m.counts) {
            do {
                m.done = state_take(m.state, ray, m.k, m.at, m.block, m.look);
                m.counts = false;
#if defined(PREINTEGRATED) && MODE == MODE_SHADED
                if (m.state.lacks) {
                    m.block.brick = m.block.lacks;
                    m.waits = true;
                    m.run = 0u;
                }
#endif
                if (!m.done && !m.waits && m.k + m.run <= m.last)
                    march_scan(m, ray, left);
                on = m.counts && !m.done;
            } while (on);
        }
        on = march_goes_on(m, ray, left);
    } while (on);
}

/* The next active bricks on the ray's way from sample k in `brick`, resident or not: what is wanted stays. */
void want_ahead(Ray ray, uint k, int brick)
{
    Fixed3 at = ray_sample(ray, k);
    ivec3 home = owner(at.cell);
    int left = look_ahead;
    for (int turn = 0; turn < LOOK_AHEAD_TURNS && left > 0; turn++) {
        uint jump = leap(ray, at, home, edge_shift);
        if (k + jump >= ray.end)
            break;
        k += jump;
        at = ray_sample(ray, k);
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
    m.run = 0u;
    m.counts = m.enters = m.waits = false;
    m.done = !state_marching(m.state);
#ifdef PREINTEGRATED
    m.before = locate(owner(ray_sample(ray, max(m.k, 1u) - 1u).cell));
#endif
    return true;
}

/* Leave what the next pass needs. */
void march_suspend(March m, ivec2 pixel)
{
    imageStore(state_image, pixel, state_pack(m.state));
    imageStore(progress_image, pixel, uvec4(march_next(m), m.fetched, 0u, 0u));
}

/* Leave the pixel's colour, or what the next round needs and what the ray waits for. */
void march_store(inout March m, Ray ray, ivec2 pixel)
{
    vec4 colour = vec4(0.0);
    bool ended = m.done || march_next(m) >= ray.end;
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
        want_ahead(ray, march_next(m), m.block.brick);
#endif
}
