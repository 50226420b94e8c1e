/* A corner of a cell's box, a little larger than the cell: methods/cells/boxes.c. */
uniform int first_cell;
uniform ivec3 brick_first; /* the brick's first voxel */
uniform ivec3 brick_texel; /* where it is in the atlas */
uniform dvec3 eye;         /* in the level's index space */
uniform dvec3 to_x, to_y, to_depth; /* from there: the depth, and what times the depth is in the viewport's [-1,1] */
uniform vec3 wider; /* by so many voxels on a side, at a depth of 1 */

flat out ivec3 cell;  /* voxel at the cell's lower corner */
flat out ivec3 texel; /* where it is in the atlas */

void main()
{
    ivec3 at = cell_place(texelFetch(cells, first_cell + (gl_VertexID >> 3)).r);
    cell = at + brick_first;
    texel = at + brick_texel;
    dvec3 low = max(dvec3(cell), dvec3(-0.5LF)) - eye, high = min(dvec3(cell + 1), dvec3(level_last) + 0.5LF) - eye;
    dvec3 far = dvec3(greaterThan(to_depth, dvec3(0.0LF)));
    dvec3 more = dvec3(wider * float(max(dot(to_depth, mix(low, high, far)), 0.0LF)));
    dvec3 p = mix(low - more, high + more, dvec3(gl_VertexID & 1, gl_VertexID >> 1 & 1, gl_VertexID >> 2 & 1));
    /* Depth 0 of clip space is between any near and far plane: all ahead of the eye stays. */
    gl_Position = vec4(float(dot(to_x, p)), float(dot(to_y, p)), 0.0, float(dot(to_depth, p)));
}
