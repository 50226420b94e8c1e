/* What a pass tells the host (residency/feedback.h): a word a tile of the picture that is not 0 when a ray there is not
 * finished, then two bits a brick, 16 in a word. */
#define WANT_NEEDED 1u
#define WANT_AHEAD  2u

layout(r32ui) uniform uimageBuffer feedback;
uniform int tiles_across, tiles;

void want(int brick, uint bit)
{
    int word = tiles + (brick >> 4);
    uint mask = bit << ((brick & 15) * 2);
    if ((imageLoad(feedback, word).r & mask) != mask) /* many rays want the same: spare most of the atomics */
        imageAtomicOr(feedback, word, mask);
}

/* Every ray that gets here writes the same. */
void mark_unfinished(ivec2 pixel)
{
    ivec2 tile = pixel / TILE_EDGE;
    imageStore(feedback, tile.y * tiles_across + tile.x, uvec4(1u));
}
