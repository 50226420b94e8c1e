/* Between two main passes (Krueger and Westermann 2003, sections 2.1 and 2.3): which rays go on? A ray that has ended, that
 * waits for a brick, or that is still in empty space when its leaps are used up, gets depth 1, and the main pass does not run for
 * it. The others get depth 0 and stand before a sample that counts. */
void main()
{
    gl_FragDepth = 1.0;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Ray ray;
    March m;
    if (!march_load(pixel, ray, m))
        return;
#ifdef SKIP
    uint leaps = uint(LEAPS_A_PASS);
#else
    uint leaps = 0u;
#endif
    if (!m.done && m.k < ray.end)
        march_leap(m, ray, leaps);
#ifdef SKIP
    bool here = m.block.live;
#else
    bool here = !m.block.missing;
#endif
    if (m.done || (march_next(m) < ray.end && here)) {
        march_suspend(m, pixel);
        gl_FragDepth = 0.0;
    } else {
        march_store(m, ray, pixel);
    }
}
