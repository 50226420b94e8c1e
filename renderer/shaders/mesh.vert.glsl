/* Where a corner is in the picture: to_picture takes it, seen from the viewpoint, to (x w, y w, w) in pixels and mm ahead,
 * or in a parallel projection to (x, y, mm ahead). Row 0 is on top of the picture and of the layer. Nothing is cut off in
 * depth but what is not before the eye: depth is the fragment's to say. */
uniform dvec3 viewpoint;
uniform dmat3 to_picture;
uniform bool parallel;
uniform ivec2 layer_size;
flat out int corner; /* the triangle's first */
#define NEAREST_MM 1.0e-6LF

void main()
{
    dvec3 p = to_picture * (position(texelFetch(triangles, gl_VertexID).r) - viewpoint);
    double w = parallel ? 1.0LF : p.z;
    dvec2 xy = (p.xy - w * dvec2(tile_origin)) * (2.0LF / dvec2(layer_size)) - w;
    corner = gl_VertexID / 3 * 3;
    gl_Position = vec4(vec2(xy), parallel ? 0.0 : float(w - 2.0LF * NEAREST_MM), float(w));
}
