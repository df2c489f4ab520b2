/* (Relative) equilibria; see pk/gsl_equilibria.h. Powell's hybrid method with scaling and analytic
 * derivatives, GSL's hybridsj, from Halton's points; then roots are told apart. Unknown i is q_i,
 * or v_i where coordinate i is cyclic; equation i is pdot_i = 0, or p_i = what it was.
 *
 * Nothing is compared with 1: lengths are those of the motion, each equation has its own size.
 * After Newton's method has come to round-off a root counts where the equations hold to 1e-10 of
 * their size and the correction is below 1e-4 of the way from the start. The second test rejects
 * points on the way to infinity, where forces vanish too; that it is no sharper admits roots at
 * which the linear terms vanish (a hoop at its critical rate). Reference: M. J. D. Powell, in
 * P. Rabinowitz (ed.), Numerical Methods for Nonlinear Algebraic Equations (1970) 87.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multiroots.h>

#include <pk/gsl_equilibria.h>

#include "../src/internal.h"
#include "halton.h"

static const double TWO_PI = 6.283185307179586476925;
static const double RUNAWAY = 100;
enum { ITERATIONS = 200, POLISH = 60, MOTION = 48, SETTLING = 100 };

/* A search: the problem, a state to write to, and room for the kernels' results. */
struct search {
    const struct pk_problem *problem;
    size_t n;
    double *q, *v;               /* the state tried; what is not sought stays as in the start */
    double *kept;                /* momenta of the start */
    double *step;                /* Newton's, to be taken back */
    double *box, *middle;        /* where to seek each unknown */
    double *p, *pdot, *F;        /* n */
    double *M, *p_q, *F_q, *F_v; /* n n */
    double *J, *pivot;
    double *scale;               /* of each equation in the box */
    unsigned char *turns;        /* q_i + 2 pi is the same place */
};

static int is_cyclic(const struct search *s, size_t i)
{
    const unsigned char *cyclic = s->problem->system->cyclic;
    return cyclic && cyclic[i];
}

static int open_search(struct search *s, const struct pk_problem *problem)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    double *x = (double *)calloc(11 * n + 5 * n * n, sizeof *x);
    memset(s, 0, sizeof *s);
    s->turns = (unsigned char *)calloc(n, 1);
    s->problem = problem;
    s->n = n;
    s->q = x;
    if (!x || !s->turns)
        return 0;
    double **const vectors[] = {&s->q,   &s->v,    &s->kept, &s->box, &s->middle,
                                &s->p,   &s->pdot, &s->F,    &s->pivot, &s->scale,
                                &s->step};
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
}

static void set_unknowns(struct search *s, const gsl_vector *z)
{
    for (size_t i = 0; i < s->n; i++)
        (is_cyclic(s, i) ? s->v : s->q)[i] = gsl_vector_get(z, i);
}

/* F at the state; 0 where it is not finite. */
static int equations(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    problem->system->canonical(problem->params, 0, s->q, s->v, NULL, s->p, s->pdot);
    for (size_t i = 0; i < s->n; i++)
        s->F[i] = is_cyclic(s, i) ? s->p[i] - s->kept[i] : s->pdot[i];
    return pk_all_finite(s->F, s->n);
}

static int derivatives(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const size_t n = s->n;
    problem->system->mass(problem->params, 0, s->q, s->v, NULL, s->M);
    problem->system->jacobian(problem->params, 0, s->q, s->v, NULL, s->p_q, s->F_q, s->F_v);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            const size_t x = i * n + j;
            const double by_rate = is_cyclic(s, i) ? s->M[x] : s->F_v[x];
            const double by_place = is_cyclic(s, i) ? s->p_q[x] : s->F_q[x];
            s->J[x] = is_cyclic(s, j) ? by_rate : by_place;
        }
    return pk_all_finite(s->J, n * n);
}

static int gsl_f(const gsl_vector *z, void *context, gsl_vector *f)
{
    struct search *s = (struct search *)context;
    set_unknowns(s, z);
    if (!equations(s))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < s->n; i++)
        gsl_vector_set(f, i, s->F[i] / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_df(const gsl_vector *z, void *context, gsl_matrix *J)
{
    struct search *s = (struct search *)context;
    set_unknowns(s, z);
    if (!derivatives(s))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < s->n; i++)
        for (size_t j = 0; j < s->n; j++)
            gsl_matrix_set(J, i, j, s->J[i * s->n + j] / s->scale[i]);
    return GSL_SUCCESS;
}

static int gsl_fdf(const gsl_vector *z, void *context, gsl_vector *f, gsl_matrix *J)
{
    const int failed = gsl_f(z, context, f);
    return failed ? failed : gsl_df(z, context, J);
}

/* The start itself for k = 0; then half of the points in the box, a quarter each in one four and one
 * 32 times as wide, except for angles. Not in base 2, whose digits go with those of k. */
