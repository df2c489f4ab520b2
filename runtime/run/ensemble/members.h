/* A batch of an ensemble's members: parameters, starts and inputs, and room for their rows. */
#ifndef RUN_MEMBERS_H
#define RUN_MEMBERS_H

#include "../base/state.h"

struct batch {
    struct pk_ensemble e;
    const struct settings *s;
    const struct pk_system *system;
    size_t n, size; /* members that it has room for */
    char *params;
    pk_real *q0, *v0, *z0, *u, *t; /* z0: NULL without quadratures */
    unsigned char *given;
    void *block;
    size_t block_size, threads;
};

/* Room for as many members as fit. */
void members_allocate(struct batch *b, struct run *run, size_t rows);
/* The next `count` members, of which `first` is the first. */
enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct run *run);
/* Every member once, without running: a parameter out of bounds shows before the first row. */
enum pk_run_code members_check(struct batch *b, struct run *run);

#endif
