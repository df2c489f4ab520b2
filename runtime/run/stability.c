/* Questions and their answers; see pk/stability.h. */
#define _POSIX_C_SOURCE 200809L

#include "stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void stability_energies(struct stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size)
{
    const struct pk_system *system = s->problem.system;
    double *p = s->work + 2 * s->n, *pdot = p + s->n;
    system->canonical(s->problem.params, t, q, v, s->settings->u, p, pdot);
    *energy = system->energy(s->problem.params, t, q, v, s->settings->u);
    *vp = 0;
    for (size_t i = 0; i < s->n; i++)
        *vp += v[i] * p[i];
    *size = fabs(*vp) + fabs(*vp - *energy);
}

struct pk_integrator *stability_begin(struct stability *s, const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status)
{
    struct memory *memory = &s->run->memory;
    const size_t size = pk_integrator_size(&s->problem, method);
    struct pk_integrator *it = (struct pk_integrator *)memory_take(memory, 1, sizeof *it + size);
    *status = pk_integrator_init(it, &s->problem, method, options, 0, q, v, it + 1, size);
    if (*status >= 0)
        return it;
    pk_integrator_free(it);
    memory_drop(memory, it);
    return NULL;
}

void stability_end(struct stability *s, struct pk_integrator *it)
{
    if (!it)
        return;
    pk_integrator_free(it);
    memory_drop(&s->run->memory, it);
}

int stability_wrong(struct stability *s, const char *message)
{
    run_say(s->run, "%s", message);
    return 0;
}

const struct pk_method *stability_method(struct stability *s, const char *name)
{
    const struct pk_method *method = run_method_find(name);
    if (method && !(method->traits & PK_ADAPTIVE))
        return method;
    run_say(s->run, "no method of a fixed step: %s", name ? name : "");
    return NULL;
}

/* Memory for all questions; 0: there is none. */
static int prepare(struct stability *s)
{
    struct memory *memory = &s->run->memory;
    const size_t n = s->run->settings.n;
    if (setjmp(memory->none))
        return 0;
    s->n = n;
    s->run->settings.bare = 1;
    s->run->settings.options.stop = run_ending;
    s->problem = run_problem(s->run);
    s->work = (double *)memory_take(memory, 4 * n + 1, sizeof *s->work);
    s->far = (double *)memory_take(memory, 3 * n, sizeof *s->far);
#ifdef PK_WITH_GSL
    s->modes = (struct pk_mode *)memory_take(memory, 2 * n, sizeof *s->modes);
#endif
    s->shapes = (double *)memory_take(memory, 4 * n * n, sizeof *s->shapes);
    return 1;
}

struct pk_stability *pk_stability_new(const struct pk_run_model *model,
                                      const struct pk_run_settings *settings)
{
    struct stability *s = (struct stability *)calloc(1, sizeof *s);
    struct run *run = (struct run *)pk_run_new(model, settings);
    if (s && run) {
        s->run = run;
        s->settings = &run->settings;
        if (run->code || prepare(s))
            return (struct pk_stability *)s;
    }
    free(s);
    pk_run_free((struct pk_run *)run);
    return NULL;
}

static const struct {
    const char *what;
    int (*answer)(struct stability *s, const struct pk_stability_question *q);
} answers[] = {{"start", stability_ready},           {"motion", stability_motion},
#ifdef PK_WITH_GSL
               {"equilibria", stability_equilibria}, {"near", stability_near},
               {"leave", stability_leave},
#endif
               {"point", stability_point},           {"oscillator", stability_oscillator}};

/* 1 where there is an answer. */
static int answer(struct stability *s, const char *what,
                  const struct pk_stability_question *question)
{
    if (s->run->code || setjmp(s->run->memory.none))
        return 0;
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++) {
        if (strcmp(answers[i].what, what) != 0)
            continue;
        s->out = run_text(s->run, &s->answer);
        return answers[i].answer(s, question);
    }
    run_say(s->run, "cannot be asked: %s", what);
    return 0;
}

const char *pk_stability_ask(struct pk_stability *of, const char *what,
                             const struct pk_stability_question *question)
{
    struct stability *s = (struct stability *)of;
    free(s->answer);
    s->answer = NULL;
    const int good = answer(s, what, question);
    run_text_end(s->run);
    return good ? s->answer : NULL;
}

const char *pk_stability_wrong(const struct pk_stability *of)
{
    const struct stability *s = (const struct stability *)of;
    return s->run->said ? s->run->said : "out of memory\n";
}

void pk_stability_free(struct pk_stability *of)
{
    struct stability *s = (struct stability *)of;
    if (!s)
        return;
    if (s->exact)
        pk_integrator_free(s->exact);
    pk_run_free((struct pk_run *)s->run);
    free(s->answer);
    free(s);
}
