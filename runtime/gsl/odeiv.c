/* GSL's steppers rkf45 and rk8pd (explicit Runge-Kutta), msadams and msbdf (multistep, of variable
 * order) and bsimp (extrapolation of the implicit midpoint rule) on y = (q, v), as methods of the
 * runtime, with GSL's formula for the step size. msbdf and bsimp take the Jacobian of y' = (v, a)
 * from the system's `linear`. GSL's error handler, which aborts, is off during every call into GSL.
 *
 * References: GNU Scientific Library Reference Manual, "Ordinary Differential Equations";
 * E. Fehlberg, NASA TR R-315 (1969); P. J. Prince, J. R. Dormand, J. Comp. Appl. Math. 7 (1981) 67;
 * G. Bader, P. Deuflhard, Numer. Math. 41 (1983) 373; G. D. Byrne, A. C. Hindmarsh, ACM TOMS 1
 * (1975) 71. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <pk/gsl.h>
#include <pk/keep.h>
#include <pk/linear.h> /* pk_system_linear_size() */
#include <pk/methods.h>

#include "../src/core/internal.h"

struct foreign {
    gsl_odeiv2_system system;
    gsl_odeiv2_driver *driver;
    gsl_odeiv2_control control; /* of the driver, by the tolerances of the integrator */
    /* GSL only knows whether the right-hand side failed; this is its status. */
    enum pk_status status;
    double h;       /* step size that GSL proposes; 0 before its first proposal */
    double *linear; /* work memory for the Jacobian matrix; NULL if the method does not use one */
};

static int right_hand_side(double t, const double *y, double *dy, void *context)
{
    struct pk_integrator *it = (struct pk_integrator *)context;
    struct foreign *f = (struct foreign *)it->own->extra;
    const struct pk_problem *problem = &it->problem;
    const double *v = y + it->n_q;
    pk_eval_input(it, t);
    it->count.evaluations++;
    memcpy(dy, v, it->n_q * sizeof *y);
    const int failed =
        problem->system->acceleration(problem->params, t, y, v, it->own->u, dy + it->n_q);
    if (failed) {
        f->status = pk_eval_failed(it, t, y, v, failed);
    } else if (!pk_all_finite(dy, it->n_q + it->n)) {
        f->status = PK_NOT_FINITE;
    } else {
        return GSL_SUCCESS;
    }
    pk_trouble(it, f->status, t);
    /* after GSL_FAILURE GSL halves the step; after GSL_EBADFUNC it would give up */
    return GSL_FAILURE;
}

static int jacobian(double t, const double *y, double *df_dy, double *df_dt, void *context)
{
    struct pk_integrator *it = (struct pk_integrator *)context;
    struct foreign *f = (struct foreign *)it->own->extra;
    const size_t n_q = it->n_q, n = it->n, m = n_q + n;
    double *a = f->linear, *a_q = a + n, *a_v = a_q + n * n, *rest = a_v + n * n;
    f->status = pk_eval_linear(it, t, y, y + n_q, a, a_q, a_v, df_dt + n_q, rest);
    if (f->status < 0) {
        pk_trouble(it, f->status, t);
        return GSL_FAILURE;
    }
    memset(df_dy, 0, m * m * sizeof *df_dy);
    memset(df_dt, 0, n_q * sizeof *df_dt);
    for (size_t i = 0; i < n; i++) {
        if (i < n_q)
            df_dy[i * m + n_q + i] = 1;
        memcpy(df_dy + (n_q + i) * m, a_q + i * n, n_q * sizeof *a_q);
        memcpy(df_dy + (n_q + i) * m + n_q, a_v + i * n, n * sizeof *a_v);
    }
    return GSL_SUCCESS;
}

static void release(struct pk_integrator *it)
{
    struct foreign *f = (struct foreign *)it->own->extra;
    if (f) {
        if (f->driver) {
            f->driver->c = NULL;
            gsl_odeiv2_driver_free(f->driver);
        }
        free(f->linear);
        free(f);
    }
    it->own->extra = NULL;
}

/* Step size control by the formulas of GSL's standard control ("Adaptive Step-size Control" in its
 * manual), with the tolerances of pk_tolerance(). */
static int errlevel(void *context, double y, double dy, double h, size_t i, double *level)
{
    struct pk_integrator *it = (struct pk_integrator *)context;
    (void)dy;
    if (i == 0)
        pk_scale_attempt(it, h);
    *level = pk_tolerance(it, i, y, y);
    return GSL_SUCCESS;
}

static int hadjust(void *context, size_t dim, unsigned int order, const double y[],
                   const double error[], const double dy[], double *h)
{
    struct pk_integrator *it = (struct pk_integrator *)context;
    double worst = 0;
    (void)dy;
    pk_scale_attempt(it, *h);
    for (size_t i = 0; i < dim; i++)
        worst = pk_max(worst, pk_abs(error[i]) / pk_tolerance(it, i, y[i], y[i]));
    if (worst > 1.1) {
        it->own->progress.longest = pk_max(it->own->progress.longest, pk_abs(*h));
        *h *= pk_max(0.2, 0.9 / pow(worst, 1.0 / order));
        return GSL_ODEIV_HADJ_DEC;
    }
    if (worst >= 0.5)
        return GSL_ODEIV_HADJ_NIL;
    *h *= pk_max(1, pk_min(5, 0.9 / pow(worst, 1.0 / (order + 1))));
    return GSL_ODEIV_HADJ_INC;
}

/* The control is part of struct foreign, so GSL allocates nothing for it. */
static const gsl_odeiv2_control_type by_tolerance = {
    "pk_tolerance", NULL, NULL, hadjust, errlevel, NULL, NULL,
};

