/* The main pass (Krueger and Westermann 2003, sections 2.1 and 2.2): STEPS_A_PASS samples of the rays that stop.glsl let
 * through. Blocks that are empty cost as much as others here: to leap over them is the other pass's work. */
layout(early_fragment_tests) in;

#if MODE == MODE_ISO
/* Back to front, so that of several crossings the one nearest the eye stays, without a branch that ends the loop. It has no use
 * for samples behind a brick that is not there yet: how far there are bricks is seen first. */
void march_back(inout March m, Ray ray, uint steps)
{
    uint end = m.k, limit = min(ray.end - m.k, steps) + m.k;
    Fixed3 at = ray_sample(ray, end);
    while (end < limit) {
        ivec3 home = owner(at.cell);
        m.block = locate(home);
        m.waits = m.block.missing;
        if (m.waits)
            break;
        end += min(leap(ray, at, home, edge_shift), limit - end);
        at = ray_sample(ray, end);
    }
    const uint first = m.k;
    int last = m.state.side, behind = SIDE_NONE, near = SIDE_NONE;
    m.k = end;
    for (uint k = end; k > first;) {
        at = ray_sample(ray, k - 1u);
        Block block = locate(owner(at.cell));
        ivec3 inside = owner(at.cell) >> block.shift;
        do {
            int side = block.above ? SIDE_ABOVE : SIDE_BELOW;
            if (block.live) {
                side = side_of(spot_of(block, at));
                m.fetched++;
            }
            if (sides_differ(side, behind)) {
                near = side;
                m.k = k;
            }
            last = k == end ? side : last;
            behind = side;
            k--;
            at = ray_sample(ray, k - 1u);
        } while (k > first && owner(at.cell) >> block.shift == inside);
    }
    if (sides_differ(m.state.side, behind)) {
        near = m.state.side;
        m.k = first;
    }
    m.state.side = last;
    if (near != SIDE_NONE) {
        m.state.side = near;
        m.state.stage = STAGE_HALVE;
        m.done = true;
        m.waits = false;
    }
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Ray ray;
    March m;
    if (!march_load(pixel, ray, m))
        return;
#if MODE == MODE_ISO
    if (!m.done)
        march_back(m, ray, uint(STEPS_A_PASS));
#else
    march(m, ray, uint(STEPS_A_PASS));
#endif
    march_store(m, ray, pixel);
}