static void place(const struct search *s, size_t k, gsl_vector *z)
{
    static const double widths[] = {32, 1, 4, 1};
    for (size_t i = 0; i < s->n; i++) {
        const double wide = s->turns[i] && !is_cyclic(s, i) ? 1 : widths[k % 4];
        const double x = k ? 2 * halton(k, prime(i + 1)) - 1 : 0;
        gsl_vector_set(z, i, s->middle[i] + wide * s->box[i] * x);
    }
}

/* Whether q_i and q_i + 2 pi are the same place, tried at three others: each momentum and force beside
 * its own size, for one may be of a far smaller one than the others. */
static int is_turn(struct search *s, size_t i)
{
    double *size = s->p_q, *change = s->F_q; /* of each p and pdot */
    double *copy = s->M;
    const size_t n = s->n;
    int same = 1;
    for (int part = 0; part < 2 && same; part++) {
        const double *now = part ? s->pdot : s->p;
        memset(size, 0, n * sizeof *size);
        memset(change, 0, n * sizeof *change);
        for (size_t k = 1; k <= 3; k++) {
            for (size_t j = 0; j < n; j++) {
                s->q[j] = s->middle[j] + 2 * halton(k + 7, prime(j)) - 1;
                s->v[j] = 0.7 - halton(k + 3, prime(j));
            }
            if (!equations(s))
                return 0;
            memcpy(copy, now, n * sizeof *copy);
            s->q[i] += TWO_PI;
            if (!equations(s))
                return 0;
            for (size_t j = 0; j < n; j++) {
                change[j] = fmax(change[j], fabs(now[j] - copy[j]));
                size[j] = fmax(size[j], fabs(now[j]));
            }
        }
        double most = 0;
        for (size_t j = 0; j < n; j++)
            most = fmax(most, size[j]);
        for (size_t j = 0; j < n; j++) /* one that vanishes is round-off of the others */
            same = same && change[j] <= 1e-9 * size[j] + 1e-14 * most;
    }
    return same;
}

/* How far the motion from the start goes in some steps of dop853, which are of its own length, into
 * box: |q - q0|, or |v| of what is cyclic. Steps count once they no longer double; one after which
 * something is RUNAWAY times as far as at the first that counts ends it. */
static void extent(struct search *s, const double *q0, const double *v0)
{
    const struct pk_method *method = pk_method_find("dop853");
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    const size_t size = pk_integrator_size(s->problem, method);
    void *block = malloc(size);
    double before = HUGE_VAL, *begun = s->p;
    int settled = 0, runs = 1;
    options.rtol = 1e-6;
    options.atol = 1e-300; /* no unit is small or large */
    memset(s->box, 0, s->n * sizeof *s->box);
    if (!block)
        return;
    runs = pk_integrator_init(&it, s->problem, method, &options, 0, q0, v0, block, size) >= 0;
    for (int k = 0; runs && k < SETTLING && settled < MOTION; k++) {
        const double t = it.t;
        runs = pk_integrator_step(&it, 1e300) >= 0;
        settled += settled || (k > 0 && it.t - t < 2 * before);
        before = it.t - t;
        for (size_t i = 0; i < s->n && runs && settled; i++) {
            const double far = fabs(is_cyclic(s, i) ? it.v[i] : it.q[i] - q0[i]);
            if (settled == 1 || !(begun[i] > 0))
                begun[i] = far;
            if (far > RUNAWAY * begun[i])
                runs = 0;
            else
                s->box[i] = fmax(s->box[i], far);
        }
    }
    pk_integrator_free(&it);
    free(block);
}

/* A length for each unknown: twice the motion's, or |q0|; where both are 0 the others', or 1. */
static void choose_box(struct search *s, const double *q0, const double *v0)
{
    double others = 0;
    extent(s, q0, v0);
    for (size_t i = 0; i < s->n; i++) {
        const int c = is_cyclic(s, i);
        s->box[i] = 2 * fmax(s->box[i], fabs(c ? v0[i] : q0[i]));
        if (s->turns[i] && !c)
            s->box[i] = TWO_PI / 2;
        else if (!c)
            others = fmax(others, s->box[i]);
    }
    for (size_t i = 0; i < s->n; i++)
        if (!(s->box[i] > 0))
            s->box[i] = is_cyclic(s, i) || !(others > 0) ? 1 : others;
}

static void prepare(struct search *s, const double *q0, const double *v0)
{
    const struct pk_problem *problem = s->problem;
    const size_t n = s->n;
    problem->system->canonical(problem->params, 0, q0, v0, NULL, s->kept, s->pdot);
    memcpy(s->middle, q0, n * sizeof *q0);
    for (size_t i = 0; i < n; i++)
        s->turns[i] = (unsigned char)is_turn(s, i);
    memcpy(s->q, q0, n * sizeof *q0);
    for (size_t i = 0; i < n; i++) {
        const int c = is_cyclic(s, i);
        s->v[i] = c ? v0[i] : 0;
        s->middle[i] = c ? v0[i] : s->turns[i] ? 0 : q0[i];
    }
    choose_box(s, q0, v0);
}

