/* The file of a checkpoint: a head, a note of who runs, and bytes (docs/dev/checkpoints.md). */
#ifndef RUN_CHECKPOINT_H
#define RUN_CHECKPOINT_H

#include "state.h"

/* In place of the one that was there, which stays until this one is whole: 0, or what errno says. */
int checkpoint_store(struct memory *memory, const char *path, const char *note,
                     const unsigned char *bytes, size_t size);
/* Its bytes and how many, or NULL and why not. */
const unsigned char *checkpoint_load(struct memory *memory, const char *path, size_t *size,
                                     const char **why);
/* CRC-32, of what came before and so many bytes more; 0 at first. */
uint32_t checkpoint_sum(uint32_t before, const void *bytes, size_t size);

/* Where rows stand in their file, so that it can be cut there; `whole` 0: it is none that can. */
struct place {
    uint64_t whole, at, tail; /* bytes before the next row, and so many of them, */
    uint64_t sum;             /* the last ones, summed */
};
struct place checkpoint_place(FILE *out);
/* Cuts the file there: 0, or why not. A file that is empty goes on as it is. */
const char *checkpoint_cut(FILE *out, const struct place *place);

#endif
