/* A pixel's ray: found in double precision as libbrick's brick_view_ray and brick_ray_span find it, and cut to level 0's
 * box, to what the clip planes keep, and to what is before a mesh. It is divided into pieces of one step from where it
 * enters the box, interleaved rays from a part of a step before, and those are cut: so where planes move, samples stay.
 * Each piece has its sample in its middle; only the first, at a clip plane or interleaved, and the last are shorter. With PREINTEGRATED and for an isosurface samples are where pieces begin and
 * end, one more than there are pieces: so what is just before the eye, a clip plane or a mesh is not missed. */
#if defined PREINTEGRATED || MODE == MODE_ISO
#define AT_ENDS
#define FIRST_PIECE 1u /* the sample that the first piece belongs to */
#else
#define FIRST_PIECE 0u
#endif
uniform dvec3 origin, origin_u, origin_v, dir, dir_u, dir_v; /* struct brick_view */
uniform dmat3 linear;
uniform dvec3 box_high;                 /* level 0's dims - 1/2 */
uniform dvec3 level_scale, level_offset; /* index0 = scale * index + offset */
uniform double step_mm;
uniform ivec2 tile_origin; /* picture's pixel at the target's corner */
#if CLIP_PLANES > 0
uniform dvec4 clip_planes[CLIP_PLANES]; /* vr_scene_clip_plane */
#endif
#if CLIP_PLANES > 0 || defined INTERLEAVED
#define CUT /* the first piece may be shorter */
#endif
#ifdef MESHES
uniform usampler2D mesh_way; /* t of the nearest mesh: a double's bits */
#endif

#ifdef BOUNDS
uniform sampler2D bounds_first, bounds_last; /* where the bounding geometry begins and ends (methods/bounds.h) */
uniform double bounds_ahead;                 /* of depth 1, in units of the view's dir */
#endif

struct Ray {
    Fixed3 first, step, last; /* positions of the first and the last sample, in the level's index space */
    Near3 stride;             /* step */
    uint count;               /* samples */
    uint begin, end;          /* those before begin and from end on need not be looked at */
    float length_mm, last_length_mm; /* of a piece */
#ifdef CUT
    Fixed3 cut; /* where the first sample is; `first` is where the others count from */
    float cut_length_mm;
#endif
    vec3 pace, never; /* steps a voxel on each axis; where the ray does not move along an axis 0 and a huge number */
    bvec3 forward;
    vec3 view; /* world direction, unit */
};

#ifdef INTERLEAVED
/* In steps, [0,1): the ordered 4 x 4 pattern, in which neighbours are far apart (Scharsach 2005, section 5). */
float offset_of(ivec2 pixel)
{
    int a = pixel.x ^ pixel.y, b = pixel.y;
    return float((a & 1) << 3 | (b & 1) << 2 | (a & 2) | (b & 2) >> 1) / 16.0;
}
#endif

/* Sums are written out: dot() leaves their order open, and on other machines rays would lie elsewhere in the last bit. */
double sum_of(dvec3 a, dvec3 b)
{
    precise double sum = a.x * b.x + a.y * b.y;
    precise double all = sum + a.z * b.z;
    return all;
}

double sum_of(double first, dvec3 a, dvec3 b)
{
    precise double sum = first + a.x * b.x;
    precise double more = sum + a.y * b.y;
    precise double all = more + a.z * b.z;
    return all;
}

dvec3 to_world(dvec3 d)
{
    dmat3 rows = transpose(linear);
    return dvec3(sum_of(rows[0], d), sum_of(rows[1], d), sum_of(rows[2], d));
}

