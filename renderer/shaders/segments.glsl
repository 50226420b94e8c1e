/* Pre-integrated classification, brick by brick: which pieces of a ray count, and which brick supplies the values at both ends
 * of one, and the gradient in its middle. Ends move by a voxel at most along each axis, so the cells of both are the same
 * or touch.
 *
 * A piece whose ends lie in inactive blocks is transparent, whatever it passes. The cells of its ends share a voxel; its value is
 * within the hulls of both cells' corners, so together these hulls are one interval, which holds the values at both ends and
 * all between. A block is inactive only if nothing in the hull of any cell of it is visible. So the optical depth between the
 * two values is exactly 0, and leaving the piece out changes no bit. (An end in a cell with a corner that is not finite has
 * no value, and its pieces are transparent.)
 *
 * One brick supplies all of a piece, so a ray never waits for two at once, which a small cache might never hold together. It is
 * that of the piece's middle where a gradient is wanted, else that of its back, or of its front where nothing in the brick at
 * the back is visible: what lies outside is in the brick's border, less than two voxels away. Where nothing in the
 * middle's brick is visible it is not loaded, the values come from an end's brick, and only if something shows between them
 * does the ray ask for the middle's.
 *
 * Whether a piece from brick to brick counts depends on bricks alone, not on macrocells, which are only known of bricks that
 * are in the atlas. So the picture does not depend on what is, nor on where passes end, even where a lossy codec makes
 * borders differ from the next brick's core. */
#ifdef PREINTEGRATED
/* Between samples k - 1 and k, which is at `at`. */
Fixed3 ray_middle(Ray ray, uint k, Fixed3 at)
{
    Fixed3 before = ray_sample(ray, k - 1u);
    return fixed_add(before, fixed_half(fixed_subtract(at, before)));
}

/* What supplies the piece between samples k - 1 and k: live, missing, or neither when the piece is transparent. back, front: the
 * surroundings of samples k and k - 1. alone: the next piece may be another's. */
Block supplier(Ray ray, uint k, Fixed3 at, Block back, Block front, out bool alone)
{
    alone = false;
    back.lacks = -1;
    if (k == 0u)
        return back;
    if (front.brick == back.brick) {
        alone = !back.live;
        back.live = back.live || front.live;
        return back;
    }
    if (!front.wanted && !back.wanted)
        return back;
    Block block = back;
    if (!back.wanted)
        block = front;
#if MODE == MODE_SHADED
    Block middle = locate(owner(ray_middle(ray, k, at).cell));
    if (middle.wanted)
        block = middle;
    block.lacks = middle.wanted ? -1 : middle.brick;
#else
    block.lacks = -1;
#endif
    alone = !(block.brick == back.brick && back.live && block.lacks < 0);
    block.live = !block.missing;
    return block;
}
#endif
