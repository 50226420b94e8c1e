/* Meshes by ending. A mesh without a triangle is refused here, for all formats alike. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <formats/formats.h>

#include "mesh_formats.h"

static const struct mesh_format {
    const char *ending, *library, *package;
    /* NULL when the library is not in this build. */
    int (*read)(struct brick_mesh *mesh, const struct brick_io *io, struct brick_error *err);
} formats[] = {
    {".ply", NULL, NULL, fmt_mesh_ply_read},
#ifdef HAVE_TINYOBJ
    {".obj", "tinyobjloader", "libtinyobjloader-dev", fmt_mesh_obj_read},
#else
    {".obj", "tinyobjloader", "libtinyobjloader-dev", NULL},
#endif
};

static int find_format(const struct mesh_format **format, const char *path, struct brick_error *err)
{
    const char *ending = strrchr(path, '.');
    for (size_t i = 0; ending && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(ending, formats[i].ending) == 0) {
            *format = &formats[i];
            if (!formats[i].read)
                return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                                  "%s: this build has no %s: install %s (%s on Debian) and build again", path,
                                  formats[i].ending + 1, formats[i].library, formats[i].package);
            return BRICK_OK;
        }
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s: not a mesh's name: it must end in .ply or .obj", path);
}

int fmt_mesh_place(const struct brick_io *io, int result, const struct brick_error *inner,
                   struct brick_error *err)
{
    return result ? brick_fail(err, result, "%s: %s", io->path, inner->message) : BRICK_OK;
}

int fmt_mesh_read(struct brick_mesh *mesh, const char *path, struct brick_error *err)
{
    const struct mesh_format *format = NULL;
    struct brick_io io = BRICK_IO_CLOSED;
    *mesh = (struct brick_mesh){0};
    int result = find_format(&format, path, err);
    if (result || (result = brick_io_open(&io, path, err)))
        return result;
    result = format->read(mesh, &io, err);
    if (!result && !mesh->triangles)
        result = brick_fail(err, BRICK_ERR_FORMAT, "%s: no triangles in it", path);
    brick_io_close(&io);
    if (result)
        brick_mesh_finish(mesh);
    return result;
}
