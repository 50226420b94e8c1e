/* How far ahead, in units of the view's dir, the pixel's ray meets the face's plane: at least (front) or at most so far,
 * whatever float32 rounds. Each sum below is right to 4 units in the last place of its largest term. */
uniform vec3 eye, eye_u, eye_v, way, way_u, way_v; /* struct brick_view */
uniform float depth_scale;
uniform bool front;
uniform ivec2 tile_origin;
flat in float plane;
flat in int axis;
#define ROUNDING 5.0e-7

float sum(float a, float b, float c, out float slack)
{
    slack = ROUNDING * (abs(a) + abs(b) + abs(c));
    return a + b + c;
}

void main()
{
    vec2 pixel = gl_FragCoord.xy + vec2(tile_origin);
    float from_slack, way_slack;
    float from = sum(eye[axis], pixel.x * eye_u[axis], pixel.y * eye_v[axis], from_slack);
    float pace = sum(way[axis], pixel.x * way_u[axis], pixel.y * way_v[axis], way_slack);
    float distance = (plane - from) * (pace < 0.0 ? -1.0 : 1.0);
    from_slack += ROUNDING * abs(plane);
    float ahead = front ? (distance - from_slack) / (abs(pace) + way_slack)
                        : (distance + from_slack) / max(abs(pace) - way_slack, 1.0e-30);
    gl_FragDepth = clamp(ahead * depth_scale, 0.0, 1.0);
}
