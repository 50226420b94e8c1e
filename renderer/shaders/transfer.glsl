/* Classification by the transfer function itself: piecewise linear in the value, jumps taken to the right, exact to
 * float32. Uniform bins give the first piece that can hold a value; a few comparisons find the one that does.
 *
 * Three elements a piece: (start, end, extinction a mm at start, its slope), (linear rgb at start, -), (its slope, -). */
uniform samplerBuffer pieces;
uniform usamplerBuffer first_piece;
uniform float bin_origin, bin_scale, bin_last;
uniform int piece_last;

struct Piece {
    int index;
    vec4 head; /* the first element */
};

Piece find_piece(float v)
{
    precise float bin = min(max((v - bin_origin) * bin_scale, 0.0), bin_last);
    Piece p;
    p.index = int(texelFetch(first_piece, int(bin)).r);
    p.head = texelFetch(pieces, 3 * p.index);
    while (p.index < piece_last && v >= p.head.y) {
        p.index++;
        p.head = texelFetch(pieces, 3 * p.index);
    }
    return p;
}

/* Extinction a mm. */
float extinction(Piece p, float v)
{
    precise float sigma = p.head.z + p.head.w * (v - p.head.x);
    return max(sigma, 0.0);
}

vec3 emission(Piece p, float v)
{
    vec3 rgb = texelFetch(pieces, 3 * p.index + 1).rgb;
    return clamp(rgb + texelFetch(pieces, 3 * p.index + 2).rgb * (v - p.head.x), 0.0, 1.0);
}
