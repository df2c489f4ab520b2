/* The file of a checkpoint: a head, the caller's note, and bytes (docs/dev/checkpoints.md). */
#ifndef RUN_CHECKPOINT_H
#define RUN_CHECKPOINT_H

#include "state.h"

/* Writes the file; an older file at `path` stays until the new one is complete. 0, or errno. */
int checkpoint_store(struct memory *memory, const char *path, const char *note,
                     const unsigned char *bytes, size_t size);
/* Returns the bytes and sets *size; NULL, with the reason in *why, if it cannot be used. */
const unsigned char *checkpoint_load(struct memory *memory, const char *path, size_t *size,
                                     const char **why);
/* CRC-32 continued over `size` more bytes; `before` is the sum so far, 0 at first. */
uint32_t checkpoint_sum(uint32_t before, const void *bytes, size_t size);

/* The end of the rows in their file, where a resumed run cuts it; `whole` 0: it cannot be cut. */
struct place {
    uint64_t whole, at, tail; /* `at`: bytes before the next row */
    uint64_t sum;             /* CRC-32 of the last `tail` bytes before it */
};
struct place checkpoint_place(FILE *out);
/* Cuts the file there. Returns NULL, or why it cannot. An empty file is left as it is. */
const char *checkpoint_cut(FILE *out, const struct place *place);

#endif
