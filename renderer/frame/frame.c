/* A frame's beginning and end, and what its shaders are told to leave out. */
#include "frame.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene.h"

void vr_frame_store_finish(struct vr_frame_store *store, struct vr_context *context)
{
    vr_programs_finish(&store->programs, context);
    vr_buffer_finish(&store->pieces, context);
    vr_buffer_finish(&store->bins, context);
    vr_meshes_finish(&store->meshes, context);
    vr_buffer_finish(&store->prefixes, context);
}

/* Can samples and voxels be counted? */
static int check_counts(const struct vr_frame *frame, struct brick_error *err)
{
    for (int a = 0; a < 3; a++)
        if (frame->level->dims[a] > INT32_MAX - 1024)
            return brick_fail(
                err, BRICK_ERR_UNSUPPORTED,
                "the level has %llu voxels on an axis, more than a shader can count: use a coarser level",
                (unsigned long long)frame->level->dims[a]);
    return vr_scene_check_step(frame->grid, frame->step_mm, err);
}

int vr_frame_init(struct vr_frame *frame, const struct vr_scene *scene, const struct vr_quality *quality,
                  struct brick_error *err)
{
    int result;
    frame->scene = scene;
    frame->quality = quality;
    frame->grid = brick_volume_grid(frame->volume);
    frame->level = &frame->grid->level[scene->level];
    frame->step_mm = quality->step_vox * brick_grid_min_spacing_mm(frame->grid);
    frame->table = (struct vr_transfer_table){.search_steps = 1};
    frame->prefixes = NULL;
    const bool preintegrated = quality->classification == VR_CLASSIFY_PREINTEGRATED;
    if (preintegrated && scene->mode != BRICK_MODE_DVR && scene->mode != BRICK_MODE_SHADED)
        return brick_fail(err, BRICK_ERR_ARGUMENT,
                          "pre-integrated classification is for dvr and shaded: the other modes integrate "
                          "nothing");
    if ((result = check_counts(frame, err)) ||
        (result =
             brick_view_init(&frame->view, &scene->camera, frame->grid, scene->width, scene->height, err)))
        return result;
    if (scene->mode == BRICK_MODE_ISO)
        return BRICK_OK;
    if ((result = vr_transfer_table_init(&frame->table, scene->transfer, frame->grid, err)) || !preintegrated)
        return result;
    return vr_prefixes_create(&frame->prefixes, &frame->table, err);
}

void vr_frame_finish(struct vr_frame *frame)
{
    vr_transfer_table_finish(&frame->table);
    free(frame->prefixes);
    frame->prefixes = NULL;
}

size_t vr_frame_defines(const struct vr_frame *frame, char defines[VR_FRAME_DEFINES_BYTES])
{
    static const char *const modes[] = {"MODE_DVR", "MODE_SHADED", "MODE_ISO", "MODE_MIP"};
    static const char *const samplers[BRICK_TYPE_STORED_COUNT] = {
        [BRICK_U8] = "usampler2DArray",  [BRICK_I8] = "isampler2DArray", [BRICK_U16] = "usampler2DArray",
        [BRICK_I16] = "isampler2DArray", [BRICK_F32] = "sampler2DArray",
    };
    const struct vr_atlas *atlas = vr_residency_atlas(frame->residency);
    const bool normalised = atlas->voxels.scale > 0.0;
    return (size_t)snprintf(
        defines, VR_FRAME_DEFINES_BYTES,
        "#define MODE_DVR 0\n#define MODE_SHADED 1\n#define MODE_ISO 2\n#define MODE_MIP 3\n"
        "#define MODE %s\n#define VOXEL_SAMPLER %s\n#define SEARCH_STEPS %u\n#define CLIP_PLANES "
        "%u\n%s%s%s%s%s%s%s",
        modes[frame->scene->mode], normalised ? "sampler2DArray" : samplers[frame->grid->type],
        frame->table.search_steps, frame->scene->clip_count,
        frame->scene->mesh_count ? "#define MESHES\n" : "", normalised ? "#define VOXEL_NORMALISED\n" : "",
        atlas->filter == VR_FILTER_FAST ? "#define FILTER_FAST\n" : "",
        frame->quality->skip ? "#define SKIP\n" : "",
        frame->quality->interleaved ? "#define INTERLEAVED\n" : "",
        brick_volume_stats(frame->volume)->nonfinite ? "#define NONFINITE\n" : "",
        frame->prefixes ? "#define PREINTEGRATED\n" : "");
}
