/* Pre-integrated slices: a slab is the piece of a ray that lies in a slice, from one of its planes to the next. Both ends'
 * values come from one brick, and one box draws it, as follows.
 *
 * A slab in one brick belongs to the active macrocell that its back lies in, or else its front. Where both macrocells are
 * inactive it is transparent (shaders/segments.glsl says why), and nobody draws it.
 *
 * A slab that leads from brick to brick belongs to the one at its back, or to the one in front where nothing in that at
 * the back is visible; where it is lit, to the one that its middle lies in, for only that one has the voxels of the gradient
 * there (vr_residency_touching brings it even if nothing in it is visible). There it is drawn by the box of the active
 * macrocell that the middle or else an end lies in, or else, from where the end or the middle is, by the brick's rim: what is
 * beyond may show, but its macrocells may not be there to ask.
 *
 * Along a ray the owners' bricks come in the order of depth, so slabs are blended in the order in which they lie. */
#ifdef PREINTEGRATED
/* Sides of the box's brick beyond which a voxel lies, a bit each: low x, high x, low y, ... */
int beyond(ivec3 voxel)
{
    ivec3 away = (voxel >> brick_shift) - (low >> brick_shift);
    ivec3 sides = ivec3(lessThan(away, ivec3(0))) + 2 * ivec3(greaterThan(away, ivec3(0)));
    return sides.x | sides.y << 2 | sides.z << 4;
}

/* Of several sides that the slab leads through and that have a rim it belongs to the first. */
bool on_rim(ivec3 at, ivec3 start, ivec3 end)
{
    int sides = (beyond(start) | beyond(end)) & rim;
    return rim != 0 && in_box(at) && (sides & -sides) == rim >> 6;
}

bool owns(Place front, Place middle, Place back)
{
    ivec3 start = owner(front.cell), end = owner(back.cell);
    Block before = locate(start), behind = locate(end);
    if (before.brick == behind.brick)
        return rim == 0 && (behind.live ? in_box(end) : before.live && in_box(start));
#if MODE == MODE_SHADED
    ivec3 centre = owner(middle.cell);
    Block between = locate(centre);
    bool front_shows = before.brick == between.brick && before.live;
    bool back_shows = behind.brick == between.brick && behind.live;
    if (between.live || front_shows || back_shows)
        return rim == 0 && in_box(between.live ? centre : back_shows ? end : start);
    return on_rim(centre, start, end);
#else
    ivec3 at = behind.wanted ? end : start;
    return (behind.wanted ? behind.live : before.live) ? rim == 0 && in_box(at) : on_rim(at, start, end);
#endif
}

/* view: world direction, unit. */
vec4 slab(Place front, Place middle, Place back, float length_mm, vec3 view)
{
    Cell c;
    float v0, v1;
    if (!value_at(front, c, v0) || !value_at(back, c, v1))
        return vec4(0.0);
    Stretch part = stretch_of(end_of(v0), end_of(v1), length_mm);
    if (!(part.depth > 0.0))
        return vec4(0.0);
    float alpha = opacity(part.depth);
    vec3 rgb = stretch_colour(part, alpha);
#if MODE == MODE_SHADED
#ifndef POINT
    c = cell_fetch(middle.cell + offset);
#endif
    rgb = shade(rgb, gradient_at(middle, c), view);
#endif
    return vec4(rgb * alpha, alpha);
}
#endif
