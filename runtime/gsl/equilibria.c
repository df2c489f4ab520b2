/* Finds (relative) equilibria; see pk/gsl_equilibria.h. GSL's solver hybridsj (Powell's hybrid
 * method, with scaling and analytic derivatives) starts from points of Halton's sequence; duplicate
 * roots are removed. For most coordinates, unknown i is q_i and equation i is pdot_i = 0. For a
 * cyclic coordinate, the unknown is the rate v_i, and the equation is p_i = its initial value. For
 * a first-order variable, the unknown is its value v_i, and the equation is that its rate is 0; but
 * for a quadrature (on which no rate depends) it is v_i = its initial value.
 *
 * A point at which the solver stops is a root if each equation holds to 1e-10 of its scale and the
 * correction that Newton's method would make is below 1e-4 of the length scale reach() of each
 * unknown. The second test rejects points on the way to infinity, where forces also tend to 0. Its
 * tolerance is wide, to admit roots where the linear terms vanish (a bead on a hoop at its critical
 * rate). Reference: M. J. D. Powell, in P. Rabinowitz (ed.), Numerical Methods for Nonlinear
 * Algebraic Equations (1970) 87. */
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multiroots.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"
#include "halton.h"
#include "rates.h"

/* Step of goes_on() along a continuum of equilibria, as a fraction of reach() of each unknown. */
static const double BESIDE = 1e-2;
/* MORE: the search tries at least so many starting points for each root that it has found */
enum { ITERATIONS = 200, POLISH = 60, MORE = 8 };

