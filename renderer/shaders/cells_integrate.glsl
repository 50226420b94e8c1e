/* The colour of a ray's way through one tetrahedron, from the scalars at its ends and its length (Maximo et al. 2008,
 * sections 3 and 4.2.2). Premultiplied, to be blended over what lies behind. */
#if INTEGRATION == INTEGRATION_PSI
uniform samplerBuffer psi_table;
#define PSI_EDGE 512

float psi_at(int front, int back)
{
    return texelFetch(psi_table, back * PSI_EDGE + front).r;
}

float psi(float front, float back)
{
    vec2 x = min(vec2(front, back), 1.0e30);
    vec2 at = x / (1.0 + x) * float(PSI_EDGE - 1);
    vec2 low = min(floor(at), float(PSI_EDGE - 2)), t = at - low;
    ivec2 i = ivec2(low);
    return mix(mix(psi_at(i.x, i.y), psi_at(i.x + 1, i.y), t.x), mix(psi_at(i.x, i.y + 1), psi_at(i.x + 1, i.y + 1), t.x), t.y);
}
#endif

#if INTEGRATION == INTEGRATION_EXP
uniform samplerBuffer exp_table; /* exp(-i / EXP_STEPS), i to EXP_STEPS; then exp(-i) */
#define EXP_STEPS 256

/* exp(-x): the paper's table is over [0,1], and what it does beyond is not said; here whole numbers have a table as well. */
float table_exp(float x)
{
    float whole = min(floor(x), 87.0), at = min(x - whole, 1.0) * float(EXP_STEPS), low = min(floor(at), float(EXP_STEPS - 1));
    int i = int(low);
    float part = mix(texelFetch(exp_table, i).r, texelFetch(exp_table, i + 1).r, at - low);
    return part * texelFetch(exp_table, EXP_STEPS + 1 + int(whole)).r;
}
#endif

#if INTEGRATION == INTEGRATION_EXACT
uniform int piece_count;
#define DEEP 17.0 /* exp(-17) = 4e-8 */
#define THIN 0.125

/* 1 - psi: the integral over x in [0,1] of 1 - exp(-(front x + (back - front) x^2 / 2)). Gauss-Legendre quadrature: of two
 * points for what is thin, wrong by less than THIN^4 / 4320 = 6e-8; else of four on intervals of a depth of at most 2, right
 * to 2e-7 of its value. What is thin loses no digit. */
float one_minus_psi(float front, float back)
{
    const vec2 node2 = vec2(0.211324865, 0.788675135);
    const vec4 node = vec4(0.0694318442, 0.330009478, 0.669990522, 0.930568156);
    const vec4 weight = vec4(0.173927423, 0.326072577, 0.326072577, 0.173927423);
    float half_slope = 0.5 * (back - front), end = 1.0, sum = 0.0;
    if (max(front, back) < THIN) {
        vec2 q = node2 * (front + half_slope * node2);
        return 0.5 * (opacity(q.x) + opacity(q.y));
    }
    if (front + back > 2.0 * DEEP)
        end = 2.0 * DEEP / (front + sqrt(max(front * front + 4.0 * half_slope * DEEP, 0.0)));
    float intervals = 1.0 + floor(0.5 * end * max(front, front + 2.0 * half_slope * end)), h = end / intervals;
    for (float i = 0.0; i < intervals; i++)
        for (int k = 0; k < 4; k++) {
            float x = (i + node[k]) * h;
            sum += weight[k] * opacity(max(x * (front + half_slope * x), 0.0));
        }
    return sum * h + (1.0 - end);
}

/* Better than the paper: the way is cut where its scalar crosses a knot of the transfer function, and on each part, where
 * extinction and colour are linear, the integral is the partial pre-integration's. */
vec4 integrate(float front, float back, float way)
{
    bool up = back >= front;
    float scale = way / (back - front), from = front, done = 0.0, depth = 0.0, transmittance = 1.0;
    vec3 rgb = vec3(0.0);
    Piece piece = find_piece(front);
    for (;;) {
        int next = clamp(up ? piece.index + 1 : piece.index - 1, 0, piece_count - 1);
        vec4 head = texelFetch(pieces, 3 * next);
        float knot = up ? head.x : piece.head.x;
        bool last = next == piece.index || (up ? knot >= back : knot <= back);
        float to = last ? back : knot, end = last ? way : clamp((to - front) * scale, done, way);
        float x0 = extinction(piece, from) * (end - done), x1 = extinction(piece, to) * (end - done), x = 0.5 * (x0 + x1);
        if (x > 0.0) {
            vec3 base = texelFetch(pieces, 3 * piece.index + 1).rgb, slope = texelFetch(pieces, 3 * piece.index + 2).rgb;
            vec3 c0 = clamp(base + slope * (from - piece.head.w), 0.0, 1.0);
            vec3 c1 = clamp(base + slope * (to - piece.head.w), 0.0, 1.0);
            float a = opacity(x), share = c0 == c1 ? 0.0 : one_minus_psi(x0, x1);
            rgb += transmittance * (c0 * share + c1 * (a - share));
            depth += x;
            transmittance = exponential(-depth);
        }
        if (last || depth > 87.0)
            break;
        piece = Piece(next, head);
        from = to;
        done = end;
    }
    return vec4(rgb, opacity(depth));
}
#elif INTEGRATION == INTEGRATION_PREFIX
/* Better than the paper as well, and without a loop: preintegrated.glsl. */
vec4 integrate(float front, float back, float way)
{
    Stretch s = stretch_of(end_of(front), end_of(back), way);
    float a = opacity(s.depth);
    return s.depth > 0.0 ? vec4(a * stretch_colour(s, a), a) : vec4(0.0);
}
#elif INTEGRATION == INTEGRATION_SCALAR
vec4 integrate(float front, float back, float way)
{
    float scalar = front + 0.5 * (back - front);
    Piece piece = find_piece(scalar);
    float a = opacity(extinction(piece, scalar) * way);
    return vec4(a * emission(piece, scalar), a);
}
#else
vec4 integrate(float front, float back, float way)
{
    Piece f = find_piece(front), b = find_piece(back);
    float x0 = extinction(f, front) * way, x1 = extinction(b, back) * way, x = 0.5 * (x0 + x1);
    if (!(x > 0.0))
        return vec4(0.0);
    vec3 c0 = emission(f, front), c1 = emission(b, back);
#if INTEGRATION == INTEGRATION_PSI
    float a = opacity(x), mean = psi(x0, x1);
    return vec4(max(c0 * (1.0 - mean) + c1 * (mean - (1.0 - a)), 0.0), a);
#elif INTEGRATION == INTEGRATION_EXP
    float a = 1.0 - table_exp(x);
    return vec4(a * 0.5 * (c0 + c1), a);
#else
    float a = opacity(x);
    return vec4(a * 0.5 * (c0 + c1), a);
#endif
}
#endif
