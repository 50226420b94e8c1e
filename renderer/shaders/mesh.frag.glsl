/* Where the pixel's ray meets the triangle's plane, in double precision (renderer/scene/mesh_tree.c does the same), not what the
 * rasteriser interpolates: t is right to some 1e-15 of the distance. The rasteriser only says which pixels: it puts corners
 * on a grid of 1/256 pixel or so, and where it has a pixel that the triangle has not, the triangle's nearest point counts. */
uniform dvec3 origin, origin_u, origin_v, dir, dir_u, dir_v; /* struct brick_view, in the world */
uniform double farthest_mm;                                  /* nothing is farther away */
uniform vec3 rgb;                                            /* where the mesh has no colours */
#ifdef MESH_NORMALS
uniform samplerBuffer normals;
#endif
#ifdef MESH_COLOURS
uniform samplerBuffer colours;
#endif
flat in int corner;
layout(location = 0) out vec4 colour;
layout(location = 1) out uvec2 way; /* t, a double's bits */

#if defined MESH_NORMALS || defined MESH_COLOURS
vec3 between(samplerBuffer values, uvec3 vertex, vec3 weight)
{
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 3; k++) {
        int at = 3 * int(vertex[k]);
        sum += weight[k] * vec3(texelFetch(values, at).r, texelFetch(values, at + 1).r, texelFetch(values, at + 2).r);
    }
    return sum;
}
#endif

void main()
{
    dvec2 pixel = dvec2(ivec2(gl_FragCoord.xy) + tile_origin) + 0.5LF;
    dvec3 o = origin + pixel.x * origin_u + pixel.y * origin_v;
    dvec3 d = dir + pixel.x * dir_u + pixel.y * dir_v;
    d /= sqrt(dot(d, d));
    uvec3 vertex = uvec3(texelFetch(triangles, corner).r, texelFetch(triangles, corner + 1).r,
                         texelFetch(triangles, corner + 2).r);
    dvec3 a = position(vertex.x) - o, to_b = position(vertex.y) - o - a, to_c = position(vertex.z) - o - a;
    dvec3 n = cross(to_b, to_c);
    double along = dot(n, d), area = dot(n, n);
    if (along == 0.0LF || !(area > 0.0LF))
        discard;
    double t = dot(n, a) / along;
    dvec3 p = t * d - a;
    double b = dot(cross(p, to_c), n) / area, c = dot(cross(to_b, p), n) / area;
    if (b < 0.0LF || c < 0.0LF || b + c > 1.0LF) {
        b = max(b, 0.0LF);
        c = max(c, 0.0LF);
        double sum = max(b + c, 1.0LF);
        b /= sum;
        c /= sum;
        t = dot(a + b * to_b + c * to_c, d);
    }
    if (!(t >= 0.0LF))
        discard;
    vec3 weight = vec3(1.0LF - b - c, b, c), normal = vec3(0.0), base = rgb;
#ifdef MESH_COLOURS
    base = between(colours, vertex, weight);
#endif
#ifdef MESH_NORMALS
    normal = between(normals, vertex, weight);
#endif
    if (normal == vec3(0.0))
        normal = vec3(n / sqrt(area));
    colour = vec4(shade(base, normal, vec3(d)), 1.0);
    way = unpackDouble2x32(t);
    gl_FragDepth = float(t / farthest_mm);
}