static int open_search(struct search *s, const struct pk_problem *problem)
{
    const size_t n = pk_count_of(problem);
    memset(s, 0, sizeof *s);
    s->problem = problem;
    s->n = s->rows = n;
    s->rows += problem->system->constraints.n_holonomic + problem->system->constraints.n;
    const size_t rows = s->rows;
    double *x = (double *)calloc(13 * n + 2 * rows + 5 * rows * n, sizeof *x);
    s->turns = (unsigned char *)calloc(2 * n, 1);
    s->primes = (size_t *)calloc(n + 1, sizeof *s->primes);
    s->q = x;
    if (!x || !s->turns || !s->primes)
        return 0;
    s->unread = s->turns + n;
    primes(s->primes, n + 1);
    double **const vectors[] = {&s->q,    &s->v,    &s->kept,  &s->box,  &s->middle,
                                &s->p,    &s->pdot, &s->pivot, &s->step, &s->slope,
                                &s->rest, &s->r_t,  &s->along};
    double **const equations_of[] = {&s->F, &s->scale};
    double **const matrices[] = {&s->M, &s->p_q, &s->F_q, &s->F_v, &s->J};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        *vectors[k] = x, x += n;
    for (size_t k = 0; k < sizeof equations_of / sizeof *equations_of; k++)
        *equations_of[k] = x, x += rows;
    for (size_t k = 0; k < sizeof matrices / sizeof *matrices; k++)
        *matrices[k] = x, x += rows * n;
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
    if (is_bound(s))
        return pk_bound_derivatives(s);
    system->mass(OF(s), s->M);
    system->jacobian(OF(s), s->p_q, s->F_q, s->F_v);
    if (system->n_first_order)
        system->linear(OF(s), s->rest, s->F_q, s->F_v, s->r_t);
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
    for (size_t i = 0; i < s->rows; i++)
        gsl_vector_set(f, i, m * s->F[i] / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_df(const gsl_vector *z, void *context, gsl_matrix *J)
{
    struct search *s = (struct search *)context;
    set_unknowns(s, z);
    const double m = pk_equilibria_deflated(s);
    if (!(m < HUGE_VAL) || !equations(s) || !derivatives(s))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < s->rows; i++)
        for (size_t j = 0; j < s->n; j++)
            gsl_matrix_set(J, i, j, m * (s->J[i * s->n + j] + s->F[i] * s->slope[j]) / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_fdf(const gsl_vector *z, void *context, gsl_vector *f, gsl_matrix *J)
{
    const int failed = gsl_f(z, context, f);
    return failed ? failed : gsl_df(z, context, J);
}

/* Overwrites the residuals s->F with the correction J^-1 F of Newton's method. Returns the largest
 * component of this correction relative to reach(); 0 if the Jacobian matrix J is singular,
 * HUGE_VAL if the equations do not hold at the current state. */
static double correction(struct search *s)
{
    const size_t n = s->n;
    if (!equations(s) || !derivatives(s))
        return HUGE_VAL;
    for (size_t i = 0; i < s->rows; i++) {
        double size = s->scale[i];
        for (size_t j = 0; j < n; j++)
            size = fmax(size, fabs(s->J[i * n + j]) * reach(s, j));
        if (!(fabs(s->F[i]) <= 1e-10 * size))
            return HUGE_VAL;
    }
    if (is_bound(s) ? !pk_bound_correct(s) : !pk_lu_factor(s->J, s->pivot, n)) {
        memset(s->F, 0, n * sizeof *s->F);
        return 0;
    }
    if (!is_bound(s))
        pk_lu_solve(s->J, s->pivot, n, s->F);
    double most = 0;
    for (size_t i = 0; i < n; i++) {
        const double part = fabs(s->F[i]) / reach(s, i);
        most = part <= most ? most : part < HUGE_VAL ? part : HUGE_VAL;
    }
    return most;
}

/* Refines the state by Newton's method while corrections shrink. Returns whether it is a root. */
static int is_root(struct search *s)
{
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
    for (size_t i = 0; i < s->n; i++) /* body rates are exactly 0 at an equilibrium */
        s->v[i] = is_body_rate(s, i) ? 0 : s->v[i];
    /* derivatives() also computes the mass matrix s->M, which is_positive() reads */
    return size < HUGE_VAL && equations(s) && derivatives(s);
}

/* Returns whether a root at which the Jacobian matrix is singular lies on a continuum of
 * equilibria. Moves the state by the fraction BESIDE of its scale along a null direction and solves
 * again. If the root is isolated, the solver undoes most of this step. */
static int goes_on(struct search *s)
{
    double *const at = s->p_q, *const step = s->F_q, back = 0, way = 0;
    const size_t slack = s->slack;
    if (!slack)
        return 0;
    for (size_t i = 0; i < s->n; i++) {
        at[i] = *unknown(s, i);
        step[i] = BESIDE * s->along[i];
        *unknown(s, i) += step[i];
        way += step[i] * step[i] / reach(s, i) / reach(s, i);
    }
    pk_equilibria_normalise(s);
    pk_bound_solve(s, gsl_f, gsl_df);
    const double off = correction(s);
    for (size_t i = 0; i < s->n; i++) {
        const double d = *unknown(s, i) - at[i] - step[i];
        back += d * d / reach(s, i) / reach(s, i);
        *unknown(s, i) = at[i];
    }
    s->slack = slack;
    const int goes = off <= 1e-4 && back < way / 4;
    /* an isolated root is known less accurately along the null direction */
    for (size_t i = 0; i < s->n && !goes; i++)
        s->step[i] = step[i] / 100;
    return goes;
}

static int is_positive(struct search *s)
{
    memcpy(s->J, s->M, s->n * s->n * sizeof *s->M);
    return is_bound(s) || pk_ldl_factor(s->J, s->n) == 0;
}

/* Returns whether the solver's last step was round-off. Small residuals would not show that the
 * solver has converged: if the equations have a pole in the box, their scale is large, and all
 * residuals relative to this scale are small. */
static int arrived(struct search *s, const gsl_vector *step)
{
    for (size_t i = 0; i < s->n; i++)
        if (!(fabs(gsl_vector_get(step, i)) <= 1e-14 * reach(s, i)))
            return 0;
    return 1;
}

/* Solves the equations from the guess z of the unknowns. Returns whether this gave a new root. */
static int try_from(struct search *s, gsl_multiroot_fdfsolver *solver, gsl_vector *z,
                    gsl_multiroot_function_fdf *function, struct pk_equilibria *found)
{
    int failed = is_bound(s) || gsl_multiroot_fdfsolver_set(solver, function, z);
    for (int k = 0; k < ITERATIONS && !failed; k++) {
        failed = gsl_multiroot_fdfsolver_iterate(solver);
        if (arrived(s, solver->dx))
            break;
    }
    if (is_bound(s))
        pk_bound_solve(s, gsl_f, gsl_df);
    else
        set_unknowns(s, solver->x);
    const int again = s->known != NULL;
    s->known = NULL;
    /* Tests the point even if GSL reports no progress, which may be due to round-off. */
    if (!is_root(s))
        found->failed += !again;
    else if (!is_positive(s))
        found->singular += !again;
    else if (s->slack = goes_on(s) ? s->slack : 0, !pk_equilibria_known(s, found)) {
        if (found->count < found->most) {
            pk_equilibria_insert(s, found);
            return 1;
        }
        found->more = 1;
    }
    return 0;
}

/* Solves from a starting point, then again with known roots deflated, until no root is new. */
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
    const int bound = system->n_rotations || system->constraints.n;
    if (!(system->facts & PK_AUTONOMOUS) || !(bound || (system->jacobian && system->mass)) ||
        ((bound || system->n_first_order) && !system->linear))
        return PK_REFUSED;
    struct search s;
    const size_t n = pk_count_of(problem);
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_multiroot_fdfsolver *solver =
        gsl_multiroot_fdfsolver_alloc(gsl_multiroot_fdfsolver_hybridsj, n);
    gsl_vector *z = gsl_vector_alloc(n);
    enum pk_status status = PK_NO_MEMORY;
    if (open_search(&s, problem) && solver && z &&
        (!system->n_first_order || pk_gsl_unread(problem, q0, v0, s.unread) == PK_DONE)) {
        gsl_multiroot_function_fdf function = {gsl_f, gsl_df, gsl_fdf, n, &s};
        status = PK_DONE;
        s.energy = fabs(pk_equilibria_energy(&s, q0, v0));
        pk_equilibria_box(&s, q0, v0);
        if (found->turns)
            memcpy(found->turns, s.turns, n);
        if (found->middle && found->box) {
            memcpy(found->middle, s.middle, n * sizeof *s.middle);
            memcpy(found->box, s.box, n * sizeof *s.box);
        }
        for (size_t k = 0; !found->more && (k <= tries || (tries && k <= MORE * found->count)); k++)
            search_from(&s, k, solver, z, &function, found);
    }
    close_search(&s);
    gsl_multiroot_fdfsolver_free(solver);
    gsl_vector_free(z);
    gsl_set_error_handler(handler);
    return status;
}
