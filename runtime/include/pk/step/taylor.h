/* The Taylor method: a step evaluates the Taylor polynomial of the motion, whose coefficients the
 * kernel `jet` computes. The polynomial is also the dense output. The order is 1 - ln(rtol)/2, with
 * which the work per unit of time is least, or higher. The step size h follows from the last three
 * coefficients x_k, k = p - 2, p - 1, p, and the tolerances d. At a step of r times the radius of
 * convergence they are as 1/r^2 : 1/r : 1, and r = rtol^(1/p) is expected:
 *
 *     |x_k| h_k^k r^(p - k) = d/e^2,   h = exp(-0.7/(p - 1)) min(h_k)
 *
 * A step is never repeated for its error. The first coefficient is added last, by a compensated
 * sum, so that rounding errors of the energy grow as a random walk does. This file has the code
 * that each step runs, with the macros of pk/inlined.h.
 *
 * Reference: A. Jorba, M. Zou, Experimental Mathematics 14 (2005), pages 99-117. */
#ifndef PK_STEP_TAYLOR_H
#define PK_STEP_TAYLOR_H

#include <stdint.h>
#include <string.h>

#include <pk/methods.h>
#include <pk/step/state.h>

#define PK_TAYLOR_METHODS(X) PK_METHODS_TAYLOR(PK_NAME_OF, X)

enum { PK_TAYLOR_LAST = 3 }; /* the number of coefficients that the step size follows from */
#define PK_TAYLOR_MARGIN PK_C(2.885390) /* log2 of e^2 */

/* The work memory: the order, log2 r, then the coefficients, m = n_q + n numbers for each order. */
static inline int pk_taylor_order(const struct pk_integrator *it) { return (int)it->own->work[0]; }
static inline pk_real *pk_taylor_c(const struct pk_integrator *it) { return it->own->work + 2; }

/* Returns the logarithm to base 2 of x > 0, wrong by at most 0.01; for x = 0, or tiny x, a number
 * below -1000. */
static inline pk_real pk_coarse_log2(pk_real x)
{
#if !defined PK_FLOAT && !defined PK_LONG_DOUBLE && !defined PK_FLOAT128
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const double e = (double)((int)(bits >> 52) - 1022);
    bits = (bits & 0xfffffffffffffu) | 0x3fe0000000000000u;
    double m;
    memcpy(&m, &bits, sizeof m);
#else
    int exponent;
    const pk_real m = PK_F(frexp)(x, &exponent), e = x > 0 ? (pk_real)exponent : PK_C(-1e4);
#endif
    return e + ((PK_C(-1.379394) * m + PK_C(4.049332)) * m - PK_C(2.674878));
}

