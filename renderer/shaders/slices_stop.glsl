/* Depth in front of all slices where hardly anything gets through any more; elsewhere nothing. */
uniform sampler2D picture;
uniform float termination;

void main()
{
    if (!(1.0 - texelFetch(picture, ivec2(gl_FragCoord.xy), 0).a <= termination))
        discard;
}
