/* A corner of a polygon, pulled from lists: a vertex is (x, y in the framebuffer's pixels as bits of floats, number of its
 * box, number of its plane), a box three elements: voxels from low to high (exclusive), texel = voxel + offset, and in the first
 * one's w the side and sides of a rim, or 0. */
uniform usamplerBuffer vertices, boxes;
uniform vec2 pixel_to_clip;

flat out ivec3 low, high, offset;
flat out int plane, rim;

void main()
{
    uvec4 v = texelFetch(vertices, gl_VertexID);
    int box = 3 * int(v.z);
    low = ivec3(texelFetch(boxes, box).xyz);
    rim = int(texelFetch(boxes, box).w);
    high = ivec3(texelFetch(boxes, box + 1).xyz);
    offset = ivec3(texelFetch(boxes, box + 2).xyz);
    plane = int(v.w);
    gl_Position = vec4(uintBitsToFloat(v.xy) * pixel_to_clip - 1.0, 0.0, 1.0);
}
