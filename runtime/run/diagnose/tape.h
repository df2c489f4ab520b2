/* The steps of a run, kept for its derivatives. */
#ifndef RUN_DIAGNOSE_TAPE_H
#define RUN_DIAGNOSE_TAPE_H

#include "motion.h"

/* A row of the tape, of `width` numbers: t0, t1, the mark of pk_run_tape(), q0, v0, q1, v1, the
 * inputs, and, not in the caller's copy, the sides of switches. */
enum { TAPE_T0, TAPE_T1, TAPE_MARK, TAPE_STATE };

/* Repeats steps of the tape with other starts, by the run's own method; see differences.c. */
struct differences {
    struct pk_run *run;
    struct pk_problem problem;
    struct pk_integrator it; /* must be freed */
    struct pk_constant_input input;
    size_t n, n_q, size; /* size: that of the block */
    int measured;        /* whether `scale` is known */
    void *params, *block;
    pk_real *q, *v, *u, *scale, *found;
};

struct tape {
    pk_real *rows, *now; /* `now`: the row of the next step */
    size_t count, room, width, n_sides;
    int caught; /* whether a crossing in this step has set its end */
    struct differences differences;
};

/* The numbers of row k. */
static inline const pk_real *tape_row(const struct tape *tape, size_t k)
{
    return tape->rows + k * tape->width;
}

/* Returns whether a step to t ends at a given time, as adaptive and shortened steps do. Other steps
 * have a given length: their ends shift with their starts. */
int tape_is_cut(const struct pk_run *run, const pk_real *row, pk_real t);

/* A displacement of a step. */
struct shift {
    const double *D; /* dq and dv of its start (n numbers each), inputs, parameters; NULL: none */
    pk_real t0, t1;  /* shifts of its start and its end */
    int jumps;       /* the jump at the end of the step is differentiated, not the step */
};

void differences_make(struct differences *d, struct pk_run *run);
/* Returns the options of one step of length h, whatever its error, of the run's method. */
struct pk_options differences_options(const struct pk_run *run, pk_real h);
/* Sets d->params, d->u, and (d->q, d->v) to those of a row: its equations and its start. */
void differences_place(struct differences *d, const pk_real *row);
/* Writes the derivative of the end of step `row`, which is at t, along a displacement: n numbers of
 * q and n of v; of a jump the inputs too. PK_NO_CONTACT: neighbours keep other contacts. */
enum pk_status differences_find(struct differences *d, size_t row, pk_real t,
                                const struct shift *shift, double *out);
/* Makes the step from row's start to t without displacement. The result is d->q and d->v. */
enum pk_status differences_step(struct differences *d, size_t row, pk_real t);

#endif
