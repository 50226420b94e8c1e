/* A pixel's ray through one cell: where it enters and leaves, in double precision from the ray itself, and there through the
 * tetrahedra it meets, three at most: the middle one shares a face with each of the four at corners, which share none.
 *
 * The field in closed form: L, linear, in the middle tetrahedron and beyond it, plus for each corner its rise over L there
 * times h, which is 1 at the corner and 0 on its face to the middle one, where h is above 0. */
flat in ivec3 cell, texel;
out vec4 colour;
uniform dvec3 eye, ahead, right, down;    /* the ray of (column, row) goes from the eye along ahead + column right + row down */
uniform vec3 ahead_mm, right_mm, down_mm; /* the same in the world */
uniform ivec2 part;                       /* pixel at the viewport's corner */
#ifdef CUTS
uniform dvec4 cuts[CUTS]; /* what has dot(cut, (p, 1)) >= 0 stays */
#endif

/* Heights h over the faces of the middle tetrahedron, of corners 1, 2, 4 and 7 of an even cell. */
vec4 heights(vec3 p)
{
    return vec4(p.x - p.y - p.z, p.y - p.x - p.z, p.z - p.x - p.y, p.x + p.y + p.z - 2.0);
}

void main()
{
    colour = vec4(0.0);
    vec2 pixel = gl_FragCoord.xy + vec2(part);
    dvec3 d = ahead + double(pixel.x) * right + double(pixel.y) * down;
    dvec3 low = max(dvec3(cell), dvec3(-0.5LF)) - eye, high = min(dvec3(cell + 1), dvec3(level_last) + 0.5LF) - eye;
    double enter = 0.0LF, leave = 1.0e300LF;
    for (int i = 0; i < 3; i++) {
        /* A ray along a face is in the cell above it only. */
        double pace = 1.0LF / (d[i] == 0.0LF ? 1.0e-290LF : d[i]), a = low[i] * pace, b = high[i] * pace;
        enter = max(enter, min(a, b));
        leave = min(leave, max(a, b));
    }
#ifdef CUTS
    for (int i = 0; i < CUTS; i++) {
        double inside = dot(cuts[i].xyz, eye) + cuts[i].w, slope = dot(cuts[i].xyz, d), at = -inside / slope;
        enter = slope > 0.0LF ? max(enter, at) : enter;
        leave = slope < 0.0LF ? min(leave, at) : leave;
        leave = slope == 0.0LF && inside < 0.0LF ? 0.0LF : leave;
    }
#endif
    if (!(leave > enter))
        return;
    float way = float(leave - enter) * length(ahead_mm + pixel.x * right_mm + pixel.y * down_mm);

    /* Beyond the outermost voxels the field is what it is at these. */
    vec3 first = vec3(max(-cell, 0)), last = vec3(min(level_last - cell, 1));
    dvec3 start = eye - dvec3(cell);
    vec3 p0 = clamp(vec3(start + enter * d), first, last), p1 = clamp(vec3(start + leave * d), first, last);
    Cell c = cell_fetch(texel);
    vec4 c0 = c.low * value_sign, c1 = c.high * value_sign;
    if (((cell.x ^ cell.y ^ cell.z) & 1) != 0) { /* a mirrored even one */
        p0.x = 1.0 - p0.x;
        p1.x = 1.0 - p1.x;
        c0 = c0.yxwz;
        c1 = c1.yxwz;
    }
    vec4 middle = vec4(c1.z, c1.y, c0.w, c0.x); /* corners 6, 5, 3 and 0: each across from one of the others */
    vec4 corner = vec4(c0.y, c0.z, c1.x, c1.w);
    vec3 slope = 0.5 * (vec3(middle.y, middle.x, middle.x) + vec3(middle.z, middle.z, middle.y) - middle.xyz - middle.w);
    vec4 rise = corner - (middle.w + vec4(slope, slope.x + slope.y + slope.z));
    vec4 h0 = heights(p0), h1 = heights(p1);
    float f0 = middle.w + dot(slope, p0), f1 = middle.w + dot(slope, p1);

    /* The middle tetrahedron begins at `from` and ends at `to`, parts of the way. */
    float from = 0.0, to = 1.0;
    for (int i = 0; i < 4; i++) {
        from = h0[i] > 0.0 ? (h1[i] < 0.0 ? h0[i] / (h0[i] - h1[i]) : 1.0) : from;
        to = h1[i] > 0.0 && h0[i] < 0.0 ? h0[i] / (h0[i] - h1[i]) : to;
    }
    to = max(from, to);
    float a = 0.0, fa = f0 + dot(rise, max(h0, 0.0));
    vec4 ha = h0;
    int end = from < 1.0 ? to < 1.0 ? 3 : 2 : 1;
    for (int i = from > 0.0 ? 0 : 1; i < end; i++) {
        float b = i == 0 ? from : i == 1 ? to : 1.0;
        vec4 hb = mix(h0, h1, b), vertex = mix(middle, corner, greaterThan(ha + hb, vec4(0.0)));
        float fb = mix(f0, f1, b) + dot(rise, max(hb, 0.0));
        float least = min(min(vertex.x, vertex.y), min(vertex.z, vertex.w));
        float most = max(max(vertex.x, vertex.y), max(vertex.z, vertex.w));
        colour += (1.0 - colour.a) * integrate(clamp(fa, least, most), clamp(fb, least, most), (b - a) * way);
        a = b;
        fa = fb;
        ha = hb;
    }
}
