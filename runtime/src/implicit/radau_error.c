/* The error estimate of a step of adaptive Radau, of order 3, as in RADAU5. With gamma the real
 * eigenvalue of the method's matrix A, f = (v, pdot), J the derivative of f by y = (q, p), z_i =
 * (stage i) - y0, and constants e_i, the estimate err solves
 *
 *     (I - h gamma J) err = gamma h f(y0) + e1 z1 + e2 z2 + e3 z3,
 *
 * If err would reject the first step or a step after a rejection, this equation is solved again
 * with f(y0 + err) in place of f(y0). For y = (q, p) this is one system of n equations for the
 * error of v, M dv + (dp/dq) dq = dp; tolerances are on q and v. Like RADAU5 this replaces rtol by
 * .1 rtol^(2/3) and scales atol alike, since the result has order 5 and the estimate order 3: the
 * error is then proportional to rtol.
 *
 * Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8,
 * (8.17)-(8.25), and the code RADAU5. */

#include "radau.h"

#define GAMMA PK_C(0.27488882959567736774782860359941478)
#define SQRT6 PK_C(2.4494897427831780981972840747058914)

static const pk_real E_OF_STAGE[] = {GAMMA * (-13 - 7 * SQRT6) / 3, GAMMA * (-13 + 7 * SQRT6) / 3,
                                     -GAMMA / 3};

void pk_radau_tolerances(const struct pk_integrator *it, const struct pk_radau_parts *r,
                         const pk_real *q, const pk_real *v)
{
    const struct pk_options *o = &it->options;
    const pk_real rtol = pk_max(o->rtol, 10 * PK_EPS);
    const pk_real factor = o->rtol > 0 ? PK_C(0.1) / PK_F(cbrt)(rtol) : 1; /* as in RADAU5 */
    /* RADAU5 has the same bound: the remaining iteration error has the same sign in each step. */
    r->kept->enough = o->rtol > 0 ? pk_max(10 * PK_EPS / (factor * rtol),
                                           pk_min(PK_C(0.03), PK_F(sqrt)(factor * rtol)))
                                  : PK_C(1e-3);
    const pk_real *of_q = it->own->atol, *of_v = of_q + it->n_q;
    for (size_t k = 0; k < it->n_q; k++)
        r->of_q[k] = factor * (of_q[k] + rtol * pk_max(pk_abs(it->q[k]), pk_abs(q[k]))) + PK_TINY;
    for (size_t k = 0; k < it->n; k++)
        r->of_v[k] = factor * (of_v[k] + rtol * pk_max(pk_abs(it->v[k]), pk_abs(v[k]))) + PK_TINY;
}

/* Solves for err with the right-hand side gamma h f + e.z, f = (v, pdot), into r->dq and r->dv.
 * Returns the root mean square of err relative to the tolerance. */
static pk_real estimate(struct pk_integrator *it, const struct pk_gauss_work *w,
                        const struct pk_radau_parts *r, const pk_real *v, const pk_real *pdot)
{
    const size_t n_q = it->n_q, n = it->n, nn = w->nn;
    const pk_real *J = w->jacobian, *p0 = pk_state(it, PK_P), hg = it->own->h * GAMMA;
    pk_real sum = 0;
    for (size_t k = 0; k < n; k++) {
        pk_real of_q = k < n_q ? hg * v[k] : 0, of_p = hg * pdot[k];
        for (size_t i = 0; i < 3; i++) {
            if (k < n_q)
                of_q += E_OF_STAGE[i] * (w->Q[i * n_q + k] - it->q[k]);
            of_p += E_OF_STAGE[i] * (w->P[i * n + k] - p0[k]);
        }
        r->dq[k] = of_q; /* of_q is 0 for first-order variables */
        r->x[k] = of_p;
    }
    pk_copy(r->dv, r->x, n);
    for (size_t x = 0; x < nn; x++)
        w->M[x] = hg * J[2 * nn + x] - J[nn + x];
    pk_gauss_solve_with(w, w->M, r->dq, &r->E, r->dv);
    for (size_t k = pk_gauss_read(w); k < n; k++) /* errors of quadratures are by others */
        for (size_t i = 0; i < w->places; i++)
            r->dv[k] += hg * (J[3 * nn + k * n + i] + hg * J[2 * nn + k * n + i]) * r->dv[i];
    for (size_t k = 0; k < n; k++) {
        r->dq[k] += k < n_q ? hg * r->dv[k] : 0;
        const pk_real dq = k < n_q ? r->dq[k] / r->of_q[k] : 0, dv = r->dv[k] / r->of_v[k];
        sum += dq * dq + dv * dv;
    }
    return PK_F(sqrt)(sum / (pk_real)(n_q + n));
}

enum pk_status pk_radau_judge(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int again)
{
    const size_t n = it->n;
    pk_real hg = it->own->h * GAMMA, hh = hg * hg;
    struct pk_gauss_work one = *w; /* equations of a method with one stage */
    one.s = 1;
    one.hA = one.hA_p = &hg;
    one.hh = &hh;
    pk_gauss_matrix(&one, w->jacobian, 0, 1, 1, &r->E);
    it->count.factorisations++;
    if (!pk_band_factor(&r->E))
        return PK_NO_CONVERGENCE;
    pk_radau_tolerances(it, r, w->Q + 2 * it->n_q, w->V + 2 * n);
    it->own->error = estimate(it, w, r, it->v, r->pdot);
    if (again && it->own->error >= 1) {
        for (size_t k = 0; k < n; k++) {
            if (k < it->n_q)
                r->dq[k] += it->q[k];
            r->dv[k] += it->v[k];
        }
        pk_eval_canonical(it, it->t, r->dq, r->dv, w->x, w->y);
        pk_copy(w->x, r->dv, n); /* a copy, since estimate() overwrites dv */
        it->own->error = estimate(it, w, r, w->x, w->y);
    }
    return pk_finite(it->own->error) ? PK_DONE : PK_NOT_FINITE;
}
