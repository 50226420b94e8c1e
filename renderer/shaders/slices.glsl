/* One slice of a box of active macrocells, blended over the others (Wilson, Van Gelder and Wilhelms 1994, section 2): colour
 * and opacity of the field integrated over the slice's thickness along the pixel's ray.
 *
 * The polygon is a little larger than the slice; a fragment belongs to the box that owns its sample's cell, so between boxes
 * no pixel is drawn twice and none is missed. The sample's place comes from the pixel and the slice's number alone. It lies in
 * the middle of the part of the slice that is inside the span; pre-integrated, samples are where that part begins and ends
 * (slices_slab.glsl). */
layout(early_fragment_tests) in; /* pixels that are opaque already have a depth that stops them */

layout(location = 0) out vec4 colour;

uniform usampler2D spans;              /* slices_span.glsl */
uniform vec3 world, world_u, world_v;  /* a pixel's direction in world axes, with a depth of 1 */
uniform float spacing_mm, per_unit;    /* a slice's depth; 1 / the length that independent emission counts in */

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
    Place at = place_at(uv, double(plane) + 0.5LF * (double(from) + double(to)));
#ifdef PREINTEGRATED
    Place front = place_at(uv, double(plane) + double(from)), back = place_at(uv, double(plane) + double(to));
    bool mine = owns(front, at, back);
#else
    bool mine = in_box(owner(at.cell));
#endif
    if (plane < first || plane > last || !mine)
        discard;

    vec3 direction = world;
    float part = to - from;
#ifdef PERSPECTIVE
    direction += float(uv.x) * world_u + float(uv.y) * world_v;
    part *= length(direction);
#endif
#if defined(PRECLASSIFIED)
    colour = integrate_part(colour_at(at.cell + offset, at.f), part);
#elif defined(PREINTEGRATED)
    colour = slab(front, at, back, part * spacing_mm, normalize(direction));
#else
    Cell c;
    float v;
    bool valid = value_at(at, c, v);
#if MODE == MODE_MIP
    colour = vec4(valid ? v : uintBitsToFloat(0xff800000u));
#else
    Piece piece = find_piece(v);
    float sigma = extinction(piece, v);
    vec3 rgb = emission(piece, v);
#if MODE == MODE_SHADED
    rgb = shade(rgb, gradient_at(at, c), normalize(direction));
#endif
    colour = valid ? integrate(rgb, sigma, part * spacing_mm) : vec4(0.0);
#endif
#endif
}
