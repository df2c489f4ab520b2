/* (Relative) equilibria; see pk/gsl_equilibria.h. Powell's hybrid method with scaling and analytic
 * derivatives, GSL's hybridsj, from Halton's points; then roots are told apart. Unknown i is q_i,
 * or v_i where coordinate i is cyclic; equation i is pdot_i = 0, or p_i = what it was. Of a
 * first-order variable, which v_i is, it is its rate; of one that no rate depends on, what it was.
 *
 * After Newton's method has come to round-off a root counts where the equations hold to 1e-10 of
 * their size and the correction is below 1e-4 of the way from the start. The second test rejects
 * points on the way to infinity, where forces vanish too; that it is no sharper admits roots at
 * which the linear terms vanish (a hoop at its critical rate). Reference: M. J. D. Powell, in
 * P. Rabinowitz (ed.), Numerical Methods for Nonlinear Algebraic Equations (1970) 87.
 */
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multiroots.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"
#include "halton.h"
#include "rates.h"

enum { ITERATIONS = 200, POLISH = 60, MORE = 8 }; /* starts for each root */

static int open_search(struct search *s, const struct pk_problem *problem)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    double *x = (double *)calloc(14 * n + 5 * n * n, sizeof *x);
    memset(s, 0, sizeof *s);
    s->turns = (unsigned char *)calloc(2 * n, 1);
    s->unread = s->turns + n;
    s->primes = (size_t *)calloc(n + 1, sizeof *s->primes);
    s->problem = problem;
    s->n = n;
    s->q = x;
    if (!x || !s->turns || !s->primes)
        return 0;
    primes(s->primes, n + 1);
    double **const vectors[] = {&s->q,    &s->v,     &s->kept, &s->box,   &s->middle,
                                &s->p,    &s->pdot,  &s->F,    &s->pivot, &s->scale,
                                &s->step, &s->slope, &s->rest, &s->r_t};
    double **const matrices[] = {&s->M, &s->p_q, &s->F_q, &s->F_v, &s->J};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        *vectors[k] = x, x += n;
    for (size_t k = 0; k < sizeof matrices / sizeof *matrices; k++)
        *matrices[k] = x, x += n * n;
    return 1;
}

static void close_search(struct search *s)
{
    free(s->q);
    free(s->turns);
    free(s->primes);
}

static void set_unknowns(struct search *s, const gsl_vector *z)
{
    for (size_t i = 0; i < s->n; i++)
        *unknown(s, i) = gsl_vector_get(z, i);
}

static int derivatives(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const struct pk_system *system = problem->system;
    const size_t n = s->n;
    system->mass(problem->params, 0, s->q, s->v, NULL, s->M);
    system->jacobian(problem->params, 0, s->q, s->v, NULL, s->p_q, s->F_q, s->F_v);
    if (system->n_first_order)
        system->linear(problem->params, 0, s->q, s->v, NULL, s->rest, s->F_q, s->F_v, s->r_t);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            const size_t x = i * n + j;
            const double by_rate = is_cyclic(s, i) ? s->M[x] : s->unread[i] ? i == j : s->F_v[x];
            const double by_place = is_cyclic(s, i) ? s->p_q[x] : s->unread[i] ? 0 : s->F_q[x];
            s->J[x] = is_by_rate(s, j) ? by_rate : by_place;
        }
    return pk_all_finite(s->J, n * n);
}

