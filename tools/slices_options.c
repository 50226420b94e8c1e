/* Why: slices can be made worse on purpose, for their paper's tables; what only they have stands here, apart
 * from what every method takes. */
#include "slices_options.h"

const char *const tool_interpolations[] = {"trilinear", "point", NULL};
const char *const tool_framebuffers[] = {"8", "16f", "32f", NULL};
const char *const tool_classified_bits[] = {"8", "16", "32", NULL};
const char *const tool_slice_orders[] = {"front", "back", NULL};

const char *tool_slices_check(const struct tool_slices *s, bool used, bool has_step, bool has_termination)
{
    if (!used)
        return s->has_planes || s->has_interpolation || s->has_framebuffer || s->has_order || s->has_bits
                   ? "--planes, --interpolation, --framebuffer, --order and --classified-bits go with "
                     "--method slices"
                   : NULL;
    if (s->has_planes && has_step)
        return "--planes and --step exclude each other";
    if (s->order && has_termination)
        return "--order back draws all slices, without --termination";
    return NULL;
}

struct vr_slices tool_slices_quality(const struct tool_slices *s, bool has_step)
{
    return (struct vr_slices){.planes = s->has_planes ? s->planes
                                        : has_step    ? 0
                                                      : VR_PLANES_PAPER,
                              .interpolation = (enum vr_interpolation)s->interpolation,
                              .framebuffer = (enum vr_framebuffer)s->framebuffer,
                              .classified_bits = UINT32_C(8) << s->bits,
                              .back_to_front = s->order != 0};
}
