/* The file of a checkpoint: header, caller's note, saved state (docs/dev/checkpoints.md). */
#ifndef RUN_CHECKPOINT_H
#define RUN_CHECKPOINT_H

#include "state.h"

/* Writes the file; an older file at `path` stays until it is complete. Returns 0 or errno. */
int checkpoint_store(struct memory *memory, const char *path, const char *note,
                     const unsigned char *bytes, size_t size);
/* Returns the saved state and sets *size to its size. If the checkpoint cannot be used, returns
 * NULL and sets *why to the reason. */
const unsigned char *checkpoint_load(struct memory *memory, const char *path, size_t *size,
                                     const char **why);
/* Returns the CRC-32 continued over `size` more bytes; `before` is the CRC so far, 0 at first. */
uint32_t checkpoint_sum(uint32_t before, const void *bytes, size_t size);

/* The end of the rows in the file to which they are written. A resumed run truncates the file at
 * this place, unless `whole` is 0. */
struct place {
    uint64_t whole, at, tail; /* `at`: offset of the end of the rows in bytes */
    uint64_t sum;             /* CRC-32 of the last `tail` bytes before `at` */
};
struct place checkpoint_place(FILE *out);
/* Truncates the file of the rows at `place`; leaves an empty file as it is. Returns NULL, or a text
 * that says why truncating fails. */
const char *checkpoint_cut(FILE *out, const struct place *place);

#endif
