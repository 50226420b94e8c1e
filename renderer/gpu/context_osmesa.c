/* OSMesa: Mesa's renderer in software into memory, with no system below it. Gone from Mesa 25.1 on.
 *
 * Its header pulls in gl.h, which clashes with core-profile types, so its few functions are declared here. A
 * context is bound with a picture of a few pixels; everything is drawn to framebuffer objects. */
#include "context.h"

#include <dlfcn.h>
#include <stdlib.h>

#define OSMESA_FORMAT                0x22
#define OSMESA_PROFILE               0x33
#define OSMESA_CORE_PROFILE          0x34
#define OSMESA_CONTEXT_MAJOR_VERSION 0x36
#define OSMESA_CONTEXT_MINOR_VERSION 0x37

#define PICTURE_EDGE 4

typedef struct osmesa_context *OSMesaContext;
typedef void (*OSMESAproc)(void);

struct osmesa {
    OSMesaContext (*CreateContextAttribs)(const int *attributes, OSMesaContext share);
    void (*DestroyContext)(OSMesaContext context);
    GLboolean (*MakeCurrent)(OSMesaContext context, void *buffer, GLenum type, GLsizei width, GLsizei height);
    OSMESAproc (*GetProcAddress)(const char *name);
    OSMesaContext context;
    unsigned char picture[PICTURE_EDGE * PICTURE_EDGE * 4];
};

static int load(struct osmesa *o, struct brick_error *err)
{
    static const char *const names[] = {"libOSMesa.so.8", "libOSMesa.so"};
    void *library = NULL;
    for (size_t i = 0; !library && i < sizeof names / sizeof *names; i++)
        library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                          "OSMesa: libOSMesa.so.8 is missing: install libosmesa6");
#define LOAD(name)                                                                                           \
    {                                                                                                        \
        union {                                                                                              \
            void *object;                                                                                    \
            __typeof__(o->name) function;                                                                    \
        } address = {dlsym(library, "OSMesa" #name)};                                                        \
        o->name = address.function;                                                                          \
        if (!o->name)                                                                                        \
            return brick_fail(err, BRICK_ERR_UNSUPPORTED, "OSMesa: the library has no OSMesa" #name);        \
    }
    LOAD(CreateContextAttribs)
    LOAD(DestroyContext)
    LOAD(MakeCurrent)
    LOAD(GetProcAddress)
#undef LOAD
    return BRICK_OK;
}

static void osmesa_destroy(void **native)
{
    struct osmesa *o = *native;
    if (o && o->context)
        o->DestroyContext(o->context);
    free(o);
    *native = NULL;
}

static int osmesa_create(void **native, struct brick_error *err)
{
    static const int attributes[] = {OSMESA_FORMAT,
                                     GL_RGBA,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0,
                                     0};
    int result;
    struct osmesa *o = calloc(1, sizeof *o);
    *native = o;
    if (!o)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for an OSMesa context");
    if ((result = load(o, err)))
        goto fail;
    if (!(o->context = o->CreateContextAttribs(attributes, NULL))) {
        result =
            brick_fail(err, BRICK_ERR_UNSUPPORTED, "OSMesa: the library gives no OpenGL 4.3 core context");
        goto fail;
    }
    return BRICK_OK;
fail:
    osmesa_destroy(native);
    return result;
}

static int osmesa_bind(void *native, struct brick_error *err)
{
    struct osmesa *o = native;
    if (!o->MakeCurrent(o->context, o->picture, GL_UNSIGNED_BYTE, PICTURE_EDGE, PICTURE_EDGE))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "OSMesa: OSMesaMakeCurrent fails");
    return BRICK_OK;
}

static void osmesa_unbind(void *native)
{
    struct osmesa *o = native;
    o->MakeCurrent(NULL, NULL, GL_UNSIGNED_BYTE, 0, 0);
}

static void *osmesa_get_proc(void *native, const char *name)
{
    struct osmesa *o = native;
    union {
        OSMESAproc function;
        void *object;
    } address = {o->GetProcAddress(name)};
    return address.object;
}

const struct vr_context_backend vr_context_osmesa = {
    .name = "OSMesa",
    .create = osmesa_create,
    .destroy = osmesa_destroy,
    .bind = osmesa_bind,
    .unbind = osmesa_unbind,
    .get_proc = osmesa_get_proc,
};
