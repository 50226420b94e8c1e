/* A mesh: both stages find a triangle's corners by number, in double precision, in the world. */
uniform usamplerBuffer positions; /* three doubles a vertex, as bits */
uniform usamplerBuffer triangles; /* three vertices each */
uniform ivec2 tile_origin;        /* picture's pixel at the layer's corner */

dvec3 position(uint vertex)
{
    int at = 3 * int(vertex);
    return dvec3(packDouble2x32(texelFetch(positions, at).rg), packDouble2x32(texelFetch(positions, at + 1).rg),
                 packDouble2x32(texelFetch(positions, at + 2).rg));
}
