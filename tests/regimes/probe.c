/* One model and one method of the runtime, driven from Python by numbers: what a prediction needs
 * beyond `pkgen run` is the state after every step, the status of a single one, and steps that
 * the runtime refuses or does not have (misused.c). Compiled with the model's C and -DMODEL=NAME.
 */
#include <stdlib.h>
#include <string.h>

#include "probe.h"

#define JOIN(a, b) a##b
#define SYSTEM_OF(model) JOIN(model, _system)
extern const struct pk_system SYSTEM_OF(MODEL);

struct probe *probe_open(const char *method)
{
    struct probe *p = calloc(1, sizeof *p);
    const struct pk_system *system = p->problem.system = &SYSTEM_OF(MODEL);
    p->params = calloc(1, system->params_size + sizeof(double));
    p->problem.params = p->params;
    if (system->families.count) { /* families as loops: their sizes are the defaults */
        system->families.set_sizes(p->params);
        const size_t bytes = system->families.block_size(p->params);
        p->families = malloc(bytes + sizeof(double));
        system->families.attach(p->params, p->families);
    }
    system->defaults(p->params);
    p->method = pk_method_find(method);
    p->options = pk_options_default();
    p->n = pk_system_count(system, p->params);
    p->q = calloc(4 * p->n, sizeof(double));
    p->v = p->q + p->n;
    return p;
}

void probe_close(struct probe *p)
{
    pk_integrator_free(&p->it);
    free(p->block);
    free(p->families);
    free(p->q);
    free(p->params);
    free(p);
}

int probe_known(const struct probe *p) { return p->method != NULL; }

/* Parameters; those that follow others are computed again unless they were set themselves. */
int probe_set(struct probe *p, size_t count, const char *const *names, const double *values)
{
    const struct pk_system *system = p->problem.system;
    unsigned char *given = calloc(system->n_parameters + 1, 1);
    for (size_t i = 0; i < count; i++) {
        size_t k = 0;
        while (k < system->n_parameters && strcmp(system->parameters[k].what.name, names[i]) != 0)
            k++;
        if (k == system->n_parameters) {
            free(given);
            return -1;
        }
        memcpy((char *)p->params + system->parameters[k].offset, values + i, sizeof *values);
        given[k] = 1;
    }
    system->derive(p->params, given);
    free(given);
    const int status = system->prepare(p->params);
    system->start(p->params, p->q, p->v);
    return status;
}

void probe_start(const struct probe *p, double *q, double *v)
{
    memcpy(q, p->q, p->n * sizeof *q);
    memcpy(v, p->v, p->n * sizeof *v);
}

int probe_begin(struct probe *p, double h, double tolerance, double h_max, int iteration,
                int max_iterations, double t, const double *q, const double *v)
{
    p->options.h = h;
    p->options.h_max = h_max;
    p->options.rtol = p->options.atol = tolerance;
    p->options.iteration = iteration ? PK_FIXED_POINT : PK_NEWTON;
    p->options.max_iterations = max_iterations;
    const size_t size = pk_integrator_size(&p->problem, p->method);
    p->block = malloc(size);
    return pk_integrator_init(&p->it, &p->problem, p->method, &p->options, t, q, v, p->block, size);
}

double probe_energy(const struct probe *p, double t, const double *q, const double *v)
{
    const struct pk_system *system = p->problem.system;
    return system->energy ? system->energy(p->params, t, q, v, NULL) : 0;
}

static void row(const struct probe *p, double *out)
{
    const size_t n = p->n;
    out[0] = p->it.t;
    memcpy(out + 1, p->it.q, n * sizeof *out);
    memcpy(out + 1 + n, p->it.v, n * sizeof *out);
    out[1 + 2 * n] = probe_energy(p, p->it.t, p->it.q, p->it.v);
}

/* Up to `steps` steps towards `limit`, a row t, q, v, energy after each `every` of them.
 * Returns how many rows were written; the status is probe_status(). */
size_t probe_steps(struct probe *p, double limit, size_t steps, size_t every, double *rows)
{
    size_t written = 0;
    const size_t width = 2 + 2 * p->n;
    for (size_t i = 1; i <= steps; i++) {
        if (pk_integrator_step(&p->it, limit) < 0)
            break;
        if (i % every == 0)
            row(p, rows + width * written++);
    }
    return written;
}

/* Rows at the given times, landed on exactly. */
size_t probe_rows(struct probe *p, size_t count, const double *times, double *rows)
{
    size_t written = 0;
    for (; written < count; written++) {
        if (pk_integrator_to(&p->it, times[written]) < 0)
            break;
        row(p, rows + (2 + 2 * p->n) * written);
    }
    return written;
}

int probe_status(const struct probe *p, char *reason, size_t size)
{
    pk_integrator_reason(&p->it, reason, size);
    return p->it.status;
}

void probe_state(const struct probe *p, double *out) { row(p, out); }

void probe_counts(const struct probe *p, unsigned long *out)
{
    out[0] = p->it.count.steps;
    out[1] = p->it.count.evaluations;
}

int probe_acceleration(const struct probe *p, double t, const double *q, const double *v,
                       double *a)
{
    return p->problem.system->acceleration(p->params, t, q, v, NULL, a);
}
