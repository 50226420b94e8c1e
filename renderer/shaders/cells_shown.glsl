/* Which cells can show anything (Maximo et al. 2008, section 6: volunits of no opacity are left out): four list entries a
 * fragment, 1 where a value between the cell's corners has extinction. Cells with a corner that is not finite show nothing. */
uniform usamplerBuffer shown; /* for each piece of the transfer function, how many before it are not transparent */
uniform int first_cell, end_cell, first_row;
uniform ivec3 brick_texel;
out vec4 result;

bool cell_shown(int index)
{
    if (index >= end_cell)
        return false;
    Cell c = cell_fetch(cell_place(texelFetch(cells, index).r) + brick_texel);
    if (!cell_valid(c))
        return false;
#ifdef SKIP
    vec4 low = min(c.low * value_sign, c.high * value_sign), high = max(c.low * value_sign, c.high * value_sign);
    int first = find_piece(min(min(low.x, low.y), min(low.z, low.w))).index;
    int last = find_piece(max(max(high.x, high.y), max(high.z, high.w))).index;
    return texelFetch(shown, last + 1).r > texelFetch(shown, first).r;
#else
    return true;
#endif
}

void main()
{
    int index = first_cell + 4 * ((int(gl_FragCoord.y) - first_row) * ROW + int(gl_FragCoord.x));
    for (int i = 0; i < 4; i++)
        result[i] = cell_shown(index + i) ? 1.0 : 0.0;
}
