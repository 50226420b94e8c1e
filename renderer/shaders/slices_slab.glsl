/* Pre-integrated slices: a slab is the piece of a ray that lies in a slice, from one of its planes to the next. Both ends'
 * values come from one brick, and one box draws it, as follows.
 *
 * A slab in one brick belongs to the active macrocell that its back lies in, or else its front. Where both macrocells are
 * inactive it is transparent (shaders/segments.glsl says why), and nobody draws it.
 *
 * A slab that leads from brick to brick belongs to the one at its back, or to the one in front where nothing in that at
 * the back is visible; where it is lit, to the one that its middle lies in, for only that one has the voxels of the gradient
 * there (vr_residency_touching brings it even if nothing in it is visible). It is drawn by the box of the macrocell that the
 * end, or the middle, lies in, or, where that macrocell is inactive, by the brick's rim. So who draws it depends on bricks alone
 * and not on the macrocells of another brick, which may not be there.
 *
 * Along a ray the owners' bricks come in the order of depth, so slabs are blended in the order in which they lie. */
#ifdef PREINTEGRATED
bool owns(Place front, Place middle, Place back)
{
    ivec3 start = owner(front.cell), end = owner(back.cell), centre = owner(middle.cell);
    if (!in_box(start) && !in_box(end) && !in_box(centre))
        return false;
    Block before = locate(start), behind = locate(end);
    if (before.brick == behind.brick)
        return rim == 0 && (behind.live ? in_box(end) : before.live && in_box(start));
#if MODE == MODE_SHADED
    return in_box(centre) && locate(centre).live == (rim == 0);
#else
    return behind.wanted ? in_box(end) && behind.live == (rim == 0) : in_box(start) && before.live == (rim == 0);
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
