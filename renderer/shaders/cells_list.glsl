/* The list of cells: walk.h. */
uniform usamplerBuffer cells;

/* A cell's lower corner, in voxels from the brick's first one. */
ivec3 cell_place(uint entry)
{
    return ivec3(entry & 511u, entry >> 9 & 511u, entry >> 18 & 511u) - 1;
}
