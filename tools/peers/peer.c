/* Why: comparing with another program in one run, frame by frame in turns, needs it to stay alive between
 * frames. */
#include "peer.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cjson/cJSON.h>

extern char **environ;

static int spawn(struct peer *peer, char *const arguments[], int in, int out)
{
    posix_spawn_file_actions_t actions;
    pid_t pid;
    if (posix_spawn_file_actions_init(&actions))
        return ENOMEM;
    int failed = posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
    if (!failed)
        failed = posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
    if (!failed)
        failed = posix_spawnp(&pid, arguments[0], &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (!failed)
        peer->pid = (int)pid;
    return failed;
}

int peer_start(struct peer *peer, const char *python, const char *script, struct brick_error *err)
{
    char *under_x[] = {"xvfb-run", "-a", (char *)python, "-c", (char *)script, NULL};
    int in[2], out[2];
    *peer = (struct peer){.to = -1, .from = -1};
    if (pipe2(in, O_CLOEXEC))
        return brick_fail(err, BRICK_ERR_IO, "no pipe: %s", strerror(errno));
    if (pipe2(out, O_CLOEXEC)) {
        close(in[0]), close(in[1]);
        return brick_fail(err, BRICK_ERR_IO, "no pipe: %s", strerror(errno));
    }
    signal(SIGPIPE, SIG_IGN);
    int failed = spawn(peer, under_x, in[0], out[1]);
    if (failed == ENOENT)
        failed = spawn(peer, under_x + 2, in[0], out[1]);
    close(in[0]), close(out[1]);
    peer->to = in[1], peer->from = out[0];
    if (!failed)
        return BRICK_OK;
    peer_stop(peer);
    return brick_fail(err, BRICK_ERR_UNSUPPORTED, "cannot run %s: %s", python, strerror(failed));
}

static int send_line(const struct peer *peer, const char *text, struct brick_error *err)
{
    size_t left = strlen(text);
    while (left) {
        ssize_t n = write(peer->to, text, left);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return brick_fail(err, BRICK_ERR_UNSUPPORTED, "VTK has ended (Debian: python3-vtk9 and xvfb): %s",
                              strerror(errno));
        text += n, left -= (size_t)n;
    }
    return BRICK_OK;
}

static int receive_line(struct peer *peer, struct brick_error *err)
{
    for (size_t n = 0;; n++) {
        if (n + 1 >= peer->room) {
            size_t room = peer->room ? 2 * peer->room : 4096;
            char *line = realloc(peer->line, room);
            if (!line)
                return brick_fail(err, BRICK_ERR_MEMORY, "no memory for an answer of VTK");
            peer->line = line, peer->room = room;
        }
        ssize_t got = read(peer->from, peer->line + n, 1);
        if (got < 0 && errno == EINTR)
            n--;
        else if (got <= 0)
            return brick_fail(err, BRICK_ERR_UNSUPPORTED,
                              "VTK has ended: are python3-vtk9 and xvfb installed (Debian's names)?");
        else if (peer->line[n] == '\n') {
            peer->line[n] = '\0';
            return BRICK_OK;
        }
    }
}

int peer_ask(struct peer *peer, struct cJSON *question, struct cJSON **answer, struct brick_error *err)
{
    char *text = cJSON_PrintUnformatted(question);
    cJSON_Delete(question);
    *answer = NULL;
    if (!text)
        return brick_fail(err, BRICK_ERR_MEMORY, "no memory for a question to VTK");
    int code = send_line(peer, text, err);
    free(text);
    if (!code)
        code = send_line(peer, "\n", err);
    if (!code)
        code = receive_line(peer, err);
    if (!code && !(*answer = cJSON_Parse(peer->line)))
        code = brick_fail(err, BRICK_ERR_FORMAT, "VTK's answer is no JSON: %.100s", peer->line);
    return code;
}

void peer_stop(struct peer *peer)
{
    if (peer->to >= 0)
        close(peer->to);
    if (peer->from >= 0)
        close(peer->from);
    if (peer->pid > 0)
        while (waitpid(peer->pid, NULL, 0) < 0 && errno == EINTR)
            ;
    free(peer->line);
    *peer = (struct peer){.to = -1, .from = -1};
}
