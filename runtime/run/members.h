/* A batch of an ensemble's members: parameters, starts and inputs, and room for their rows. */
#ifndef RUN_MEMBERS_H
#define RUN_MEMBERS_H

#include "output.h"

struct batch {
    struct pk_ensemble e;
    const struct settings *s;
    const struct pk_system *system;
    size_t n, size; /* members that it has room for */
    char *params;
    pk_real *q0, *v0, *z0, *u, *t; /* z0: NULL without quadratures */
    double *values; /* of the file */
    unsigned char *given;
    void *block;
    size_t block_size, threads;
    FILE *file;
};

/* Room for as many members as fit, or the end of the process. */
void members_allocate(struct batch *b, struct run *run, size_t rows, int (*stop)(void *context));
void members_release(struct batch *b, struct run *run);
/* The next `count` members of the file, of which `first` is the first; else the exit code. */
int members_read(struct batch *b, size_t first, size_t count);
/* Every member once, without running: a parameter out of bounds shows before the first row. */
int members_check(struct batch *b);

#endif
