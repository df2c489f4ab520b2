/* Measures how much rounding of the state changes accelerations, and thus a step. Each number of a
 * state is changed by some units in its last place. This is repeated several times, since a single
 * change may leave some accelerations nearly unchanged. If terms cancel, their rounding is taken
 * relative to their size. */

#include "band.h"
#include "scale.h"

#define ROUNDING (8 * PK_EPS)
#define MORE PK_C(16.0)
#define ASIDE PK_F(sqrt)(PK_EPS)
enum { SAMPLES = 4 };

int pk_scale_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q, pk_real *a)
{
    const struct pk_system *system = it->problem.system;
    const pk_real *u = pk_eval_input(it, t);
    it->count.evaluations++;
    return !system->acceleration(it->problem.params, t, q, q + it->n_q, u, a) &&
           pk_all_finite(a, it->n);
}

/* Returns a pseudo-random sign, by a linear congruential generator. */
static int is_up(unsigned long *random)
{
    *random = (*random * 1103515245ul + 12345ul) & 0x7ffffffful;
    return (*random & 0x40000000ul) != 0;
}

/* Computes the error of v if M v = p is solved for v, M is banded, and p_i has a rounding error r_i
 * proportional to sum_j |M_ij v_j|. The error of v_i is at least r_i/M_ii. It is larger if M is
 * ill-conditioned; therefore M x = +-r is also solved, with random signs. */
static void momenta_of_band(struct pk_integrator *it, struct pk_pattern p, pk_real *M,
                            pk_real *by_p)
{
    const struct pk_part_families *f = &it->problem.system->families;
    const size_t places = p.rows + p.border;
    struct pk_band band = {.rows = p.rows, .below = p.width, .above = p.width, .border = p.border};
    pk_real *x = M + pk_band_lay_out(&band, M), *sum = x + places, *place = sum + places;
    f->mass(it->problem.params, it->t, it->q, it->v, pk_eval_input(it, it->t), M);
    pk_zero(sum, places);
    for (size_t k = 0; k < places; k++) {
        place[k] = (pk_real)f->place(it->problem.params, k);
        x[k] = place[k] < 0 ? 0 : pk_abs(it->v[(size_t)place[k]]);
    }
    pk_band_add_sizes(&band, x, sum);
    for (size_t k = 0; k < places; k++) {
        const pk_real diagonal = *pk_band_entry(&band, k, k);
        sum[k] = place[k] < 0 || !pk_finite(sum[k]) ? 0 : ROUNDING * sum[k];
        if (!(place[k] < 0))
            by_p[(size_t)place[k]] = diagonal > 0 ? sum[k] / diagonal : 0;
    }
    unsigned long random = 1;
    for (int sample = pk_band_ldl_factor(&band, place) ? SAMPLES : 0; sample < SAMPLES; sample++) {
        for (size_t k = 0; k < places; k++)
            x[k] = is_up(&random) ? sum[k] : -sum[k];
        pk_band_ldl_solve(&band, x);
        for (size_t k = 0; k < places; k++)
            if (!(place[k] < 0) && pk_finite(x[k]))
                by_p[(size_t)place[k]] = pk_max(by_p[(size_t)place[k]], pk_abs(x[k]));
    }
}

/* Methods with momenta solve M v = p, so that v has the rounding of p. With constraints v
 * comes from a projection with the tolerance rtol: the error of v_i is then taken as rtol times the
 * sum of |M_ij v_j|, over M_ii, and no equations are solved. */
static void look_at_momenta(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    const size_t n = it->n, held = system->constraints.n;
    const pk_real share = held ? it->options.rtol : ROUNDING;
    pk_real *M = part(it, PARTS), *by_p = part(it, BY_P), *sum = part(it, BESIDE), *x = sum + n;
    const struct pk_pattern pattern = pk_system_pattern(system, it->problem.params);
    if (it->method->traits & PK_JACOBIANS && !pattern.dense)
        momenta_of_band(it, pattern, M, by_p);
    if (!(it->method->traits & PK_JACOBIANS) || !(system->inertia ? system->inertia : system->mass))
        return;
    pk_zero(M, n * n);
    (system->inertia ? system->inertia : system->mass)(it->problem.params, it->t, it->q, it->v,
                                                       pk_eval_input(it, it->t), M);
    pk_zero(x, n);
    if (!held && system->canonical) /* p has terms without v too, as of a moving pivot */
        system->canonical(it->problem.params, it->t, it->q, it->v, it->own->u, x, part(it, MOVED));
    for (size_t i = 0; i < n; i++) {
        sum[i] = 0;
        for (size_t j = 0; j < n; j++)
            sum[i] += pk_abs(M[i * n + j] * it->v[j]);
        sum[i] = pk_max(sum[i], pk_abs(x[i]));
        sum[i] = pk_finite(sum[i]) ? share * sum[i] : 0;
        by_p[i] = M[i * n + i] > 0 ? sum[i] / M[i * n + i] : 0;
    }
    for (size_t i = 0; i < n; i++) /* a first-order variable has no inertia */
        M[i * n + i] = M[i * n + i] > 0 ? M[i * n + i] : 1;
    unsigned long random = 1;
    for (int sample = held || pk_ldl_factor(M, n) ? SAMPLES : 0; sample < SAMPLES; sample++) {
        for (size_t i = 0; i < n; i++)
            x[i] = is_up(&random) ? sum[i] : -sum[i];
        pk_ldl_solve(M, n, x);
        for (size_t i = 0; i < n; i++)
            by_p[i] = pk_finite(x[i]) ? pk_max(by_p[i], pk_abs(x[i])) : by_p[i];
    }
}