/* Returns 2^x, wrong by at most 0.2 %, for |x| <= 1000. */
static inline pk_real pk_coarse_exp2(pk_real x)
{
    const pk_real whole = PK_F(floor)(x), f = x - whole;
    const pk_real m = (PK_C(0.337189) * f + PK_C(0.657636)) * f + PK_C(1.001725);
#if !defined PK_FLOAT && !defined PK_LONG_DOUBLE && !defined PK_FLOAT128
    const uint64_t bits = (uint64_t)((int)whole + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return m * power;
#else
    return PK_F(ldexp)(m, (int)whole);
#endif
}

/* Returns the step size by the coefficients, or 0 if they are not finite. */
static PK_INLINE pk_real pk_taylor_reach(const struct pk_integrator *it, const pk_real *c,
                                         int order, size_t m)
{
    const pk_real *last = c + (size_t)order * m, p = (pk_real)order, log_r = it->own->work[1];
    pk_real most[PK_TAYLOR_LAST] = {0}, sum = 0, x = PK_C(-1e4);
    for (size_t i = 0; i < m; i++) {
        const pk_real scale = 1 / pk_tolerance(it, i, c[i], c[i]);
        for (size_t j = 0; j < PK_TAYLOR_LAST; j++) {
            const pk_real y = pk_abs(*(last - j * m + i)) * scale;
            most[j] = pk_max(most[j], y);
            sum += y;
        }
    }
    if (!pk_finite(sum))
        return 0;
    for (int j = 0; j < PK_TAYLOR_LAST; j++)
        x = pk_max(x, (pk_coarse_log2(most[j]) + PK_TAYLOR_MARGIN + (pk_real)j * log_r) /
                          (p - (pk_real)j));
    return pk_coarse_exp2(pk_min(PK_C(1000.0), -x - 1 / (p - 1)));
}

/* Returns a b + c, by one instruction where the processor has it. */
static PK_INLINE pk_real pk_taylor_add(pk_real a, pk_real b, pk_real c)
{
#if defined PK_PORTABLE || defined PK_LONG_DOUBLE || defined PK_FLOAT128 || !defined FP_FAST_FMA
    return a * b + c;
#else
    return PK_F(fma)(a, b, c);
#endif
}

/* Returns number i of the polynomial, without its coefficient 0, at the time s after the start. The
 * terms of odd and of even orders are two sums, which a processor adds up side by side. Vectors of
 * several i would be slower: they would wait for coefficients that were just stored one by one. */
static PK_INLINE pk_real pk_taylor_tail(const pk_real *c, size_t m, int order, pk_real s, size_t i)
{
    const pk_real s2 = s * s, *at = c + (size_t)order * m + i;
    pk_real even = 0, odd = 0;
    if (order % 2) {
        odd = *at;
        at -= m;
    }
    for (int k = order / 2; k > 0; k--, at -= 2 * m) {
        even = pk_taylor_add(s2, even, at[0]);
        odd = pk_taylor_add(s2, odd, *(at - m));
    }
    return s2 * even + s * odd;
}

#endif

/* Computes the coefficients at the start of a step, and the planned step size. */
static PK_INLINE enum pk_status PK_STEPPER(jets)(struct pk_integrator *it, pk_real *c, int order,
                                                 size_t m, pk_real limit)
{
    const pk_real *q = it->own->state, *v = q + PK_STEPPER_COORDINATES(it);
    it->count.evaluations += (unsigned long)order;
    if (pk_ahead_serves(it->own->ahead, it->t, 0, it->t)) {
        const size_t count = ((size_t)order + 1) * m, lanes = it->own->ahead->lanes;
        for (size_t i = 0; i < count; i++)
            c[i] = it->own->ahead->slopes[i * lanes];
    } else {
        const int failed = PK_STEPPER_JET(it, it->t, q, v, it->own->u, order, c);
        if (failed)
            return pk_eval_failed(it, it->t, q, v, failed);
    }
    pk_real h = pk_taylor_reach(it, c, order, m);
    if (!(h > 0))
        return PK_NOT_FINITE;
    h = pk_min(h, 2 * pk_abs(limit - it->t));
    if (it->options.h > 0 && !(pk_abs(it->own->h) > 0))
        h = pk_min(h, it->options.h);
    it->own->h = pk_direction(it) * h;
    return PK_DONE;
}

static PK_INLINE enum pk_status PK_STEPPER(taylor_step)(struct pk_integrator *it, pk_real limit)
{
    const int order = pk_taylor_order(it);
    pk_real *c = pk_taylor_c(it);
    const size_t m = PK_STEPPER_COORDINATES(it) + PK_STEPPER_N(it);
    const pk_real *from = it->own->state, *rest = pk_state(it, PK_LOW_Q);
    pk_real *to = it->own->next, *to_rest = pk_next(it, PK_LOW_Q);
    it->own->flags = 0; /* the last step's dense output becomes invalid */
    PK_TRY(PK_STEPPER(jets)(it, c, order, m, limit));
    struct pk_trial x = pk_trial(it, limit);
    if (!pk_trial_next(it, limit, &x))
        return pk_underflow(it, x.planned);
    for (size_t i = 0; i < m; i++) { /* PK_Q and PK_V are adjacent, as their low parts are */
        to_rest[i] = rest[i];
        to[i] = pk_sum(from[i], pk_taylor_tail(c, m, order, x.h, i), &to_rest[i]);
    }
    if (!pk_all_finite(to, m))
        return PK_NOT_FINITE;
    pk_trial_accept(it, &x, pk_abs(x.h), 1);
    it->own->flags = PK_HAVE_STEP;
    return PK_DONE;
}
