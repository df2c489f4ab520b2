/* Parts of the adaptive Radau method: radau.c, its steps, and radau_error.c, their error. */
#ifndef PK_RADAU_H
#define PK_RADAU_H

#include "gauss.h"

/* The work behind that of the stages. */
struct pk_radau_parts {
    struct pk_band E;
    pk_real *pdot, *dq, *dv, *of_q, *of_v, *x;
    struct pk_radau_kept *kept;
};

struct pk_radau_kept {
    pk_real left; /* the factor between corrections to come and the last one, of the step before */
    pk_real enough;   /* the part of the tolerance that the iteration may leave undone */
    pk_real h, error; /* of the last step accepted */
};

/* What the error of a component is measured in, q and v at the start against those given. */
void pk_radau_tolerances(const struct pk_integrator *it, const struct pk_radau_parts *r,
                         const pk_real *q, const pk_real *v);

/* it->own->error of the stages found. `again`: by the second formula, where the first one rejects.
 */
enum pk_status pk_radau_judge(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int again);

#endif
