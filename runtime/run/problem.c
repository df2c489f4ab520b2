/* What is integrated, as the settings have it: the problem, and where its quadratures start. */
#include <stdlib.h>
#include <string.h>

#include "settings.h"
#include "words.h"

static void constant_input(void *context, pk_real t, pk_real *u)
{
    const struct settings *s = (const struct settings *)context;
    (void)t;
    memcpy(u, s->u, run_model->n_inputs * sizeof *u);
}

struct pk_problem settings_problem(struct settings *s)
{
    return (struct pk_problem){run_model, s->params, constant_input, s};
}

struct pk_problem settings_motion(struct settings *s)
{
    static struct pk_system bare;
    struct pk_problem problem = settings_problem(s);
    bare = *run_model;
    bare.n_quadratures = 0;
    problem.system = &bare;
    return problem;
}

int settings_shows_z(const struct settings *s)
{
    for (size_t i = 0; i < s->n_show; i++)
        if (s->show[i].kind == 'z')
            return 1;
    for (size_t i = 0; i < s->n_expected; i++)
        if (s->expected[i].a.kind == 'z' || s->expected[i].b.kind == 'z' ||
            s->expected[i].within.kind == 'z')
            return 1;
    return s->n_show == 0;
}

void settings_z(const struct settings *s, const struct pk_system *system, const void *params,
                pk_real *z)
{
    memset(z, 0, system->n_quadratures * sizeof *z);
    if (system->quadrature_start)
        system->quadrature_start(params, z);
    for (size_t i = 0; i < system->n_quadratures; i++)
        if (s->start_given[2 * s->n + i])
            z[i] = s->z[i];
}

enum pk_status settings_quadratures(const struct settings *s, struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (!it->z)
        return PK_DONE;
    pk_real *z = (pk_real *)words_allocate(system->n_quadratures, sizeof *z);
    settings_z(s, system, it->problem.params, z);
    const enum pk_status status = pk_integrator_set_quadratures(it, z);
    free(z);
    return status;
}
