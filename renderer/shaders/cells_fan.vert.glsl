/* A vertex of a tetrahedron's fan, found from the numbers of its cell, tetrahedron and vertex alone (Maximo et al. 2008,
 * section 4.2.1). A thin vertex mixes the scalars of four voxels with weights of 1 and 0; so all vertices go one way. Where
 * it is in the picture depends on the voxel's index only, in double precision: neighbours have the same vertex. */
uniform samplerBuffer basis;  /* basis.h */
uniform int first_cell;
uniform ivec3 brick_first; /* the brick's first voxel */
uniform ivec3 brick_texel; /* where it is in the atlas */
uniform dvec3 to_x, to_y;  /* the level's index space to the viewport's [-1,1] */
uniform dvec3 origin;      /* x, y, and depth of voxel (0,0,0) */
uniform double pixel_x, pixel_y; /* in units of [-1,1] */

noperspective out vec3 span; /* front and back scalar, length in mm */
#ifdef CUTS
uniform dvec3 to_depth;
noperspective out float entry; /* depth where the ray enters, in mm */
#endif

void main()
{
    int vertex = gl_VertexID % (SLOTS * FAN);
    uint cell = texelFetch(cells, first_cell + gl_VertexID / (SLOTS * FAN)).r;
    ivec3 at = cell_place(cell), voxel0 = at + brick_first, texel0 = at + brick_texel;
    ivec3 side = ivec3(greaterThanEqual(voxel0, level_last)) - ivec3(lessThan(voxel0, ivec3(0)));
    int odd = (voxel0.x ^ voxel0.y ^ voxel0.z) & 1;
    int kind = ((((side.z + 1) * 3 + side.y + 1) * 3 + side.x + 1) * 2 + odd) * 2 + int(cell >> 27);
    int record = (kind * (SLOTS * FAN) + vertex) * TEXELS;
    vec4 shift = texelFetch(basis, record + 2);
    int code = int(shift.w);

    vec4 scalar;
    for (int v = 0; v < 4; v++)
        scalar[v] = voxel(texel0 + (ivec3(code) >> ivec3(3 * v, 3 * v + 1, 3 * v + 2) & 1)) * value_sign;
    float low = min(min(scalar.x, scalar.y), min(scalar.z, scalar.w));
    float high = max(max(scalar.x, scalar.y), max(scalar.z, scalar.w));
    span.x = clamp(dot(texelFetch(basis, record), scalar), low, high);
    span.y = clamp(dot(texelFetch(basis, record + 1), scalar), low, high);
    span.z = texelFetch(basis, record + 3).x;

    dvec3 p = clamp(dvec3(voxel0 + (ivec3(code) >> ivec3(12, 13, 14) & 1)), dvec3(-0.5LF), dvec3(level_last) + 0.5LF);
    dvec2 place = origin.xy + dvec2(dot(to_x, p), dot(to_y, p)) + dvec2(pixel_x, pixel_y) * dvec2(shift.xy);
    gl_Position = vec4(vec2(place), 0.0, 1.0);
#ifdef CUTS
    entry = float(origin.z + dot(to_depth, p) + double(shift.z));
#endif
}
