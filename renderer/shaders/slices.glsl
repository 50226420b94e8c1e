/* One slice of a box of active macrocells, blended over the others (Wilson, Van Gelder and Wilhelms 1994, section 2): colour
 * and opacity of the field integrated over the slice's thickness along the pixel's ray.
 *
 * The polygon is a little larger than the slice; a fragment belongs to the box that owns its sample's cell, so between boxes
 * no pixel is drawn twice and none is missed. The sample's place comes from the pixel and the slice's number alone, in double
 * precision: it knows neither bricks nor boxes. It lies in the middle of the part of the slice that is inside the span. */
layout(early_fragment_tests) in; /* pixels that are opaque already have a depth that stops them */

flat in ivec3 low, high, offset;
flat in int plane;
layout(location = 0) out vec4 colour;

uniform usampler2D spans;              /* slices_span.glsl */
uniform vec3 world, world_u, world_v;  /* a pixel's direction in world axes, with a depth of 1 */
uniform float spacing_mm, per_unit;    /* a slice's depth; 1 / the length that independent emission counts in */

float value_at(Cell c, ivec3 texel, vec3 f)
{
#ifdef POINT
    return voxel(texel + ivec3(greaterThanEqual(f, vec3(0.5)))) * value_sign;
#else
    return cell_value(c, f);
#endif
}

#if MODE == MODE_SHADED
vec3 gradient_at(Cell c, ivec3 texel, vec3 f)
{
#ifdef POINT
    const ivec2 e = ivec2(1, 0);
    ivec3 t = texel + ivec3(greaterThanEqual(f, vec3(0.5)));
    vec3 g = vec3(voxel(t + e.xyy) - voxel(t - e.xyy), voxel(t + e.yxy) - voxel(t - e.yxy),
                  voxel(t + e.yyx) - voxel(t - e.yyx));
#ifdef NONFINITE
    for (int i = 0; i < 3; i++)
        if ((floatBitsToUint(g[i]) & 0x7f800000u) == 0x7f800000u)
            g[i] = 0.0;
#endif
    return 0.5 * g;
#else
    return cell_gradient(c, texel, f);
#endif
}
#endif

#ifdef PRECLASSIFIED
uniform sampler2DArray colours; /* in the atlas's place: colour and opacity of a slice's thickness (methods/slices/palette.c) */

vec4 colour_of(ivec3 texel)
{
    return texelFetch(colours, texel, 0);
}

vec4 colour_at(ivec3 t, vec3 f)
{
#ifdef POINT
    return colour_of(t + ivec3(greaterThanEqual(f, vec3(0.5))));
#else
    const ivec2 e = ivec2(1, 0);
    precise vec4 near = mix(mix(colour_of(t), colour_of(t + e.xyy), f.x), mix(colour_of(t + e.yxy), colour_of(t + e.xxy), f.x), f.y);
    t.z++;
    precise vec4 far = mix(mix(colour_of(t), colour_of(t + e.xyy), f.x), mix(colour_of(t + e.yxy), colour_of(t + e.xxy), f.x), f.y);
    precise vec4 sum = mix(near, far, f.z);
    return sum;
#endif
}

/* -ln(1 - A), with A's relative accuracy: 2 artanh(z), z = A / (2 - A), by its series for A up to 1/2. (1 - A is 2^-24 at
 * least as transfer functions clamp it, but for rounding.) */
float depth_of(float a)
{
    float z = a / (2.0 - a), s = z * z;
    float series = 1.0 + s * (1.0 / 3.0 + s * (1.0 / 5.0 + s * (1.0 / 7.0 + s * (1.0 / 9.0 + s * (1.0 / 11.0 + s * (1.0 / 13.0))))));
    return a > 0.5 ? -log(max(1.0 - a, 1.0e-30)) : 2.0 * z * series;
}

/* What a part of the slice's thickness, or a slanted way through it, makes of a colour stored for all of it. */
vec4 integrate_part(vec4 whole, float part)
{
    float alpha = part != 1.0 ? opacity(part * depth_of(whole.a)) : whole.a;
#ifdef INDEPENDENT
    return vec4(whole.rgb * (whole.a > 0.0 ? alpha / whole.a : part), alpha);
#else
    return vec4(whole.rgb * alpha, alpha);
#endif
}
#elif MODE != MODE_MIP
/* Emission and absorption over `length` mm of extinction sigma. */
vec4 integrate(vec3 rgb, float sigma, float length_mm)
{
    precise float x = sigma * length_mm;
    float alpha = opacity(x);
#ifdef INDEPENDENT
    /* rgb a unit of length: (1 - exp(-x)) / x of it gets out, all where nothing is absorbed. */
    float fraction = x > 1.0e-30 ? alpha / x : 1.0;
    return vec4(rgb * (length_mm * per_unit * fraction), alpha);
#else
    return vec4(rgb * alpha, alpha);
#endif
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 span = texelFetch(spans, pixel, 0);
    int first = int(span.x), last = int(span.y);
    float from = plane == first ? uintBitsToFloat(span.z) : 0.0;
    float to = plane == last ? uintBitsToFloat(span.w) : 1.0;
    dvec2 uv = pixel_centre(pixel);
    double middle = double(plane) + 0.5LF * (double(from) + double(to));
    precise double depth = first_depth + middle * spacing;
    precise dvec3 p = ray_origin(uv) + depth * ray_direction(uv);
    /* To 2^-32: a ray that lies in a face of bricks stays on one side of it, whatever is rounded on the way, so that no
     * sample of it comes out of the order in which bricks are drawn. */
    precise dvec3 fine = floor(p * 4294967296.0LF + 0.5LF), whole = floor(fine / 4294967296.0LF);
    ivec3 cell = ivec3(whole), home = owner(cell);
    if (plane < first || plane > last || any(lessThan(home, low)) || any(greaterThanEqual(home, high)))
        discard;

    vec3 f = vec3((fine - whole * 4294967296.0LF) / 4294967296.0LF);
    ivec3 texel = cell + offset;
    vec3 direction = world;
    float part = to - from;
#ifdef PERSPECTIVE
    direction += float(uv.x) * world_u + float(uv.y) * world_v;
    part *= length(direction);
#endif
#ifdef PRECLASSIFIED
    colour = integrate_part(colour_at(texel, f), part);
#else
    Cell c;
#if !defined(POINT) || defined(NONFINITE)
    c = cell_fetch(texel);
    bool valid = cell_valid(c);
#else
    const bool valid = true;
#endif
    float v = value_at(c, texel, f);
#if MODE == MODE_MIP
    colour = vec4(valid ? v : uintBitsToFloat(0xff800000u));
#else
    Piece piece = find_piece(v);
    float sigma = extinction(piece, v);
    vec3 rgb = emission(piece, v);
#if MODE == MODE_SHADED
    rgb = shade(rgb, gradient_at(c, texel, f), normalize(direction));
#endif
    colour = valid ? integrate(rgb, sigma, part * spacing_mm) : vec4(0.0);
#endif
#endif
}