/* The size of each equation: the most of it in the box; of one that vanishes there all the same
 * round-off of the largest. */
static void measure(struct search *s, gsl_vector *z)
{
    double most = 0;
    for (size_t k = 1; k <= 32; k++) {
        place(s, 2 * k + 1, z);
        set_unknowns(s, z);
        if (equations(s))
            for (size_t i = 0; i < s->n; i++) {
                s->scale[i] = fmax(s->scale[i], fabs(s->F[i]));
                most = fmax(most, s->scale[i]);
            }
    }
    for (size_t i = 0; i < s->n; i++)
        s->scale[i] = fmax(s->scale[i], most > 0 ? 1e-14 * most : 1);
}

static double *unknown(struct search *s, size_t i)
{
    return (is_cyclic(s, i) ? s->v : s->q) + i;
}

/* The length that a difference of unknown i is small or large beside. */
static double reach(struct search *s, size_t i)
{
    return fmax(s->box[i], fabs(*unknown(s, i) - s->middle[i]));
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
    return s->problem->system->energy(s->problem->params, 0, q, v, NULL);
}

static int is_known(struct search *s, const struct pk_equilibria *found)
{
    for (size_t k = 0; k < found->count; k++) {
        int same = 1;
        for (size_t i = 0; i < s->n && same; i++) {
            const int c = is_cyclic(s, i);
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
        if (s->turns[i] && !is_cyclic(s, i)) {
            s->q[i] = remainder(s->q[i], TWO_PI);
            if (s->q[i] < -TWO_PI / 2 * (1 - 1e-7))
                s->q[i] += TWO_PI;
        }
    const double h = energy(s, s->q, s->v);
    size_t at = found->count;
    while (at > 0 && h < energy(s, found->q + (at - 1) * n, found->v + (at - 1) * n) -
                             1e-9 * fabs(h))
        at--;
    const size_t after = (found->count - at) * n;
    memmove(found->q + (at + 1) * n, found->q + at * n, after * sizeof *found->q);
    memmove(found->v + (at + 1) * n, found->v + at * n, after * sizeof *found->v);
    memcpy(found->q + at * n, s->q, n * sizeof *s->q);
    memcpy(found->v + at * n, s->v, n * sizeof *s->v);
    found->count++;
}

static void try_from(struct search *s, gsl_multiroot_fdfsolver *solver, gsl_vector *z,
                     gsl_multiroot_function_fdf *function, struct pk_equilibria *found)
{
    int failed = gsl_multiroot_fdfsolver_set(solver, function, z);
    for (int k = 0; k < ITERATIONS && !failed; k++) {
        failed = gsl_multiroot_fdfsolver_iterate(solver);
        if (gsl_multiroot_test_residual(solver->f, 1e-14) == GSL_SUCCESS)
            break;
    }
    if (!is_root(s, solver->x)) /* also where it stopped at round-off, as GSL calls it */
        found->failed++;
    else if (!is_positive(s))
        found->singular++;
    else if (!is_known(s, found)) {
        if (found->count < found->most)
            insert(s, found);
        else
            found->more = 1;
    }
}

enum pk_status pk_gsl_equilibria(const struct pk_problem *problem, const double *q0,
                                 const double *v0, size_t tries, struct pk_equilibria *found)
{
    const struct pk_system *system = problem->system;
    found->count = found->failed = found->singular = 0;
    found->more = 0;
    if (!(system->facts & PK_AUTONOMOUS) || !system->jacobian || !system->mass)
        return PK_REFUSED;
    struct search s;
    const size_t n = pk_system_count(system, problem->params);
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_multiroot_fdfsolver *solver =
        gsl_multiroot_fdfsolver_alloc(gsl_multiroot_fdfsolver_hybridsj, n);
    gsl_vector *z = gsl_vector_alloc(n);
    enum pk_status status = PK_NO_MEMORY;
    if (open_search(&s, problem) && solver && z) {
        gsl_multiroot_function_fdf function = {gsl_f, gsl_df, gsl_fdf, n, &s};
        status = PK_DONE;
        prepare(&s, q0, v0);
        measure(&s, z);
        if (found->turns)
            memcpy(found->turns, s.turns, n);
        for (size_t k = 0; k <= tries; k++) {
            place(&s, k, z);
            try_from(&s, solver, z, &function, found);
        }
    }
    close_search(&s);
    gsl_multiroot_fdfsolver_free(solver);
    gsl_vector_free(z);
    gsl_set_error_handler(handler);
    return status;
}