static int gsl_f(const gsl_vector *z, void *context, gsl_vector *f)
{
    struct search *s = (struct search *)context;
    set_unknowns(s, z);
    const double m = pk_equilibria_deflated(s);
    if (!equations(s) || !(m < HUGE_VAL))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < s->n; i++)
        gsl_vector_set(f, i, m * s->F[i] / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_df(const gsl_vector *z, void *context, gsl_matrix *J)
{
    struct search *s = (struct search *)context;
    set_unknowns(s, z);
    const double m = pk_equilibria_deflated(s);
    if (!derivatives(s) || !equations(s) || !(m < HUGE_VAL))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < s->n; i++)
        for (size_t j = 0; j < s->n; j++)
            gsl_matrix_set(J, i, j, m * (s->J[i * s->n + j] + s->F[i] * s->slope[j]) / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_fdf(const gsl_vector *z, void *context, gsl_vector *f, gsl_matrix *J)
{
    const int failed = gsl_f(z, context, f);
    return failed ? failed : gsl_df(z, context, J);
}

/* Newton's correction into s->F, and its largest part beside the reach; 0 where the linear terms
 * vanish exactly, HUGE_VAL where the equations do not hold. */
static double correction(struct search *s)
{
    const size_t n = s->n;
    if (!equations(s) || !derivatives(s))
        return HUGE_VAL;
    for (size_t i = 0; i < n; i++) {
        double size = s->scale[i];
        for (size_t j = 0; j < n; j++)
            size = fmax(size, fabs(s->J[i * n + j]) * reach(s, j));
        if (!(fabs(s->F[i]) <= 1e-10 * size))
            return HUGE_VAL;
    }
    if (!pk_lu_factor(s->J, s->pivot, n)) {
        memset(s->F, 0, n * sizeof *s->F);
        return 0;
    }
    pk_lu_solve(s->J, s->pivot, n, s->F);
    double most = 0;
    for (size_t i = 0; i < n; i++) {
        const double part = fabs(s->F[i]) / reach(s, i);
        most = part <= most ? most : part < HUGE_VAL ? part : HUGE_VAL;
    }
    return most;
}

/* The state at z is a root, and Newton's method would go nowhere; it is gone on with for as long as
 * corrections shrink. */
static int is_root(struct search *s, const gsl_vector *z)
{
    set_unknowns(s, z);
    double size = correction(s);
    memset(s->step, 0, s->n * sizeof *s->step);
    if (!(size <= 1e-4))
        return 0;
    for (int k = 0; k < POLISH && size > 0; k++) {
        for (size_t i = 0; i < s->n; i++)
            s->step[i] = s->F[i], *unknown(s, i) -= s->F[i];
        const double next = correction(s);
        if (!(next < size)) {
            for (size_t i = 0; i < s->n; i++)
                *unknown(s, i) += s->step[i];
            break;
        }
        size = next;
    }
    return equations(s) && derivatives(s); /* leaves M */
}

static int is_positive(struct search *s)
{
    memcpy(s->J, s->M, s->n * s->n * sizeof *s->M);
    return pk_ldl_factor(s->J, s->n) == 0;
}

static double energy(const struct search *s, const double *q, const double *v)
{
    const struct pk_system *system = s->problem->system;
    return system->energy ? system->energy(s->problem->params, 0, q, v, NULL) : 0;
}

static int is_known(struct search *s, const struct pk_equilibria *found)
{
    for (size_t k = 0; k < found->count; k++) {
        int same = 1;
        for (size_t i = 0; i < s->n && same; i++) {
            const int c = is_by_rate(s, i);
            double d = c ? s->v[i] - found->v[k * s->n + i] : s->q[i] - found->q[k * s->n + i];
            if (!c && s->turns[i])
                d = remainder(d, TWO_PI);
            same = fabs(d) <= 1e-4 * reach(s, i);
        }
        if (same)
            return 1;
    }
    return 0;
}

/* Puts the state where its energy belongs; equal ones stay in the order in which they came. */
static void insert(struct search *s, struct pk_equilibria *found)
{
    const size_t n = s->n;
    for (size_t i = 0; i < n; i++)
        if (s->turns[i] && !is_by_rate(s, i)) {
            s->q[i] = remainder(s->q[i], TWO_PI);
            if (s->q[i] < -TWO_PI / 2 * (1 - 1e-7))
                s->q[i] += TWO_PI;
        }
    const double h = energy(s, s->q, s->v);
    size_t at = found->count;
    while (at > 0 &&
           h < energy(s, found->q + (at - 1) * n, found->v + (at - 1) * n) - 1e-9 * fabs(h))
        at--;
    double *const lists[] = {found->q, found->v, found->doubt};
    const double *const one[] = {s->q, s->v, s->step};
    for (size_t k = 0; k < 3; k++)
        if (lists[k]) {
            double *const place = lists[k] + at * n;
            memmove(place + n, place, (found->count - at) * n * sizeof *place);
            memcpy(place, one[k], n * sizeof *place);
        }
    found->count++;
}

/* The last step was round-off. Equations are no measure: beside a pole in the box all are small. */
static int arrived(struct search *s, const gsl_vector *step)
{
    for (size_t i = 0; i < s->n; i++)
        if (!(fabs(gsl_vector_get(step, i)) <= 1e-14 * reach(s, i)))
            return 0;
    return 1;
}

/* Whether a root was found that was not known. */
static int try_from(struct search *s, gsl_multiroot_fdfsolver *solver, gsl_vector *z,
                    gsl_multiroot_function_fdf *function, struct pk_equilibria *found)
{
    int failed = gsl_multiroot_fdfsolver_set(solver, function, z);
    for (int k = 0; k < ITERATIONS && !failed; k++) {
        failed = gsl_multiroot_fdfsolver_iterate(solver);
        if (arrived(s, solver->dx))
            break;
    }
    const int again = s->known != NULL;
    s->known = NULL;
    if (!is_root(s, solver->x)) /* also where it stopped at round-off, as GSL calls it */
        found->failed += !again;
    else if (!is_positive(s))
        found->singular += !again;
    else if (!is_known(s, found)) {
        if (found->count < found->most) {
            insert(s, found);
            return 1;
        }
        found->more = 1;
    }
    return 0;
}

/* From a point, and as long as that finds another root again, those known deflated. */
static void search_from(struct search *s, size_t point, gsl_multiroot_fdfsolver *solver,
                        gsl_vector *z, gsl_multiroot_function_fdf *function,
                        struct pk_equilibria *found)
{
    int more = 1;
    for (int again = 0; again <= 1 || more; again++) {
        pk_equilibria_place(s, point);
        for (size_t i = 0; i < s->n; i++)
            gsl_vector_set(z, i, *unknown(s, i));
        s->known = again ? found : NULL;
        more = try_from(s, solver, z, function, found);
    }
}

enum pk_status pk_gsl_equilibria(const struct pk_problem *problem, const double *q0,
                                 const double *v0, size_t tries, struct pk_equilibria *found)
{
    const struct pk_system *system = problem->system;
    found->count = found->failed = found->singular = 0;
    found->more = 0;
    if (!(system->facts & PK_AUTONOMOUS) || !system->jacobian || !system->mass ||
        system->n_rotations || system->constraints.n || (system->n_first_order && !system->linear))
        return PK_REFUSED;
    struct search s;
    const size_t n = pk_system_count(system, problem->params);
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_multiroot_fdfsolver *solver =
        gsl_multiroot_fdfsolver_alloc(gsl_multiroot_fdfsolver_hybridsj, n);
    gsl_vector *z = gsl_vector_alloc(n);
    enum pk_status status = PK_NO_MEMORY;
    if (open_search(&s, problem) && solver && z &&
        (!system->n_first_order || pk_gsl_unread(problem, q0, v0, s.unread) == PK_DONE)) {
        gsl_multiroot_function_fdf function = {gsl_f, gsl_df, gsl_fdf, n, &s};
        status = PK_DONE;
        pk_equilibria_box(&s, q0, v0);
        if (found->turns)
            memcpy(found->turns, s.turns, n);
        if (found->middle && found->box) {
            memcpy(found->middle, s.middle, n * sizeof *s.middle);
            memcpy(found->box, s.box, n * sizeof *s.box);
        }
        for (size_t k = 0; k <= tries || (tries && k <= MORE * found->count); k++)
            search_from(&s, k, solver, z, &function, found);
    }
    close_search(&s);
    gsl_multiroot_fdfsolver_free(solver);
    gsl_vector_free(z);
    gsl_set_error_handler(handler);
    return status;
}
