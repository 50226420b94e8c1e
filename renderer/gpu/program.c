/* Compiling and linking. A #line before every part gives its lines numbers of their own, so that a line in
 * the compiler's log names the part: source string numbers would be the means for that, but Mesa reports them
 * as 0. */
#include "program.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shaders.h"

#define PART_LINES 10000

static void first_line(char *log)
{
    log[strcspn(log, "\r\n")] = '\0';
}

/* Drivers write "0:23(5): ..." or "ERROR: 0:23: ..." or "0(23) : ...": the line is the second number. */
static void place_of(const char *log, const struct vr_shader_part *parts, int count, char *place,
                     size_t bytes)
{
    char *end;
    while (*log && !isdigit((unsigned char)*log))
        log++;
    strtol(log, &end, 10);
    long line = *end ? strtol(end + 1, NULL, 10) : 0, part = line / PART_LINES - 1;
    if (part >= 0 && part < count)
        snprintf(place, bytes, "%s:%ld", parts[part].name, line % PART_LINES);
    else
        snprintf(place, bytes, "shader");
}

/* What loops need of a uniform they take as HELD(uniform), read once before: llvmpipe reads a uniform in a
 * loop ray by ray. A plain copy would be taken for the uniform itself; a sum is not, not even with a uniform
 * that is never set and so 0. */
static const char prelude[] = "#version 430 core\n"
                              "uniform int nothing;\n"
                              "#define HELD(value) ((value) + nothing)\n";

static int compile(struct vr_context *context, GLenum stage, const char *defines,
                   const struct vr_shader_part *parts, int count, GLuint *shader, struct brick_error *err)
{
    const struct vr_gl *gl = &context->gl;
    const char *strings[2 + 2 * VR_PROGRAM_MAX_PARTS] = {prelude, defines};
    char lines[VR_PROGRAM_MAX_PARTS][32], place[64];
    GLint ok = GL_FALSE;
    char log[480] = "";
    for (int i = 0; i < count; i++) {
        snprintf(lines[i], sizeof lines[i], "#line %d\n", (i + 1) * PART_LINES + 1);
        strings[2 + 2 * i] = lines[i];
        strings[3 + 2 * i] = parts[i].text;
    }
    *shader = gl->CreateShader(stage);
    gl->ShaderSource(*shader, 2 + 2 * count, strings, NULL);
    gl->CompileShader(*shader);
    gl->GetShaderiv(*shader, GL_COMPILE_STATUS, &ok);
    if (ok)
        return BRICK_OK;
    gl->GetShaderInfoLog(*shader, (GLsizei)sizeof log, NULL, log);
    first_line(log);
    place_of(log, parts, count, place, sizeof place);
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s does not compile on %s: %s", place, context->renderer,
                      log[0] ? log : "no log");
}

int vr_program_create(struct vr_context *context, const char *defines, const struct vr_program_source *source,
                      GLuint *program, struct brick_error *err)
{
    static const struct vr_shader_part fullscreen = {"fullscreen.vert.glsl", vr_shader_fullscreen_vert};
    const struct vr_gl *gl = &context->gl;
    const struct vr_shader_part *vertex_parts = source->vertex ? source->vertex : &fullscreen;
    int vertex_count = source->vertex ? source->vertex_count : 1;
    GLuint vertex = 0, fragment = 0;
    GLint ok = GL_FALSE;
    char log[480] = "";
    int result;

    *program = 0;
    if (vertex_count < 1 || vertex_count > VR_PROGRAM_MAX_PARTS || source->fragment_count < 1 ||
        source->fragment_count > VR_PROGRAM_MAX_PARTS)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "a program of %d and %d parts", vertex_count,
                          source->fragment_count);
    if ((result = compile(context, GL_VERTEX_SHADER, defines, vertex_parts, vertex_count, &vertex, err)) ||
        (result = compile(context, GL_FRAGMENT_SHADER, defines, source->fragment, source->fragment_count,
                          &fragment, err)))
        goto done;
    *program = gl->CreateProgram();
    gl->AttachShader(*program, vertex);
    gl->AttachShader(*program, fragment);
    gl->LinkProgram(*program);
    gl->GetProgramiv(*program, GL_LINK_STATUS, &ok);
    if (!ok) {
        gl->GetProgramInfoLog(*program, (GLsizei)sizeof log, NULL, log);
        first_line(log);
        gl->DeleteProgram(*program);
        *program = 0;
        result = brick_fail(err, BRICK_ERR_UNSUPPORTED, "%s does not link on %s: %s",
                            source->fragment[source->fragment_count - 1].name, context->renderer,
                            log[0] ? log : "no log");
    }
done:
    gl->DeleteShader(vertex);
    gl->DeleteShader(fragment);
    return result;
}
