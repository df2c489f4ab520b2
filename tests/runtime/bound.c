/* See bound.h. */
#include "bound.h"

const char *const bound_methods[BOUND_METHODS] = {
    "lie_midpoint", "lie_midpoint4", "lie_midpoint6", "rattle", "rattle4",   "rattle6",
    "rk4",          "rkmk4",         "rkmk8",         "gauss2", "gauss4",    "lobatto3",
    "radau5",       "dopri5",        "dop853",        "gauss",  "gsl_rk8pd", "gsl_msadams"};

void bound_set(struct bound_run *f, const struct pk_system *system)
{
    memset(f, 0, sizeof *f);
    system->defaults(&f->params);
    system->start(&f->params, f->q0, f->v0);
    f->problem.system = system;
    f->problem.params = &f->params;
    f->options = pk_options_default();
}

enum pk_status bound_init(struct bound_run *f, const char *name, double h)
{
    const struct pk_method *method = pk_method_find(name);
    if (!method)
        method = pk_gsl_method_find(name);
    CU_ASSERT_PTR_NOT_NULL_FATAL(method);
    if (method->traits & PK_ADAPTIVE)
        f->options.rtol = f->options.atol = h;
    else
        f->options.h = h;
    CU_ASSERT_FATAL(pk_integrator_size(&f->problem, method) <= sizeof f->block);
    return pk_integrator_init(&f->it, &f->problem, method, &f->options, 0, f->q0, f->v0, f->block,
                              sizeof f->block);
}

enum pk_status bound_go(struct bound_run *f, const struct pk_system *system, const char *method,
                        double h, double t_end)
{
    bound_set(f, system);
    const enum pk_status status = bound_init(f, method, h);
    return status < 0 ? status : pk_integrator_to(&f->it, t_end);
}

double bound_distance(const struct bound_run *f, const double *q, const double *v)
{
    const size_t n = f->it.n, shown = n - f->problem.system->n_first_order;
    double d = 0;
    for (size_t i = 0; i < n; i++)
        d = fmax(d, fmax(i < shown ? fabs(f->it.q[i] - q[i]) : 0, fabs(f->it.v[i] - v[i])));
    return d;
}

double bound_order(const struct pk_system *system, const char *method, double t_end)
{
    static struct bound_run f;
    double h[60], error[60], q[BOUND_N], v[BOUND_N];
    int count = 0;
    CU_ASSERT_FATAL(bound_go(&f, system, "gauss6", t_end / 100, t_end) == PK_DONE);
    memcpy(q, f.it.q, f.it.n * sizeof *q);
    memcpy(v, f.it.v, f.it.n * sizeof *v);
    for (double steps = 4; steps < 20000 && count < 60; steps = ceil(steps * 1.25)) {
        if (bound_go(&f, system, method, t_end / steps, t_end) < 0)
            continue;
        const double e = bound_distance(&f, q, v);
        if (e < 3e-12)
            break;
        h[count] = t_end / steps;
        error[count++] = e;
    }
    CU_ASSERT_FATAL(count >= 5);
    return fit_slope(h + count - 5, error + count - 5, 5);
}

struct pk_residuals bound_residuals(const struct bound_run *f)
{
    static double room[4096];
    struct pk_residuals found = {0};
    CU_ASSERT(pk_constraint_size(&f->problem) <= sizeof room);
    CU_ASSERT(pk_constraint_residuals(&f->problem, f->it.t, f->it.q, f->it.v, &found, room,
                                      sizeof room) == PK_DONE);
    return found;
}

double bound_energy(const struct bound_run *f)
{
    return f->problem.system->energy(&f->params, f->it.t, f->it.q, f->it.v, NULL);
}

int bound_says(const struct bound_run *f, const char *part)
{
    char text[600];
    pk_integrator_reason(&f->it, text, sizeof text);
    if (!strstr(text, part))
        printf("\n    said: %s\n    not: %s", text, part);
    return strstr(text, part) != NULL;
}
