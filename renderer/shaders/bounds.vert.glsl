/* A row of blocks (methods/blocks.h), larger by a margin, as boxes' faces of two triangles: those that are seen from outside, 3 a
 * row, or those that are seen from inside, 6 a row of which some are none. Row 0 is on top of the picture. */
uniform usamplerBuffer rows;
uniform dvec3 origin, dir, level_scale, level_offset, margin; /* margin in voxels of level 0 */
uniform dmat3 to_picture;                                     /* scene/projection.h */
uniform double cell, nearest_ahead;
uniform bool parallel, front;
uniform ivec2 tile_origin, layer_size;
flat out float plane;
flat out int axis;

/* Of a block's low or high side; the outermost blocks reach over the volume's rim. */
dvec3 corner_of(uvec3 cells, bvec3 high)
{
    dvec3 level = dvec3(cells) * cell;
    for (int a = 0; a < 3; a++) {
        if (!high[a] && cells[a] == 0u)
            level[a] = -1.0LF;
        level[a] = level_scale[a] * level[a] + level_offset[a] + (high[a] ? margin[a] : -margin[a]);
    }
    return level;
}

void main()
{
    int faces = front ? 3 : 6, face = gl_VertexID / 6 % faces, corner = gl_VertexID % 6;
    uvec4 row = texelFetch(rows, gl_VertexID / (6 * faces));
    dvec3 low = corner_of(row.xzw, bvec3(false)), high = corner_of(uvec3(row.y, row.zw + 1u), bvec3(true));
    axis = face % 3;
    bool before = parallel ? dir[axis] > 0.0LF : origin[axis] < low[axis];
    bool behind = parallel ? dir[axis] < 0.0LF : origin[axis] > high[axis];
    bool up = front ? behind : face >= 3;
    bool seen = front ? before || behind : !(up ? behind : before);

    corner = corner > 2 ? 6 - corner : corner; /* 0 1 2, 3 2 1 */
    int along = (axis + 1) % 3, across = (axis + 2) % 3;
    dvec3 at;
    at[axis] = up ? high[axis] : low[axis];
    at[along] = (corner & 1) != 0 ? high[along] : low[along];
    at[across] = (corner & 2) != 0 ? high[across] : low[across];
    plane = float(at[axis]);
    dvec3 q = to_picture * (at - origin);
    double w = parallel ? 1.0LF : q.z;
    dvec2 xy = (q.xy - w * dvec2(tile_origin)) * (2.0LF / dvec2(layer_size)) - w;
    gl_Position = vec4(vec2(xy), parallel ? 0.0 : float(w - 2.0LF * nearest_ahead), float(w));
    if (!seen)
        gl_Position = vec4(0.0, 0.0, 2.0, 1.0); /* nowhere */
}
