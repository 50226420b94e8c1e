/* Classification by the transfer function itself: piecewise linear in the value, jumps taken to the right, exact to
 * float32. Uniform bins give the pieces that can hold a value; SEARCH_STEPS halvings find the one that does, without a loop
 * (llvmpipe counts every loop's turns, see raycast.glsl).
 *
 * Three elements a piece: (start, extinction a mm at start, its slope, the slopes' origin), (linear rgb at start, where the next
 * piece starts), (the colour's slope, -). */
uniform samplerBuffer pieces;
uniform usamplerBuffer bins; /* first and last piece of each */
uniform float bin_origin, bin_scale, bin_last;
uniform vec2 visible; /* all values outside are transparent */
float first_bin = HELD(bin_origin), bins_a_value = HELD(bin_scale), last_bin = HELD(bin_last);
vec2 visible_held = HELD(visible);

struct Piece {
    int index;
    vec4 head; /* the first element */
};

Piece find_piece(float v)
{
    precise float bin = min(max((v - first_bin) * bins_a_value, 0.0), last_bin);
    uvec2 range = texelFetch(bins, int(bin)).rg;
    int low = int(range.x), high = int(range.y);
    for (int i = 0; i < SEARCH_STEPS; i++) {
        int middle = (low + high + 1) / 2;
        bool up = v >= texelFetch(pieces, 3 * middle).x;
        low = up ? middle : low;
        high = up ? high : max(middle - 1, low);
    }
    return Piece(low, texelFetch(pieces, 3 * low));
}

/* Extinction a mm. */
float extinction(Piece p, float v)
{
    precise float sigma = p.head.y + p.head.z * (v - p.head.w);
    return max(sigma, 0.0);
}

vec3 emission(Piece p, vec3 rgb, vec3 slope, float v)
{
    return clamp(rgb + slope * (v - p.head.w), 0.0, 1.0);
}

vec3 emission(Piece p, float v)
{
    return emission(p, texelFetch(pieces, 3 * p.index + 1).rgb, texelFetch(pieces, 3 * p.index + 2).rgb, v);
}
