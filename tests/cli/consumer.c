/* What a program outside this tree looks like: compiled against the installed library, it prints one voxel.
 */
#include <stdio.h>
#include <stdlib.h>

#include <brick/type.h>
#include <brick/volume.h>

int main(int argc, char **argv)
{
    struct brick_volume *volume = NULL;
    struct brick_error err;
    uint64_t lo[3], hi[3];
    double voxel; /* room for any type */

    if (argc != 5)
        return 2;
    for (int i = 0; i < 3; i++) {
        lo[i] = strtoull(argv[2 + i], NULL, 10);
        hi[i] = lo[i] + 1;
    }
    if (brick_volume_open(&volume, argv[1], &err) || brick_volume_read_box(volume, 0, lo, hi, &voxel, &err)) {
        fprintf(stderr, "consumer: %s\n", err.message);
        brick_volume_close(&volume);
        return 1;
    }
    printf("%g\n", brick_type_load(brick_volume_grid(volume)->type, &voxel, 0));
    brick_volume_close(&volume);
    return 0;
}
