/* What every step is made of, in the core and where pkgen compiles a step together with a model's
 * kernels: round-off, the layout of a state, the compensated sum, failures by their names.
 * Not for programs that only integrate.
 */
#ifndef PK_STEP_STATE_H
#define PK_STEP_STATE_H

#include <float.h>

#include <pk/integrator.h>

#define PK_EPS PK_EPSILON
#if defined PK_FLOAT
#define PK_TINY FLT_MIN
#elif defined PK_LONG_DOUBLE
#define PK_TINY LDBL_MIN
#elif defined PK_FLOAT128
#define PK_TINY FLT128_MIN
#else
#define PK_TINY DBL_MIN
#endif

/* Parts of it->state and of it->next, n numbers each: q, v, p, the compensations (low parts) of
 * q and of v or p, and an acceleration that belongs to this state and may be reused. */
enum { PK_Q, PK_V, PK_P, PK_LOW_Q, PK_LOW_X, PK_A, PK_PARTS };

/* it->flags */
enum {
    PK_HAVE_A = 1,
    PK_HAVE_LU = 2,
    PK_HAVE_STEP = 4,
    PK_HAVE_DENSE = 8,
    PK_REFRESH = 16,
    PK_HAVE_SERIES = 32
};

static inline pk_real *pk_part(pk_real *state, size_t n, int part)
{
    return state + (size_t)part * n;
}

static inline pk_real pk_max(pk_real a, pk_real b) { return a > b ? a : b; }
static inline pk_real pk_min(pk_real a, pk_real b) { return a < b ? a : b; }
static inline pk_real pk_abs(pk_real a) { return PK_F(fabs)(a); }

/* it->atol for a step of length h: rounding of forces counts over the step that is tried. */
void pk_scale_attempt(const struct pk_integrator *it, pk_real h);

/* What number i of q and v, which goes from a to b, may err by. */
static inline pk_real pk_tolerance(const struct pk_integrator *it, size_t i, pk_real a, pk_real b)
{
    return it->atol[i] + it->options.rtol * pk_max(pk_abs(a), pk_abs(b)) + PK_TINY;
}

/* For a guess of the first step, which is no longer for it: what is zero and has shown no scale. */
static inline pk_real pk_scale_shown(pk_real tolerance)
{
    return tolerance > PK_C(1e6) * PK_F(sqrt)(PK_TINY) ? tolerance : PK_INFINITY;
}

/* x - x is 0 for finite x alone; works for every scalar type, as isfinite() does not. */
static inline int pk_finite(pk_real x) { return x - x == PK_C(0.0); }

int pk_all_finite(const pk_real *x, size_t count);

/* x + low + d, rounded once, and its new low part: Knuth's two-sum, exact also where |d| > |x|.
 * Compensated summation after Kahan (1965), Babuska, Neumaier (1974). */
static inline pk_real pk_sum(pk_real x, pk_real d, pk_real *low)
{
    const pk_real y = d + *low;
    const pk_real sum = x + y;
    const pk_real back = sum - x;
    *low = (x - (sum - back)) + (y - back);
    return sum;
}

/* The inputs at t, in it->u. */
const pk_real *pk_eval_input(struct pk_integrator *it, pk_real t);
/* The status of an acceleration that returned `failed`, with the coordinate and the time. */
enum pk_status pk_eval_failed(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, int failed);
/* system->lanes(), or lane by lane where the system has none. */
unsigned long long pk_eval_lanes(struct pk_integrator *it, const pk_real *t, const pk_real *q,
                                 const pk_real *v, const pk_real *u, pk_real *a);
/* A trial step up to t broke down. */
static inline void pk_trouble(struct pk_integrator *it, enum pk_status status, pk_real t)
{
    it->trouble = status;
    it->trouble_t = t;
    it->trouble_where = it->where;
    it->trouble_condition = it->condition;
}
/* The status of an adaptive method whose step h became too small, with its cause if known. */
enum pk_status pk_underflow(struct pk_integrator *it, pk_real h);

#endif
