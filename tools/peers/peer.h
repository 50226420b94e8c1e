/* Another program that draws the same scene: VTK, in a Python process, asked line by line. */
#ifndef TOOLS_PEERS_PEER_H
#define TOOLS_PEERS_PEER_H

#include <stddef.h>

#include <brick/error.h>

struct cJSON;

struct peer {
    int to, from; /* pipes; -1 when closed */
    int pid;
    char *line; /* the last answer */
    size_t room;
};

/* Start `python -c script` under an X server of its own where xvfb-run is installed. BRICK_ERR_UNSUPPORTED
 * when that cannot be done. */
int peer_start(struct peer *peer, const char *python, const char *script, struct brick_error *err);
/* Send an object, which is deleted, as one line, and wait for one line of JSON: *answer is the caller's to
 * delete. */
int peer_ask(struct peer *peer, struct cJSON *question, struct cJSON **answer, struct brick_error *err);
/* Ends the process by closing its stdin. A peer that was not started has to and from -1. */
void peer_stop(struct peer *peer);

#endif
