/* Pre-integrated classification: emission and absorption of a piece of a ray along which the field goes linearly from one
 * value to another, through all of the transfer function that lies between them (the idea is Engel, Kraus and Ertl 2001;
 * here there is no table over pairs of values and so none of its resolution in the value, in the length or for peaks).
 *
 * Optical depth is exact but for rounding: in the piece of the function that an end lies in extinction is linear, and
 * whole pieces between are a difference of prefix integrals (frame/prefixes.h). All terms are of one sign.
 *
 * Colour is weighted by exp(-t) over the optical depth t in [0, D]. What is known of it exactly are its mean and its first
 * moment over t, by the same prefix integrals; the colour linear in t that has these two stands for it. What that
 * leaves out is at most (the range of the colour in the piece) x (half the integral of |r|), r being what exp(-t) differs by
 * from its best linear fit in the mean square; that is at most D^3 exp(-D/2) / 56 up to D = 2, 1.6e-5 for D = 0.1, and
 * nothing where the colour is constant.
 *
 * Where the ends' values are equal or lie in one piece these are the formulas of that piece, without a limit to take. */
#ifdef PREINTEGRATED
uniform usamplerBuffer prefixes;

/* An end of a piece of a ray: the value and where it lies in the transfer function. */
struct End {
    float value;
    Piece piece;
    vec4 rgb, rgb_slope; /* rgb.w: where the next piece starts */
};

End end_of(float value)
{
    Piece p = find_piece(value);
    return End(value, p, texelFetch(pieces, 3 * p.index + 1), texelFetch(pieces, 3 * p.index + 2));
}

/* A stretch of optical depth: how much, and the integrals of colour and of colour times depth from the middle. */
struct Stretch {
    float depth;
    vec3 colour, moment;
};

/* Over a length in mm with extinction and colour going linearly from one to the other; see frame/prefixes.c. */
Stretch stretch(float length_mm, float s0, float s1, vec3 c0, vec3 c1)
{
    precise float m = 0.5 * (s0 + s1), h = 0.5 * (s1 - s0), depth = length_mm * m;
    float h_depth = length_mm * h;
    vec3 colour = (length_mm / 6.0) * (c0 * (2.0 * s0 + s1) + c1 * (s0 + 2.0 * s1));
    return Stretch(depth, colour, (c1 - c0) * (depth * depth / 12.0 - h_depth * h_depth / 60.0));
}

Stretch stretch_join(Stretch a, Stretch b)
{
    return Stretch(a.depth + b.depth, a.colour + b.colour,
                   a.moment + b.moment + 0.5 * (b.colour * a.depth - a.colour * b.depth));
}

/* Whole pieces, from where piece `first` starts to where `last` does. mm_a_value: of the way. */
Stretch stretch_between(int first, int last, double mm_a_value)
{
    uvec4 a[4], b[4];
    for (int i = 0; i < 4; i++) {
        a[i] = texelFetch(prefixes, 4 * first + i);
        b[i] = texelFetch(prefixes, 4 * last + i);
    }
    double s0 = packDouble2x32(a[0].xy), s1 = packDouble2x32(b[0].xy);
    dvec3 colour0 = dvec3(packDouble2x32(a[0].zw), packDouble2x32(a[1].xy), packDouble2x32(a[1].zw));
    dvec3 colour1 = dvec3(packDouble2x32(b[0].zw), packDouble2x32(b[1].xy), packDouble2x32(b[1].zw));
    dvec3 moment0 = dvec3(packDouble2x32(a[2].xy), packDouble2x32(a[2].zw), packDouble2x32(a[3].xy));
    dvec3 moment1 = dvec3(packDouble2x32(b[2].xy), packDouble2x32(b[2].zw), packDouble2x32(b[3].xy));
    dvec3 colour = colour1 - colour0;
    dvec3 moment = (moment1 - moment0) - (0.5LF * (s0 + s1)) * colour;
    return Stretch(float(mm_a_value * (s1 - s0)), vec3(mm_a_value * colour),
                   vec3(mm_a_value * mm_a_value * moment));
}

/* Along a length from front to back. */
Stretch stretch_of(End front, End back, float length_mm)
{
    bool up = back.value > front.value;
    float width = abs(back.value - front.value);
    bool one_piece = front.piece.index == back.piece.index || !(width > 1.0e-36);
    /* Where the way leaves the front's piece, and where it enters the back's. */
    float leave = one_piece ? back.value : up ? front.rgb.w : front.piece.head.x;
    float enter = one_piece ? back.value : up ? back.piece.head.x : back.rgb.w;
    float mm_a_value = length_mm / width;
    Stretch s = stretch(one_piece ? length_mm : mm_a_value * abs(leave - front.value),
                        extinction(front.piece, front.value),
                        one_piece ? extinction(back.piece, leave) : extinction(front.piece, leave),
                        emission(front.piece, front.rgb.rgb, front.rgb_slope.rgb, front.value),
                        one_piece ? emission(back.piece, back.rgb.rgb, back.rgb_slope.rgb, leave)
                                  : emission(front.piece, front.rgb.rgb, front.rgb_slope.rgb, leave));
    if (!one_piece) {
        Stretch whole = stretch_between(min(front.piece.index, back.piece.index) + 1,
                                        max(front.piece.index, back.piece.index),
                                        double(length_mm) / double(width));
        if (!up)
            whole.moment = -whole.moment;
        s = stretch_join(s, whole);
        s = stretch_join(s, stretch(mm_a_value * abs(back.value - enter), extinction(back.piece, enter),
                                    extinction(back.piece, back.value),
                                    emission(back.piece, back.rgb.rgb, back.rgb_slope.rgb, enter),
                                    emission(back.piece, back.rgb.rgb, back.rgb_slope.rgb, back.value)));
    }
    return s;
}

/* The colour that a stretch shows, per opacity(depth); depth > 0. The linear colour's part that changes is weighted by
 *
 *     -12 / D^3 x integral of (t - D/2) exp(-t) = 12 (y (1 + e) - (1 - e)) / D^3,   y = D/2, e = exp(-D)
 *                                               = exp(-y) (1 + y^2/10 + y^4/280 + y^6/15120 + ...). */
vec3 stretch_colour(Stretch s, float alpha)
{
    float y = 0.5 * s.depth, z = y * y, e = exponential(-y), weight;
    if (y < 1.0)
        weight = e * (1.0 + z * (1.0 / 10.0 + z * (1.0 / 280.0 + z * (1.0 / 15120.0 + z * (1.0 / 1330560.0)))));
    else
        weight = 1.5 * (y * (1.0 + e * e) - alpha) / (z * y);
    return clamp(s.colour / s.depth - s.moment * (weight / alpha), 0.0, 1.0);
}
#endif
