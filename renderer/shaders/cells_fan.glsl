/* A fragment of a tetrahedron's fan: what the rasteriser makes of its vertices' scalars and lengths, cut by the planes. */
noperspective in vec3 span;
out vec4 colour;

#ifdef CUTS
noperspective in float entry;
uniform vec4 cuts[CUTS]; /* a plane cuts the ray of (column, row) at depth x + y column + z row; w > 0: the part behind it
                            stays, < 0: the part before it; 0: rays run along it, and those with a value below 0 go */

void cut(inout float front, inout float back, inout float way)
{
    float enter = 0.0, leave = way;
    for (int i = 0; i < CUTS; i++) {
        float at = dot(cuts[i].xyz, vec3(1.0, gl_FragCoord.xy));
        enter = cuts[i].w > 0.0 ? max(enter, at - entry) : enter;
        leave = cuts[i].w < 0.0 ? min(leave, at - entry) : leave;
        leave = cuts[i].w == 0.0 && at < 0.0 ? 0.0 : leave;
    }
    float slope = way > 0.0 ? (back - front) / way : 0.0, from = front;
    back = leave < way ? from + slope * max(leave, 0.0) : back;
    front = enter > 0.0 ? from + slope * min(enter, way) : front;
    way = max(leave - enter, 0.0);
}
#endif

void main()
{
    float front = span.x, back = span.y, way = max(span.z, 0.0);
#ifdef CUTS
    cut(front, back, way);
#endif
    colour = integrate(front, back, way);
}
