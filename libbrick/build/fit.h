/* What payloads without a place could be, judged by the bricks that are known. */
#ifndef BRICK_BUILD_FIT_H
#define BRICK_BUILD_FIT_H

#include "salvage.h"

enum { FIT_FACES = 6 };

/* A payload, decoded as a brick of some shape. */
struct piece {
    uint64_t start, bytes;
    bool tried, whole, complete;
    struct brick_place place; /* whose shape was tried */
    struct brick_entry entry;
    struct agree_face face[FIT_FACES];
};

/* What is known while payloads are being placed. */
struct fit {
    struct salvage *s;
    const struct brick_grid *grid;
    struct agree_face *face; /* FIT_FACES of each known brick: 2 * axis + high */
    enum brick_codec codec[2];
    int codecs;
    uint64_t *start; /* of payloads, ascending, as far as their lengths tell, and the end; NULL: codec none */
    uint64_t starts;
    struct piece piece;
    uint64_t decoded, decode_most; /* payloads: how often that was done, and may be */
    uint64_t *journal, set;        /* bricks found, in the order of finding */
    uint64_t parent;               /* whose payload `above` holds */
    unsigned char *above, *stored;
    size_t stored_bytes;
    uint64_t passed[2]; /* bricks [.., ..) not known are constant, if the payload belongs where it is tried */
};

bool fit_known(const struct fit *fit, uint64_t id);
/* Faces of a worker's decoded brick. */
void fit_faces_of(const struct fit *fit, struct salvage_worker *worker, const struct brick_place *place,
                  struct agree_face face[FIT_FACES]);
/* Decode the payload at [start, start + bytes) as a brick of this shape: fit->piece. */
void fit_try(struct fit *fit, uint64_t start, uint64_t bytes, const struct brick_place *place);
/* Could the payload be this brick's? */
bool fit_payload(struct fit *fit, uint64_t start, uint64_t bytes, const struct brick_place *place);
/* Could a brick be constant? *sure: its value is known. */
bool fit_constant(struct fit *fit, const struct brick_place *place, bool *sure, unsigned char value[8]);

/* The brick is fit->piece. */
void fit_set_piece(struct fit *fit, uint64_t id);
/* The brick has no payload, if its value is known. */
void fit_set_constant(struct fit *fit, uint64_t id);
/* Forget all but the first `to` bricks that were set. */
void fit_take_back(struct fit *fit, uint64_t to);

#endif
