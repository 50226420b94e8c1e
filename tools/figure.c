/* Why: measurements leave tables and plots in a folder. Plots are scripts for gnuplot, run without a shell in
 * between, so that a folder may have any name. */
#include "figure.h"

#include <errno.h>
#include <spawn.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

int tool_folder_make(const char *folder, struct brick_error *err)
{
    struct stat status;
    if (!mkdir(folder, 0777) || (errno == EEXIST && !stat(folder, &status) && S_ISDIR(status.st_mode)))
        return BRICK_OK;
    return brick_fail(err, BRICK_ERR_IO, "%s: cannot make this folder: %s", folder, strerror(errno));
}

static int path_of(const char *folder, const char *name, char path[4096], struct brick_error *err)
{
    if (snprintf(path, 4096, "%s/%s", folder, name) >= 4096)
        return brick_fail(err, BRICK_ERR_ARGUMENT, "%.200s...: the name is too long", folder);
    return BRICK_OK;
}

int tool_file_begin(FILE **file, const char *folder, const char *name, struct brick_error *err)
{
    char path[4096];
    *file = NULL;
    int code = path_of(folder, name, path, err);
    if (!code && !(*file = fopen(path, "w")))
        code = brick_fail(err, BRICK_ERR_IO, "%s: cannot write: %s", path, strerror(errno));
    return code;
}

int tool_file_finish(FILE **file, const char *folder, const char *name, struct brick_error *err)
{
    bool bad = fflush(*file) || ferror(*file);
    int number = errno;
    bad = fclose(*file) || bad;
    *file = NULL;
    return bad ? brick_fail(err, BRICK_ERR_IO, "%s/%s: cannot write: %s", folder, name, strerror(number))
               : BRICK_OK;
}

int tool_gnuplot(const char *folder, const char *script, bool *drawn, struct brick_error *err)
{
    char *arguments[] = {"gnuplot", (char *)script, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status = 0;
    if (posix_spawn_file_actions_init(&actions))
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory to run gnuplot");
    int failed = posix_spawn_file_actions_addchdir_np(&actions, folder);
    if (!failed)
        failed = posix_spawnp(&child, arguments[0], &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    *drawn = !failed;
    if (failed == ENOENT)
        return BRICK_OK;
    if (failed)
        return brick_fail(err, BRICK_ERR_IO, "cannot run gnuplot: %s", strerror(failed));
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return brick_fail(err, BRICK_ERR_IO, "gnuplot: %s", strerror(errno));
    /* A missing program may be noticed only by the child, which then exits with 127. */
    *drawn = status == 0;
    if (status == 0 || (WIFEXITED(status) && WEXITSTATUS(status) == 127))
        return BRICK_OK;
    return brick_fail(err, BRICK_ERR_IO, "gnuplot cannot draw %s/%s", folder, script);
}
