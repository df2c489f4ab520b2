/* The adaptive Gauss-Legendre method of 8 stages, order 16, on q'' = a(t, q, q'). Its stages are
 * the SIMD lanes of one kernel. With the accelerations a_j at the stages as unknowns,
 *
 *     V_i = v0 + h sum A_ij a_j,    Q_i = q0 + h c_i v0 + h^2 sum (A^2)_ij a_j
 *     v1 = v0 + h sum b_j a_j,      q1 = q0 + h (v0 + h sum b_j (1 - c_j) a_j)
 *
 * Fixed-point iteration solves these equations: all stages of an iterate are evaluated at once. The
 * first iterate is extrapolated from the polynomial through the a_j of the last step. The iteration
 * ends when its error, by the convergence rate, is below the tolerance. The sums for q1 and v1
 * are compensated.
 *
 * Step size control as in IAS15: the last two Legendre coefficients of the polynomial give their
 * decay rate theta, and the error is h |a| theta^16. The error of the step is estimated as soon as
 * the iterates are accurate enough for these two coefficients, so that a rejected step costs
 * little. Slow convergence limits the step size (it->count.held).
 *
 * This form of the method, in (q, q') and with variable step sizes, is symmetric, but not
 * symplectic if M depends on q; for long runs see gauss1 to gauss8, which are symplectic in (q, p).
 *
 * References: H. Rein, D. S. Spiegel, MNRAS 446 (2015) 1424; M. Antonana, J. Makazaga, A. Murua,
 * Numer. Algorithms 76 (2017) 861; E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, II.4 (4.14) for the first step. Uses the macros of pk/inlined.h. */
#include <pk/methods.h>
#include <pk/step/gauss_stages.h>

#ifndef PK_STEP_GAUSS_H
#define PK_STEP_GAUSS_H
#define PK_GAUSS_METHODS(X) PK_METHODS_GAUSS(PK_NAME_OF, X)

/* These constants were chosen for the least work at a given final error, on pkgen's models. */
#define PK_GAUSS_SAFETY PK_C(0.9)
/* log of the largest accepted error, which is 10 times the tolerance */
#define PK_GAUSS_ACCEPT_LOG PK_C(2.302585092994046)
/* the Legendre coefficient a_7 is resolved if the squared error of the iterate is below 10 a_7^2 */
#define PK_GAUSS_RESOLVED PK_C(10.0)
#define PK_GAUSS_GROW PK_C(3.0)
#define PK_GAUSS_SHRINK PK_C(0.2)
#define PK_GAUSS_RATE PK_C(0.15) /* convergence rate at which the work is least */
#endif

/* Makes one trial step of size y->h. Returns PK_DONE with results in *y, or the failure. */
static PK_INLINE enum pk_status PK_STEPPER(gauss_trial)(struct pk_integrator *it,
                                                        const struct pk_gauss_lanes *w,
                                                        struct pk_gauss_trial *y)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations : 30;
    const int with_v = !(it->problem.system->facts & PK_SEPARABLE);
    int asked = 0;
    y->change2 = 0;
    for (int l = 0; l < PK_GAUSS_S; l++) {
        y->hc[l] = y->h * pk_gauss8_c[l];
        y->t[l] = it->t + y->hc[l];
    }
    PK_TRY(PK_STEPPER(gauss_predict)(it, w, y));
    for (y->count = 0;; y->count++) {
        PK_STEPPER(gauss_stages)(it, w, y, with_v);
        PK_TRY(PK_STEPPER(gauss_evaluate)(it, y->t, w->q, w->v, w->u, w->next_a));
        if (y->count == 0)
            PK_STEPPER(gauss_weights)(it, w, y);
        if (!PK_STEPPER(gauss_compare)(it, w, y))
            return PK_NOT_FINITE;
        const pk_real rate = y->rate, left2 = y->change2 * rate * rate;
        const pk_real round = 16 * PK_EPS * PK_EPS * y->size2;
        const int stalled = y->count > 2 && rate > PK_C(0.5) &&
                            y->change2 <= PK_C(1e8) * PK_EPS * PK_EPS * y->size2;
        const pk_real asked_for = it->options.newton_tol;
        const int close = asked_for > 0 ? y->change2 <= asked_for * asked_for * y->size2
                                        : rate < 1 && left2 <= (1 - rate) * (1 - rate);
        const int done = close || y->change2 <= round || stalled;
        /* d6 and d7: the step is rejected if the square of one of the last two Legendre
         * coefficients is larger. They are compared once the iterates are more exact than these. */
        const pk_real d = *w->decay, d6 = (d * d * d) * (d * d * d) * y->size2, d7 = d6 * d;
        if (done || (!asked && left2 < PK_GAUSS_RESOLVED * d7)) {
            pk_real six2, seven2;
            PK_STEPPER(gauss_coefficients)(it, w, &six2, &seven2);
            asked = 1;
            if (done || six2 > d6 || seven2 > d7) {
                pk_gauss_judge(y, six2, seven2);
                if (done || y->error_log > PK_GAUSS_ACCEPT_LOG)
                    return PK_DONE;
            }
        }
        if (y->count >= most || (y->count >= 3 && rate > PK_C(0.7))) {
            it->reason.kind = 0;
            it->reason.value = PK_F(sqrt)(y->change2 / (y->size2 + PK_TINY));
            return PK_NO_CONVERGENCE;
        }
    }
}

