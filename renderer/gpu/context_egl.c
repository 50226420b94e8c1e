/* EGL without a window system: Mesa's surfaceless platform, or else a device's.
 *
 * The library is never closed and its display never terminated: EGL gives every user in the process the same
 * display, and terminating it would take their contexts away. Types come from the EGL headers, functions at
 * run time. */
#include "context.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#define MAX_DEVICES 16

#define EGL_FUNCTIONS(X)                                                                                     \
    X(PFNEGLGETPROCADDRESSPROC, GetProcAddress)                                                              \
    X(PFNEGLQUERYSTRINGPROC, QueryString)                                                                    \
    X(PFNEGLINITIALIZEPROC, Initialize)                                                                      \
    X(PFNEGLBINDAPIPROC, BindAPI)                                                                            \
    X(PFNEGLCHOOSECONFIGPROC, ChooseConfig)                                                                  \
    X(PFNEGLCREATECONTEXTPROC, CreateContext)                                                                \
    X(PFNEGLDESTROYCONTEXTPROC, DestroyContext)                                                              \
    X(PFNEGLMAKECURRENTPROC, MakeCurrent)                                                                    \
    X(PFNEGLRELEASETHREADPROC, ReleaseThread)                                                                \
    X(PFNEGLGETERRORPROC, GetError)

struct egl {
#define MEMBER(type, name) type name;
    EGL_FUNCTIONS(MEMBER)
#undef MEMBER
    PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplayEXT;
    PFNEGLQUERYDEVICESEXTPROC QueryDevicesEXT;
    EGLDisplay display;
    EGLContext context;
};

static bool has_extension(const char *list, const char *name)
{
    size_t n = strlen(name);
    for (const char *p = list; p && (p = strstr(p, name)); p += n)
        if ((p == list || p[-1] == ' ') && (p[n] == ' ' || p[n] == '\0'))
            return true;
    return false;
}

static int load(struct egl *e, struct brick_error *err)
{
    void *library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "EGL: libEGL.so.1 is missing: install libegl1");
#define LOAD(type, name)                                                                                     \
    {                                                                                                        \
        union {                                                                                              \
            void *object;                                                                                    \
            type function;                                                                                   \
        } address = {dlsym(library, "egl" #name)};                                                           \
        e->name = address.function;                                                                          \
        if (!e->name)                                                                                        \
            return brick_fail(err, BRICK_ERR_UNSUPPORTED, "EGL: libEGL.so.1 has no egl" #name);              \
    }
    EGL_FUNCTIONS(LOAD)
#undef LOAD
    e->GetPlatformDisplayEXT = (PFNEGLGETPLATFORMDISPLAYEXTPROC)e->GetProcAddress("eglGetPlatformDisplayEXT");
    e->QueryDevicesEXT = (PFNEGLQUERYDEVICESEXTPROC)e->GetProcAddress("eglQueryDevicesEXT");
    return BRICK_OK;
}

/* OSMesa, which is what there is without EGL, knows no GPU. */
bool vr_context_has_gpu(void)
{
    struct egl e = {0};
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    if (load(&e, NULL))
        return false;
    const PFNEGLQUERYDEVICESTRINGEXTPROC query =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)e.GetProcAddress("eglQueryDeviceStringEXT");
    const char *extensions = e.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!query || !e.QueryDevicesEXT || !has_extension(extensions, "EGL_EXT_device_query") ||
        !has_extension(extensions, "EGL_EXT_device_enumeration") ||
        !e.QueryDevicesEXT(MAX_DEVICES, devices, &count))
        return true;
    for (EGLint i = 0; i < count; i++)
        if (!has_extension(query(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
            return true;
    return false;
}

static bool try_display(struct egl *e, EGLDisplay display)
{
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint configs = 0;
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                         4,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         3,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
    if (display == EGL_NO_DISPLAY || !e->Initialize(display, NULL, NULL))
        return false;
    const char *extensions = e->QueryString(display, EGL_EXTENSIONS);
    if (!has_extension(extensions, "EGL_KHR_surfaceless_context") || !e->BindAPI(EGL_OPENGL_API))
        return false;
    if (!has_extension(extensions, "EGL_KHR_no_config_context") &&
        (!e->ChooseConfig(display, config_attributes, &config, 1, &configs) || configs < 1))
        return false;
    e->display = display;
    e->context = e->CreateContext(display, config, EGL_NO_CONTEXT, context_attributes);
    return e->context != EGL_NO_CONTEXT;
}

static int open_display(struct egl *e, struct brick_error *err)
{
    const char *extensions = e->QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    if (e->GetPlatformDisplayEXT && has_extension(extensions, "EGL_MESA_platform_surfaceless") &&
        try_display(e, e->GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL)))
        return BRICK_OK;
    if (e->GetPlatformDisplayEXT && e->QueryDevicesEXT &&
        has_extension(extensions, "EGL_EXT_platform_device") &&
        e->QueryDevicesEXT(MAX_DEVICES, devices, &count))
        for (EGLint i = 0; i < count; i++)
            if (try_display(e, e->GetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL)))
                return BRICK_OK;
    return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                      "EGL: no display without a window system gives OpenGL 4.3 core: "
                      "install libegl-mesa0 and libgl1-mesa-dri");
}

static void egl_destroy(void **native)
{
    struct egl *e = *native;
    if (e && e->context != EGL_NO_CONTEXT)
        e->DestroyContext(e->display, e->context);
    free(e);
    *native = NULL;
}

static int egl_create(void **native, struct brick_error *err)
{
    int result;
    struct egl *e = calloc(1, sizeof *e);
    *native = e;
    if (!e)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for an EGL context");
    e->context = EGL_NO_CONTEXT;
    if ((result = load(e, err)) || (result = open_display(e, err)))
        egl_destroy(native);
    return result;
}

static int egl_bind(void *native, struct brick_error *err)
{
    struct egl *e = native;
    /* The bound API belongs to the thread, not to the context. */
    if (!e->BindAPI(EGL_OPENGL_API) ||
        !e->MakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE, e->context))
        return brick_fail(err, BRICK_ERR_UNSUPPORTED, "EGL: eglMakeCurrent fails with 0x%04x",
                          (unsigned)e->GetError());
    return BRICK_OK;
}

static void egl_unbind(void *native)
{
    struct egl *e = native;
    e->MakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    e->ReleaseThread();
}

static void *egl_get_proc(void *native, const char *name)
{
    struct egl *e = native;
    union {
        __eglMustCastToProperFunctionPointerType function;
        void *object;
    } address = {e->GetProcAddress(name)};
    return address.object;
}

const struct vr_context_backend vr_context_egl = {
    .name = "EGL",
    .create = egl_create,
    .destroy = egl_destroy,
    .bind = egl_bind,
    .unbind = egl_unbind,
    .get_proc = egl_get_proc,
};
