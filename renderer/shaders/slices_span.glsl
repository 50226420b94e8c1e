/* Where each pixel's ray enters and leaves what is drawn: level 0's box before the eye, and what clip planes keep. As the
 * numbers of the first and the last slice, the part of the first that lies before the entry, and the part of the last
 * before the exit (bits of floats). A ray that misses has its last slice before the first. */
uniform dvec3 box_low, box_high; /* level 0's box in the level's index space */
uniform dvec4 clip[CLIP_PLANES]; /* keep . (p, 1) >= 0, in the level's index space */
uniform int clip_count, slices;

layout(location = 0) out uvec4 span;

double enter, leave;

/* Keep the part of the ray where inside + depth * slope >= 0. */
void cut(double inside, double slope)
{
    if (slope > 0.0LF)
        enter = max(enter, -inside / slope);
    else if (slope < 0.0LF)
        leave = min(leave, -inside / slope);
    else if (inside < 0.0LF)
        leave = -1.0LF;
}

void main()
{
    dvec2 uv = pixel_centre(ivec2(gl_FragCoord.xy));
    dvec3 o = ray_origin(uv), d = ray_direction(uv);
    enter = 0.0LF;
    leave = 1.0e300LF;
    for (int a = 0; a < 3; a++) {
        cut(o[a] - box_low[a], d[a]);
        cut(box_high[a] - o[a], -d[a]);
    }
    for (int i = 0; i < clip_count; i++)
        cut(dot(clip[i].xyz, o) + clip[i].w, dot(clip[i].xyz, d));
    span = uvec4(1u, 0u, 0u, 0u);
    if (!(leave > enter))
        return;
    double from = max((enter - first_depth) / spacing, 0.0LF), to = (leave - first_depth) / spacing;
    double first = floor(from), last = min(ceil(to) - 1.0LF, double(slices - 1));
    span = uvec4(uint(int(first)), uint(int(last)), floatBitsToUint(float(from - first)),
                 floatBitsToUint(float(min(to - last, 1.0LF))));
}