/* Writes the new state, and the polynomial that predicts the next step. */
static inline void PK_STEPPER(gauss_accept)(struct pk_integrator *it,
                                            const struct pk_gauss_lanes *w,
                                            const struct pk_gauss_trial *y)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V);
    pk_real *low_q = pk_next(it, PK_LOW_Q), *low_v = pk_next(it, PK_LOW_X);
    const pk_real *old_q = pk_state(it, PK_LOW_Q), *old_v = pk_state(it, PK_LOW_X);
    pk_real hb[PK_GAUSS_S], left[PK_GAUSS_S];
    for (int l = 0; l < PK_GAUSS_S; l++) {
        hb[l] = y->h * pk_gauss8_b[l];
        left[l] = hb[l] * (1 - pk_gauss8_c[l]);
    }
    for (size_t i = 0; i < n; i++) {
        const pk_real *ai = w->a + i * PK_GAUSS_S;
        if (i < n_q) {
            low_q[i] = old_q[i];
            w->start[i] = it->q[i];
            q[i] = pk_sum(it->q[i], y->h * (it->v[i] + (old_v[i] + pk_gauss_dot(left, ai))),
                          &low_q[i]);
        }
        low_v[i] = old_v[i];
        w->start[n_q + i] = it->v[i];
        w->last_weight[i] = w->weight[i];
        v[i] = pk_sum(it->v[i], pk_gauss_dot(hb, ai), &low_v[i]);
        pk_gauss_rows(w->M->taylor, ai, w->poly + i * PK_GAUSS_S);
    }
    *w->h = y->h;
    *w->rate = y->rate;
    *w->decay = PK_F(exp)(2 * (y->theta_log + (PK_GAUSS_ACCEPT_LOG - y->error_log) / 16));
}

static PK_INLINE enum pk_status PK_STEPPER(gauss)(struct pk_integrator *it, pk_real limit)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, n_q, n, it->own->work);
    struct pk_gauss_trial y;

    if (!(it->own->h > 0) && !(it->own->h < 0)) {
        it->own->flags = 0; /* first step, or new direction: no prediction */
        PK_TRY(PK_STEPPER(acceleration)(it, it->t, it->q, it->v, pk_next(it, PK_A)));
        if (!pk_all_finite(pk_next(it, PK_A), n))
            return PK_NOT_FINITE;
        it->own->h = pk_direction(it) * pk_first_step(it, pk_next(it, PK_A), PK_C(0.1), limit);
        *w.decay = 0;
    }
    struct pk_trial x = pk_trial(it, limit);
    for (;;) {
        if (!pk_trial_next(it, limit, &x))
            return pk_underflow(it, x.planned);
        y.h = x.h;
        const enum pk_status status = PK_STEPPER(gauss_trial)(it, &w, &y);
        if (status >= 0 && y.error_log <= PK_GAUSS_ACCEPT_LOG)
            break;
        if (status < 0) {
            if (status != PK_NO_CONVERGENCE) /* the step is merely too long */
                pk_trouble(it, status, it->own->next_t);
            y.growth = PK_C(0.5);
        } else {
            y.growth = pk_max(PK_GAUSS_SHRINK, pk_min(PK_C(0.9), PK_GAUSS_SAFETY * y.growth));
        }
        pk_trial_reject(it, &x, pk_abs(y.h) * y.growth);
    }
    PK_STEPPER(gauss_accept)(it, &w, &y);
    /* The next step size by the error, or less if the iteration converges slowly. */
    pk_real grow = PK_GAUSS_SAFETY * pk_min(y.growth, PK_GAUSS_GROW);
    const pk_real slow = y.count > 0 ? PK_F(sqrt)(PK_GAUSS_RATE / y.rate) : PK_GAUSS_GROW;
    if (x.rejected)
        grow = pk_min(grow, 1);
    if (slow < grow) {
        grow = pk_max(slow, PK_GAUSS_SHRINK);
        it->count.held++;
    }
    const pk_real g2 = y.growth * y.growth, g4 = g2 * g2, g8 = g4 * g4; /* growth = error^(-1/17) */
    it->own->error = 1 / (g8 * g8 * y.growth + PK_TINY);
    pk_trial_accept(it, &x, pk_abs(y.h) * grow, y.growth >= PK_GAUSS_GROW);
    it->own->flags = PK_HAVE_STEP;
    return PK_DONE;
}
