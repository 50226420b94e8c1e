/* Raycasting of bricks in an atlas, in passes (Krueger and Westermann 2003, section 2; the two sizes of blocks, for the
 * cache and for skipping, are Scharsach 2005, section 8).
 *
 * A pass takes a ray to its end, or to where it needs a brick that is not in the atlas. It also ends after STEPS_A_PASS
 * samples and leaps; without a limit a draw would run into a desktop's watchdog, and into llvmpipe, which ends all loops of a
 * shader after 65535 turns in total (of 8 or 16 rays at once, counting for each). */
layout(early_fragment_tests) in;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Ray ray;
    March m;
    if (!march_load(pixel, ray, m))
        return;
    march(m, ray, uint(STEPS_A_PASS));
    march_store(m, ray, pixel);
}