static enum pk_status init(struct pk_integrator *it)
{
    const gsl_odeiv2_step_type *const *type =
        (const gsl_odeiv2_step_type *const *)it->method->table;
    release(it);
    struct foreign *f = (struct foreign *)calloc(1, sizeof *f);
    if (!f)
        return PK_NO_MEMORY;
    it->own->extra = f;
    if (it->method->traits & PK_LINEAR) {
        const size_t reals = it->n + 2 * it->n * it->n + pk_system_linear_size(&it->problem);
        f->linear = (double *)calloc(reals, sizeof *f->linear);
        f->system.jacobian = jacobian;
        if (!f->linear)
            return PK_NO_MEMORY;
    }
    f->system.function = right_hand_side;
    f->system.dimension = it->n_q + it->n;
    f->system.params = it;
    f->h = it->options.h;
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    f->driver = gsl_odeiv2_driver_alloc_y_new(&f->system, *type, 1e-6, 1, it->options.rtol);
    gsl_set_error_handler(handler);
    if (!f->driver)
        return PK_NO_MEMORY;
    f->control = (gsl_odeiv2_control){&by_tolerance, it};
    gsl_odeiv2_control_free(f->driver->c);
    f->driver->c = &f->control;
    gsl_odeiv2_step_set_driver(f->driver->s, f->driver);
    return PK_DONE;
}

static enum pk_status fall_back(struct foreign *f, enum pk_status status)
{
    gsl_odeiv2_step_reset(f->driver->s);
    gsl_odeiv2_evolve_reset(f->driver->e);
    return status;
}

static enum pk_status step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    struct foreign *f = (struct foreign *)own->extra;
    const double left = limit - it->t;
    double t = it->t, h = f->h;
    if (!(h * left > 0)) { /* in the first step, or after the direction of time has changed */
        h = it->options.h > 0 ? it->options.h : 1e-3 * (left > 0 ? left : -left);
        h = left > 0 ? h : -h;
        own->flags = 0;
    }
    if (!(own->flags & PK_HAVE_STEP)) /* the last step was not accepted: GSL must discard it */
        fall_back(f, PK_DONE);
    own->flags = 0;
    if (it->options.h_max > 0 && (h > it->options.h_max || h < -it->options.h_max))
        h = h > 0 ? it->options.h_max : -it->options.h_max;
    const double round = 10 * DBL_EPSILON * (t > 0 ? t : -t) + DBL_MIN;
    const double least = it->options.h_min > round ? it->options.h_min : round;

    const size_t bytes = (it->n_q + it->n) * sizeof *own->next;
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    const unsigned long rejected = f->driver->e->failed_steps;
    memcpy(own->next, own->state, bytes);
    f->status = PK_DONE;
    enum pk_status status = PK_DONE;
    const double planned = h;
    for (;;) {
        const int failed = gsl_odeiv2_evolve_apply(f->driver->e, f->driver->c, f->driver->s,
                                                   &f->system, &t, limit, &h, own->next);
        if (!failed)
            break;
        memcpy(own->next, own->state, bytes);
        t = it->t;
        gsl_odeiv2_step_reset(f->driver->s);
        h *= 0.2;
        it->count.rejections++;
        if (!(h > least || h < -least)) {
            status = pk_underflow(it, h);
            break;
        }
    }
    it->count.rejections += f->driver->e->failed_steps - rejected;
    const double made = t - it->t;
    if (status >= 0 && !(made > least || made < -least) && !(t <= limit && t >= limit))
        status = pk_underflow(it, made);
    gsl_set_error_handler(handler);
    if (status < 0)
        return fall_back(f, status);
    /* A step shortened by the limit does not determine the size of the next step. */
    const int cut = (t <= limit && t >= limit) && made * made < planned * planned;
    f->h = cut && h * h < planned * planned ? planned : h;
    own->next_t = t;
    own->h = f->h;
    own->flags = PK_HAVE_STEP;
    return PK_DONE;
}

/* Saves or restores the state. A Runge-Kutta method has all its state in gsl_odeiv2_evolve, which
 * is public; other methods have private state, so that PK_REFUSED is returned. */
static enum pk_status keep(struct pk_integrator *it, struct pk_keep *k)
{
    struct foreign *f = (struct foreign *)it->own->extra;
    const void *const table = it->method->table;
    if (table != &gsl_odeiv2_step_rkf45 && table != &gsl_odeiv2_step_rk8pd)
        return PK_REFUSED;
    gsl_odeiv2_evolve *e = f->driver->e;
    double *const numbers[] = {e->y0, e->yerr, e->dydt_in, e->dydt_out};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        pk_keep(k, numbers[i], e->dimension * sizeof *numbers[i]);
    PK_KEEP(k, e->last_step);
    PK_KEEP(k, e->count);
    PK_KEEP(k, e->failed_steps);
    PK_KEEP(k, f->h);
    return PK_DONE;
}

#define GSL(type)                                                                        \
    .needs = PK_NEEDS_GSL, .table = &gsl_odeiv2_step_##type, .init = init, .step = step, \
    .release = release, .keep = keep
PK_METHODS_GSL(PK_DEFINE_METHOD, GSL)

#define ADDRESS(A, name, ...) &pk_method_##name,
static const struct pk_method *const methods[] = {PK_METHODS_GSL(ADDRESS, )};

const struct pk_method *pk_gsl_method_at(size_t index)
{
    return index < sizeof methods / sizeof *methods ? methods[index] : NULL;
}

const struct pk_method *pk_gsl_method_find(const char *name)
{
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        if (strcmp(methods[i]->name, name) == 0)
            return methods[i];
    return NULL;
}
