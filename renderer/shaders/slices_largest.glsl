/* Maximum intensity: the largest value that slices left in a pixel, classified. */
uniform sampler2D picture;
uniform float unit_mm; /* length that a control point's opacity belongs to */

layout(location = 0) out vec4 colour;

void main()
{
    float v = texelFetch(picture, ivec2(gl_FragCoord.xy), 0).r;
    colour = vec4(0.0);
    if (!isinf(v)) {
        Piece piece = find_piece(v);
        float a = opacity(extinction(piece, v) * unit_mm);
        colour = vec4(a * emission(piece, v), a);
    }
}
