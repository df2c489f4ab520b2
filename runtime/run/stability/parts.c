/* Functions that several answers use. */
#include "stability.h"

#include "../settings/settings.h"

void stability_energies(struct pk_stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size)
{
    const struct pk_system *system = s->problem.system;
    double *p = s->work + 2 * s->n, *pdot = p + s->n;
    *vp = 0;
    if (s->by_norm) {
        for (size_t i = 0; i < s->n; i++) {
            const double x = stability_idle(s, i) || !s->reach || !(s->reach[i] > 0)
                                 ? 0
                                 : stability_apart(s, q, v, i) / s->reach[i];
            *vp += x * x / 2;
        }
        *energy = *size = *vp;
        return;
    }
    (system->unconstrained ? system->unconstrained : system->canonical)(s->problem.params, t, q, v,
                                                                        s->settings->u, p, pdot);
    *energy = system->energy(s->problem.params, t, q, v, s->settings->u);
    for (size_t i = 0; i < s->coordinates + 3 * system->n_rotations; i++)
        *vp += v[i] * p[i];
    *size = fabs(*vp) + fabs(*vp - *energy);
}

struct pk_integrator *stability_begin(struct pk_stability *s, const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status)
{
    struct memory *memory = &s->run->memory;
    const size_t size = pk_integrator_size(&s->problem, method);
    struct pk_integrator *it = memory_take(memory, 1, sizeof *it + size);
    *status = pk_integrator_init(it, &s->problem, method, options, 0, q, v, it + 1, size);
    if (*status >= 0)
        return it;
    pk_integrator_free(it);
    memory_drop(memory, it);
    return NULL;
}

void stability_end(struct pk_stability *s, struct pk_integrator *it)
{
    if (!it)
        return;
    pk_integrator_free(it);
    memory_drop(&s->run->memory, it);
}

int stability_wrong(struct pk_stability *s, const char *message)
{
    run_say(s->run, "%s", message);
    return 0;
}

const struct pk_method *stability_method(struct pk_stability *s, const char *name)
{
    const struct pk_method *method = run_method_find(s->run->model, name);
    if (method && !(method->traits & PK_ADAPTIVE))
        return method;
    run_say(s->run, "no method of a fixed step: %s", name ? name : "");
    return NULL;
}
