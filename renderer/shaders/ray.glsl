/* A pixel's ray: found in double precision as libbrick's brick_view_ray and brick_ray_span find it, cut to level 0's box,
 * and divided into pieces of one step from where it enters; each piece has its sample in its middle. Only the last
 * piece is shorter. With PREINTEGRATED samples are where pieces begin and end, one more than there are pieces. */
uniform dvec3 origin, origin_u, origin_v, dir, dir_u, dir_v; /* struct brick_view */
uniform dmat3 linear;
uniform dvec3 box_high;                 /* level 0's dims - 1/2 */
uniform dvec3 level_scale, level_offset; /* index0 = scale * index + offset */
uniform double step_mm;
uniform ivec2 tile_origin; /* picture's pixel at the target's corner */

struct Ray {
    Fixed3 first, step, last; /* positions of the first and the last sample, in the level's index space */
    uint count;               /* samples */
    float length_mm, last_length_mm; /* of a piece */
    vec3 pace, never; /* steps a voxel on each axis; where the ray does not move along an axis 0 and a huge number */
    bvec3 forward;
    vec3 view; /* world direction, unit */
};

bool ray_init(ivec2 pixel, out Ray ray)
{
    double u = double(pixel.x) + 0.5LF, v = double(pixel.y) + 0.5LF;
    dvec3 o = origin + u * origin_u + v * origin_v;
    dvec3 d = dir + u * dir_u + v * dir_v;
    dvec3 world = linear * d;
    double norm = sqrt(dot(world, world));
    d /= norm;
    double enter = 0.0LF, leave = 1.0e300LF;
    bool hit = true;
    for (int i = 0; i < 3; i++) {
        if (d[i] == 0.0LF) {
            if (o[i] < -0.5LF || o[i] > box_high[i])
                hit = false;
        } else {
            double a = (-0.5LF - o[i]) / d[i], b = (box_high[i] - o[i]) / d[i];
            enter = max(enter, min(a, b));
            leave = min(leave, max(a, b));
        }
    }
    double steps = (leave - enter) / step_mm;
    if (!hit || !(steps > 0.0LF))
        return false;

    double pieces = ceil(steps), rest = steps - (pieces - 1.0LF);
    dvec3 start = (o + enter * d - level_offset) / level_scale;
    dvec3 step = d * step_mm / level_scale;
    ray.step = fixed_from(step);
#ifdef PREINTEGRATED
    ray.count = uint(pieces) + 1u;
    ray.first = fixed_from(start);
    ray.last = fixed_from(start + steps * step);
#else
    ray.count = uint(pieces);
    ray.last = fixed_from(start + (pieces - 1.0LF + 0.5LF * rest) * step);
    ray.first = fixed_from(start + 0.5LF * step);
    if (ray.count == 1u)
        ray.first = ray.last;
#endif
    ray.length_mm = float(step_mm);
    ray.last_length_mm = float(rest * step_mm);
    vec3 stride = vec3(step);
    for (int i = 0; i < 3; i++) {
        bool moves = abs(stride[i]) > 1.0e-30;
        ray.pace[i] = moves ? 1.0 / abs(stride[i]) : 0.0;
        ray.never[i] = moves ? 0.0 : 1.0e30;
    }
    ray.forward = greaterThan(stride, vec3(0.0));
    ray.view = vec3(world / norm);
    return true;
}

Fixed3 ray_sample(Ray ray, uint k)
{
    if (k + 1u == ray.count)
        return ray.last;
    return fixed_add(ray.first, fixed_times(ray.step, k));
}
