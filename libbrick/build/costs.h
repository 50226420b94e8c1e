/* What one thread spent on each stage: summed up when all have ended. */
#ifndef BRICK_BUILD_COSTS_H
#define BRICK_BUILD_COSTS_H

#include <brick/build.h>
#include <brick/threads.h>

struct costs {
    _Alignas(64) struct brick_build_cost stage[BRICK_STAGES]; /* aligned: threads share no cache line */
    uint64_t wait_write_ns;
};

/* Charge a stage with the time on a core since *clock (of brick_thread_ns), and set the clock to now. Where
 * other programs run, time on the wall would say more about them. */
static inline void costs_add(struct costs *costs, enum brick_build_stage stage, uint64_t *clock,
                             uint64_t bytes)
{
    uint64_t now = brick_thread_ns();
    costs->stage[stage].ns += now - *clock;
    costs->stage[stage].bytes += bytes;
    *clock = now;
}

#endif
