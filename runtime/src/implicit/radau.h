/* The adaptive Radau method: its steps (radau.c) and their error (radau_error.c). */
#ifndef PK_RADAU_H
#define PK_RADAU_H

#include "gauss.h"

/* Work arrays of the Radau method, which follow those of the stages. */
struct pk_radau_parts {
    struct pk_band E;
    pk_real *pdot, *dq, *dv, *of_q, *of_v, *x;
    struct pk_radau_kept *kept;
};

struct pk_radau_kept {
    pk_real left;     /* sum of the omitted corrections of the last step / its last correction */
    pk_real enough;   /* fraction of the tolerance at which Newton's iteration ends */
    pk_real h, error; /* size and error of the last accepted step */
};

/* Sets the tolerances r->of_q and r->of_v of all components. Each is computed from the larger of
 * the given value in (q, v) and the value at the start of the step. */
void pk_radau_tolerances(const struct pk_integrator *it, const struct pk_radau_parts *r,
                         const pk_real *q, const pk_real *v);

/* Computes it->own->error from the solved stages. If this error exceeds 1 and `again` is nonzero,
 * computes it once more by the second formula of radau_error.c. */
enum pk_status pk_radau_judge(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int again);

#endif
