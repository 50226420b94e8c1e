/* What a conversion's bricks depend on, in words: two conversions of one identity make the same bricks. */
#ifndef BRICK_BUILD_IDENTITY_H
#define BRICK_BUILD_IDENTITY_H

#include <brick/build.h>

/* One "key: value" a line, to free(); NULL when memory is out. The source has a state. */
char *identity_text(const struct brick_grid *grid, const struct brick_source *source,
                    const struct brick_build_params *params);

#endif
