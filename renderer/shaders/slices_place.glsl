/* Points on a pixel's ray, the box that draws, and the field at a point, from the box's brick. */
flat in ivec3 low, high, offset; /* texel = voxel + offset */
flat in int plane, rim; /* rim: slices_slab.glsl */

struct Place {
    ivec3 cell;
    vec3 f;
};

/* At a depth in slices, in double precision: it knows neither bricks nor boxes. To 2^-32: a ray that lies in a face of bricks
 * stays on one side of it, whatever is rounded on the way, so that no sample of it comes out of the order in which bricks are
 * drawn. */
Place place_at(dvec2 uv, double slice)
{
    precise double depth = first_depth + slice * spacing;
    precise dvec3 p = ray_origin(uv) + depth * ray_direction(uv);
    precise dvec3 fine = floor(p * 4294967296.0LF + 0.5LF), whole = floor(fine / 4294967296.0LF);
    return Place(ivec3(whole), vec3((fine - whole * 4294967296.0LF) / 4294967296.0LF));
}

bool in_box(ivec3 voxel)
{
    return all(greaterThanEqual(voxel, low)) && all(lessThan(voxel, high));
}

/* False where there is no value: a corner of the cell is not finite. */
bool value_at(Place p, out Cell c, out float v)
{
    ivec3 texel = p.cell + offset;
    bool valid = true;
#if !defined(POINT) || defined(NONFINITE)
    c = cell_fetch(texel);
    valid = cell_valid(c);
#endif
#ifdef POINT
    v = voxel(texel + ivec3(greaterThanEqual(p.f, vec3(0.5)))) * value_sign;
#else
    v = cell_value(c, p.f);
#endif
    return valid;
}

#if MODE == MODE_SHADED
vec3 gradient_at(Place p, Cell c)
{
    ivec3 texel = p.cell + offset;
#ifdef POINT
    const ivec2 e = ivec2(1, 0);
    ivec3 t = texel + ivec3(greaterThanEqual(p.f, vec3(0.5)));
    vec3 g = vec3(voxel(t + e.xyy) - voxel(t - e.xyy), voxel(t + e.yxy) - voxel(t - e.yxy),
                  voxel(t + e.yyx) - voxel(t - e.yyx));
#ifdef NONFINITE
    for (int i = 0; i < 3; i++)
        if ((floatBitsToUint(g[i]) & 0x7f800000u) == 0x7f800000u)
            g[i] = 0.0;
#endif
    return 0.5 * g;
#else
    return cell_gradient(c, texel, p.f);
#endif
}
#endif
