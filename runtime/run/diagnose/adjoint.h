/* Backwards through one step; see adjoint.c. */
#ifndef RUN_DIAGNOSE_ADJOINT_H
#define RUN_DIAGNOSE_ADJOINT_H

#include "../../src/core/internal.h"
#include "tape.h"

struct adjoint_stages;

struct adjoint {
    struct pk_run *run;
    const struct pk_system *system;
    const struct pk_jacobian *kernel;
    struct differences *d;         /* the params and the inputs of the step */
    struct adjoint_stages *stages; /* of an implicit Runge-Kutta method, or NULL */
    size_t n, n_q, m;              /* m: inputs and parameters */
    pk_real *lambda;               /* q, v, inputs and parameters */
    pk_real *q, *k, *l, *moving, *M, *bars;
    enum pk_status status;
    size_t begin, end;
    double *out;
    int shifts;
};

/* Factors M at y = (q, v) for adjoint_sweep(). */
static inline void adjoint_mass(struct adjoint *x, pk_real t, const pk_real *y)
{
    x->system->mass(x->d->params, t, y, y + x->n, x->d->u, x->M);
    if (pk_ldl_factor(x->M, x->n))
        x->status = PK_SINGULAR_MASS;
}

/* Writes mu.r_d, by (q, v, t, inputs, parameters), to x->bars, where a is the acceleration at y =
 * (q, v), and M mu = l, of n numbers. */
static inline void adjoint_sweep(struct adjoint *x, pk_real t, const pk_real *y, const pk_real *a,
                                 const pk_real *l)
{
    const size_t n = x->n;
    pk_copy(x->moving, a, n);
    pk_copy(x->moving + n, l, n);
    pk_ldl_solve(x->M, n, x->moving + n);
    x->kernel->moving(x->d->params, t, y, y + n, x->d->u, x->moving, x->bars);
}

/* Makes x->stages, unless the method is no implicit Runge-Kutta method, or has too many unknowns. */
void adjoint_implicit_make(struct adjoint *x);
/* Goes backwards through step k of the tape. */
enum pk_status adjoint_implicit(struct adjoint *x, size_t k);

#endif