bool ray_init(ivec2 pixel, out Ray ray)
{
    double u = double(pixel.x) + 0.5LF, v = double(pixel.y) + 0.5LF;
    precise dvec3 o = origin + u * origin_u + v * origin_v;
    precise dvec3 d = dir + u * dir_u + v * dir_v;
    dvec3 world = to_world(d);
    double norm = sqrt(sum_of(world, world));
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
    double from = enter;
#if CLIP_PLANES > 0
    for (int i = 0; i < CLIP_PLANES; i++) {
        double inside = sum_of(clip_planes[i].w, clip_planes[i].xyz, o), slope = sum_of(clip_planes[i].xyz, d);
        if (slope > 0.0LF)
            from = max(from, -inside / slope);
        else if (slope < 0.0LF)
            leave = min(leave, -inside / slope);
        else if (inside < 0.0LF)
            hit = false;
    }
#endif
#ifdef MESHES
    leave = min(leave, packDouble2x32(texelFetch(mesh_way, pixel - tile_origin, 0).rg));
#endif
    double grid = enter; /* where the division counts from */
#ifdef INTERLEAVED
    grid -= double(offset_of(pixel)) * step_mm;
#endif
    double begin = (from - grid) / step_mm, steps = (leave - grid) / step_mm, skipped = floor(begin);
    double pieces = ceil(steps) - skipped;
    if (!hit || !(steps > begin) || !(pieces > 0.0LF))
        return false;

    /* In steps of the division: the first sample of a ray that is not cut, of one that is, and the last. */
    double whole = skipped + pieces - 1.0LF, rest = steps - max(whole, begin), piece = skipped + 1.0LF - begin;
#ifdef AT_ENDS
    double first = 0.0LF, cut = begin, last = steps;
    ray.count = uint(pieces) + 1u;
#else
    double first = 0.5LF, cut = begin + 0.5LF * piece, last = steps - 0.5LF * rest;
    ray.count = uint(pieces);
#endif
    dvec3 start = (o + grid * d - level_offset) / level_scale;
    dvec3 step = d * step_mm / level_scale;
#ifdef BOUNDS
    /* A piece more on either side, for rounding, and for the isosurface, which needs to know the side of the sample before
     * and after, as pre-integrated pieces need the value. */
    double near = double(texelFetch(bounds_first, pixel - tile_origin, 0).r) * bounds_ahead * norm;
    double far = double(texelFetch(bounds_last, pixel - tile_origin, 0).r) * bounds_ahead * norm;
    near = floor((near * (1.0LF - 1.0e-6LF) - grid) / step_mm) - skipped - 1.0LF;
    far = floor((far * (1.0LF + 1.0e-6LF) - grid) / step_mm) - skipped + 2.0LF;
    ray.begin = uint(clamp(near, 0.0LF, double(ray.count)));
    ray.end = uint(clamp(far, 0.0LF, double(ray.count)));
#else
    ray.begin = 0u;
    ray.end = ray.count;
#endif
    ray.step = fixed_from(step);
    ray.stride = near_from(ray.step, ivec3(0));
    ray.first = fixed_from(start + first * step);
    ray.last = fixed_from(start + last * step);
#ifdef CUT
    ray.first = fixed_add(ray.first, fixed_times(ray.step, uint(skipped)));
    ray.cut = fixed_from(start + cut * step);
    ray.cut_length_mm = float(piece * step_mm);
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
    ray.view = vec3(to_world(d));
    return true;
}

Fixed3 ray_sample(Ray ray, uint k)
{
    if (k + 1u == ray.count)
        return ray.last;
#ifdef CUT
    if (k == 0u)
        return ray.cut;
#endif
    return fixed_add(ray.first, fixed_times(ray.step, k));
}

/* Of sample k's piece, or with samples at ends of the piece that ends with it. */
float ray_length(Ray ray, uint k)
{
    if (k + 1u == ray.count)
        return ray.last_length_mm;
#ifdef CUT
    if (k == FIRST_PIECE)
        return ray.cut_length_mm;
#endif
    return ray.length_mm;
}

#ifdef DISTANCES
/* t of the point on the pixel's ray. */
double ray_distance_mm(ivec2 pixel, Fixed3 at)
{
    double u = double(pixel.x) + 0.5LF, v = double(pixel.y) + 0.5LF;
    dvec3 d = dir + u * dir_u + v * dir_v, world = linear * d;
    dvec3 way = level_scale * fixed_to(at) + level_offset - (origin + u * origin_u + v * origin_v);
    return dot(way, d) / dot(d, d) * sqrt(dot(world, world));
}
#endif