/* Multiplies each number of a state by 1 + share or 1 - share, at random. */
static void shake(const struct pk_integrator *it, pk_real share, unsigned long random,
                  pk_real *state)
{
    for (size_t i = 0; i < it->n_q + it->n; i++)
        state[i] *= 1 + (is_up(&random) ? share : -share);
}

/* Changes each number of the state by the relative amount `aside`. Computes the acceleration `a` at
 * this state, and `noise`, the largest changes of the acceleration if the state is also changed by
 * rounding. Returns 0 if an acceleration cannot be computed. */
static int noise_at(struct pk_integrator *it, pk_real aside, pk_real *a, pk_real *noise)
{
    const size_t n = it->n;
    pk_real *moved = part(it, MOVED), *other = part(it, BESIDE);
    pk_zero(noise, n);
    for (int k = 0; k <= SAMPLES; k++) {
        pk_copy(moved, it->own->state, it->n_q + n);
        shake(it, aside, 54321, moved);
        shake(it, k ? ROUNDING : 0, 12345ul * (unsigned long)k, moved);
        const pk_real t = it->t * (1 + aside) * (1 + (k ? ROUNDING : 0));
        if (!pk_scale_acceleration(it, t, moved, k ? other : a))
            return 0;
        for (size_t i = 0; i < n && k; i++)
            noise[i] = pk_max(noise[i], pk_abs(other[i] - a[i]));
    }
    return 1;
}

/* Forces on a body that constraints hold at rest cancel, perhaps exactly, so that the rounding of
 * these forces does not show if the state is changed. So the error of a_k is taken as at least the
 * rounding of the terms (M^-1 J^T)_ki lambda_i, the accelerations by the constraint forces. Rows
 * that hold at times are solved with the others, by an elimination with more roundings. */
static void look_at_rows(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (!system->constraints.multipliers || !it->own->project)
        return;
    struct pk_projection w = pk_projection(it);
    pk_real *noise = part(it, NOISE), *lambda = part(it, BESIDE);
    w.t = it->t;
    w.u = pk_eval_input(it, it->t);
    if (!w.whole || pk_project_inertia(&w, it->q, it->v))
        return;
    pk_project_rows(&w, it->q, it->v);
    if (pk_project_factor(&w, w.c, it->q, it->v))
        return;
    pk_project_rank(&w);
    for (size_t i = 0; i < w.c; i++) /* near a singular position noise_at() is more accurate */
        if (w.sines[i] < PK_NEAR * PK_NEAR)
            return;
    system->constraints.multipliers(w.params, w.t, it->q, it->v, w.u, lambda);
    for (size_t k = 0; k < w.m; k++) {
        pk_real sum = 0;
        for (size_t i = 0; i < w.c; i++)
            sum += pk_abs(w.W[i * w.m + k] * lambda[pk_project_row(&w, i)]);
        sum *= system->contacts.modes ? MORE * ROUNDING : ROUNDING;
        noise[k] = pk_finite(sum) ? pk_max(noise[k], sum) : noise[k];
    }
}

/* Takes the smaller of the noises measured at two nearby states. Where a force starts like sqrt(x),
 * rounding is amplified, but only over a range much shorter than a step, which must not count. */
void pk_scale_look(struct pk_integrator *it)
{
    const size_t n = it->n;
    pk_real *noise = part(it, NOISE), *beside = part(it, BESIDE) + n, *other = beside + n;
    const int valid = noise_at(it, 0, part(it, A), noise) && noise_at(it, ASIDE, beside, other);
    for (size_t i = 0; i < n; i++)
        noise[i] = valid ? pk_min(noise[i], other[i]) : 0;
    look_at_rows(it);
    look_at_momenta(it);
}
