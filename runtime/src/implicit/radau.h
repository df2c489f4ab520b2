/* The adaptive Radau method: its steps (radau.c) and their error (radau_error.c). */
#ifndef PK_RADAU_H
#define PK_RADAU_H

#include "gauss.h"

/* Work arrays behind those of the stages. */
struct pk_radau_parts {
    struct pk_band E;
    pk_real *pdot, *dq, *dv, *of_q, *of_v, *x;
    struct pk_radau_kept *kept;
};

struct pk_radau_kept {
    pk_real left; /* sum of the corrections to come over the last one, in the last step */
    pk_real enough;   /* fraction of the tolerance at which the iteration ends */
    pk_real h, error; /* of the last step accepted */
};

/* Sets the tolerance of each component, r->of_q and r->of_v, from the larger of q and v at the
 * start and those given. */
void pk_radau_tolerances(const struct pk_integrator *it, const struct pk_radau_parts *r,
                         const pk_real *q, const pk_real *v);

/* Sets it->own->error of the stages found. `again`: by the second formula if the first one
 * rejects. */
enum pk_status pk_radau_judge(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int again);

#endif
