/* The stack of slices (methods/slices/stack.h). Depth is the distance in mm from the eye along the view's axis; slice k
 * lies between depths first + k * spacing and one spacing more. A pixel's point at a depth is origin + depth * direction,
 * in the level's index space; both are affine in the pixel, and one of them is constant. */
uniform dvec3 origin, origin_u, origin_v, dir, dir_u, dir_v;
uniform double first_depth, spacing;
uniform ivec2 part_origin; /* picture's pixel at the framebuffer's corner */

dvec2 pixel_centre(ivec2 pixel)
{
    return dvec2(pixel + part_origin) + 0.5LF;
}

dvec3 ray_origin(dvec2 uv)
{
#ifdef PERSPECTIVE
    return origin;
#else
    return origin + uv.x * origin_u + uv.y * origin_v;
#endif
}

dvec3 ray_direction(dvec2 uv)
{
#ifdef PERSPECTIVE
    return dir + uv.x * dir_u + uv.y * dir_v;
#else
    return dir;
#endif
}
