/* Makes steps of any method from any state; see pk/stability.h. */
#define _POSIX_C_SOURCE 200809L

#include <pk/constraint.h>
#include <pk/stability.h>

#include "../observers/condition.h"
#include "../settings/settings.h"

struct pk_stability {
    struct pk_run *run;
    const struct pk_method *method;
    struct pk_options options;
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct looking *looking; /* NULL if condition numbers are not watched */
    unsigned watch;
    struct memory memory;
    const double *state; /* the state given to pk_stability_begin() */
    enum pk_status status;
    char *report;
};

static void watch(struct pk_stability *of, const struct pk_integrator *it)
{
    if (of->watch & PK_WATCH_CONSTANTS)
        pk_monitor_update(&of->monitor, it->t, it->q, it->v);
}

static void begin(void *context)
{
    struct pk_stability *of = context;
    const size_t n = of->run->settings.n, size = pk_integrator_size(&of->problem, of->method);
    const size_t monitor_size = pk_monitor_size(&of->problem);
    void *block = memory_take(&of->memory, size, 1);
    void *monitor_block = memory_take(&of->memory, monitor_size + 1, 1);
    pk_monitor_init(&of->monitor, &of->problem, monitor_block, monitor_size);
    if (of->watch & PK_WATCH_CONDITION)
        of->looking = condition_begin(&of->memory, &of->problem, NULL);
    of->status = pk_integrator_init(&of->it, &of->problem, of->method, &of->options, 0, of->state,
                                    of->state + n, block, size);
    if (of->status >= 0 && of->watch & PK_WATCH_CONDITION)
        watch(of, &of->it);
}

struct pk_stability *pk_stability_begin(struct pk_run *run, const char *method, double h,
                                        double rtol, double atol, unsigned watch,
                                        const double *state, int *status)
{
    struct pk_stability *of = calloc(1, sizeof *of);
    const struct pk_method *found = run_method_find(run->model, method);
    *status = PK_BAD_ARGUMENT;
    if (of && found && (h > 0) == pk_is_fixed(found)) {
        of->run = run;
        of->method = found;
        of->watch = watch;
        of->state = state;
        of->problem = run_problem(run);
        of->options = run->settings.options;
        of->options.stop = run_ending;
        of->options.h = h;
        if (rtol > 0) {
            of->options.rtol = rtol;
            of->options.atol = atol < 0 ? PK_ATOL_OF_MOTION : atol;
        }
        *status = memory_try(&of->memory, begin, of) ? of->status : PK_NO_MEMORY;
    }
    if (*status >= 0)
        return of;
    pk_stability_end(of);
    return NULL;
}

static void write(const struct pk_integrator *it, double *state)
{
    memset(state, 0, it->n * sizeof *state);
    memcpy(state, it->q, it->n_q * sizeof *state);
    memcpy(state + it->n, it->v, it->n * sizeof *state);
}

/* Writes t and the state to `out`; returns the address after them. */
static double *put(const struct pk_integrator *it, double *out)
{
    *out = it->t;
    write(it, out + 1);
    return out + 1 + 2 * it->n;
}

size_t pk_stability_steps(struct pk_stability *of, double until, size_t count, int every,
                          double *out, int *status)
{
    struct pk_integrator *it = &of->it;
    size_t made = 0;
    *status = PK_DONE;
    while (made < count && it->t < until && !(*status = pk_integrator_step(it, until))) {
        watch(of, it);
        condition_step(of->looking, NULL, of->run->settings.until,
                       &(struct moment){it->t, it->q, it->v});
        made++;
        if (every)
            out = put(it, out);
    }
    if (!every)
        put(it, out);
    return made;
}

int pk_stability_restart(struct pk_stability *of, double t, double h, const double *state)
{
    enum pk_status status = pk_integrator_reset(&of->it, t, state, state + of->it.n);
    if (status >= 0 && h > 0)
        status = pk_integrator_set_step(&of->it, h);
    return status;
}

void pk_stability_map(struct pk_stability *of, double h, size_t steps, size_t count,
                      const double *from, double *to)
{
    const size_t wide = 2 * of->it.n;
    const int whole = (of->method->traits & PK_ADAPTIVE) != 0;
    const double until = (double)steps * h;
    for (size_t k = 0; k < count; k++, from += wide, to += wide) {
        int good = pk_stability_restart(of, 0, whole ? until / 64 : h, from) >= 0;
        if (whole)
            good = good && pk_integrator_to(&of->it, until) >= 0;
        for (size_t i = 0; i < steps && !whole && good; i++)
            good = pk_integrator_step(&of->it, (until + h)) >= 0;
        write(&of->it, to);
        for (size_t i = 0; i < wide && !good; i++)
            to[i] = (double)NAN;
    }
}

int pk_stability_project(struct pk_stability *of, double *state)
{
    return pk_constraint_project(&of->it, of->it.t, state, state + of->it.n);
}

static void tell_drift(struct json *j, const char *name, const struct pk_drift *drift)
{
    json_open(j, NULL, '{');
    json_text(j, "name", name);
    json_reals(j, {"max", drift->max}, {"scale", drift->scale}, {"mean_t", drift->mean_t},
               {"slope", drift->var_t > 0 ? drift->cov / drift->var_t : 0});
    json_close(j, '}');
}

static void tell_constants(const struct pk_stability *of, struct json *j)
{
    const struct pk_system *system = of->problem.system;
    json_open(j, "constants", '[');
    for (size_t i = 0; system->cyclic && system->canonical && i < of->it.n; i++)
        if (system->cyclic[i])
            tell_drift(j, system->momenta[i].name, &of->monitor.momenta[i]);
    for (size_t i = 0; i < system->n_conserved; i++)
        tell_drift(j, system->conserved[i].name, &of->monitor.conserved[i]);
    json_close(j, ']');
}

static void tell(void *context)
{
    struct pk_stability *of = context;
    char warning[640];
    size_t size;
    struct json json = {.file = open_memstream(&of->report, &size)}, *j = &json;
    if (!json.file)
        return;
    json_open(j, NULL, '{');
    tell_constants(of, j);
    json_real(j, "cond", condition_of_step(&of->memory, &of->problem, &of->it));
    json_flag(j, "symmetric", (of->method->traits & (PK_SYMPLECTIC | PK_SYMMETRIC)) != 0);
    condition_report(of->looking, j);
    if (condition_warning(of->looking, warning, sizeof warning))
        json_text(j, "warning", warning);
    json_close(j, '}');
    fclose(json.file);
}

const char *pk_stability_report(struct pk_stability *of)
{
    free(of->report);
    of->report = NULL;
    return memory_try(&of->memory, tell, of) && of->report ? of->report : "{}";
}

void pk_stability_end(struct pk_stability *of)
{
    if (!of)
        return;
    pk_integrator_free(&of->it);
    memory_end(&of->memory);
    free(of->report);
    free(of);
}
