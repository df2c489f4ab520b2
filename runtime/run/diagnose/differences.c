/* The derivative of one step by differences of fourth order: the run's own method repeats the step
 * from four neighbours. This includes projections on constraints, steps on SO(3), and noise, which
 * is the same in each. Displacements are a thousandth of the largest numbers of the motion, so that
 * the error is about 1e-12 of the derivative in double. */
#include <pk/constraint.h>

#include "../../src/core/internal.h"
#include "../settings/settings.h"
#include "tape.h"

#define PART PK_C(1e-3)
/* largest change of a time, in units of the step */
#define PART_OF_STEP PK_C(1e-2)

struct pk_options differences_options(const struct pk_run *run, pk_real h)
{
    struct pk_options options = run->settings.options;
    options.h = h;
    options.max_steps = 0;
    if (!pk_is_fixed(run->settings.method)) {
        options.h_max = h;
        options.atol = PK_C(1e10);                     /* no error is too large */
        if (!(run->settings.method->traits & PK_JETS)) /* whose order follows from rtol */
            options.rtol = options.atol;
        options.newton_tol = 8 * PK_EPSILON;
    }
    return options;
}

void differences_make(struct differences *d, struct pk_run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    const size_t n = s->n, m = system->n_inputs;
    d->run = run;
    d->n = n;
    d->n_q = settings_coordinates(s);
    d->params = memory_take(&run->memory, system->params_size, 1);
    memcpy(d->params, s->params, system->params_size);
    d->q = memory_take(&run->memory, 6 * n + 2 * m, sizeof *d->q);
    d->v = d->q + n;
    d->scale = d->v + n;
    d->found = d->scale + 2 * n;
    d->u = d->found + 2 * n + m;
    d->input = (struct pk_constant_input){d->u, m};
    d->problem = (struct pk_problem){
        .system = system, .params = d->params, .input = pk_constant_input, .context = &d->input};
    d->size = pk_integrator_size(&d->problem, s->method);
    d->block = memory_take(&run->memory, d->size, 1);
}

void differences_place(struct differences *d, const pk_real *row)
{
    const struct pk_system *system = d->problem.system;
    const struct tape *tape = d->run->tape;
    memcpy(d->params, d->run->settings.params, system->params_size);
    if (tape->n_sides)
        memcpy((char *)d->params + system->switches.sides, row + tape->width - tape->n_sides,
               tape->n_sides * sizeof *row);
    pk_copy(d->q, row + TAPE_STATE, 2 * d->n); /* d->v follows d->q */
    pk_copy(d->u, row + TAPE_STATE + 4 * d->n, d->input.count);
}

/* Finds the largest size of each number of the state. A number that hardly moves takes part of that
 * of others. */
static void measure(struct differences *d)
{
    const struct tape *tape = d->run->tape;
    const size_t n = d->n;
    for (size_t k = 0; k < tape->count; k++)
        for (size_t i = 0; i < 2 * n; i++)
            d->scale[i] = pk_max(d->scale[i], pk_abs(tape_row(tape, k)[TAPE_STATE + i]));
    d->measured = 1;
    for (size_t half = 0; half < 2; half++) {
        const pk_real least = PART * pk_largest(d->scale + half * n, n);
        for (size_t i = half * n; i < (half + 1) * n; i++)
            d->scale[i] = pk_max(d->scale[i], least);
    }
}

static pk_real *parameter(const struct differences *d, size_t k)
{
    const struct pk_parameter *of = &d->problem.system->parameters[k];
    return (pk_real *)(void *)((char *)d->params + of->offset);
}

/* Returns the factor that scales a displacement to the step of differences. */
static pk_real scaled(struct differences *d, const pk_real *row, const struct shift *shift)
{
    const struct pk_system *system = d->problem.system;
    const pk_real h = d->run->settings.options.h > 0 ? d->run->settings.options.h
                                                     : row[TAPE_T1] - row[TAPE_T0];
    pk_real most = PART / PART_OF_STEP * pk_max(pk_abs(shift->t0), pk_abs(shift->t1)) / h;
    const double *D = shift->D;
    if (!d->measured)
        measure(d);
    differences_place(d, row);
    for (size_t i = 0; D && i < 2 * d->n; i++)
        if (d->scale[i] > 0)
            most = pk_max(most, pk_abs((pk_real)D[i]) / d->scale[i]);
    for (size_t j = 0; D && j < system->n_inputs + system->n_parameters; j++) {
        const pk_real x = j < system->n_inputs ? d->u[j] : *parameter(d, j - system->n_inputs);
        const pk_real change = pk_abs((pk_real)D[2 * d->n + j]);
        most = pk_max(most, x > 0 || x < 0 ? change / pk_abs(x) : change);
    }
    return most > 0 ? PART / most : PART;
}

/* Makes a step from (d->q, d->v) at t0 to t. `moved`: the start is projected onto the constraints. */
static enum pk_status step(struct differences *d, size_t row, pk_real t0, pk_real t, int moved)
{
    struct pk_integrator *it = &d->it;
    const int goes = t > t0 || t < t0;
    const struct pk_options options = differences_options(d->run, goes ? pk_abs(t - t0) : 1);
    if (!it->own)
        PK_TRY(pk_integrator_init(it, &d->problem, d->run->settings.method, &options, t0, d->q,
                                  d->v, d->block, d->size));
    if (moved)
        PK_TRY(pk_constraint_project(it, t0, d->q, d->v));
    it->options = options;
    it->count.steps = row; /* the same noise */
    if (!goes)
        return PK_DONE;
    PK_TRY(pk_integrator_reset(it, t0, d->q, d->v));
    const enum pk_status status = pk_integrator_to(it, t);
    pk_copy(d->q, it->q, d->n_q);
    pk_copy(d->v, it->v, d->n);
    return status;
}

enum pk_status differences_step(struct differences *d, size_t row, pk_real t)
{
    const pk_real *at = tape_row(d->run->tape, row);
    differences_place(d, at);
    return step(d, row, at[TAPE_T0], t, 0);
}

/* Makes the jump of the event at the end of a step, by the actor of the run. */
static enum pk_status act(struct differences *d, size_t row, pk_real t)
{
    struct pk_actor *actor = &d->run->actor;
    struct pk_integrator *it = &d->it;
    const struct pk_part_contacts *contacts = &d->problem.system->contacts;
    const struct tape *tape = d->run->tape;
    const size_t which = (size_t)tape_row(tape, row)[TAPE_MARK] - 1;
    actor->params = d->params;
    actor->u = d->u;
    actor->events = NULL;
    actor->crowd = 0;
    actor->happened[which] = 1;
    for (size_t k = 0; k < contacts->n; k++)
        actor->seen[k].rests = d->u[contacts->table[k].mode] > 0 ? 0 : (pk_real)NAN;
    PK_TRY(step(d, row, t, t, 1));
    PK_TRY(pk_integrator_reset(it, t, d->q, d->v));
    PK_TRY(pk_actor_run(actor, it));
    pk_copy(d->q, it->q, d->n_q);
    pk_copy(d->v, it->v, d->n);
    const pk_real *after = tape_row(tape, row + 1) + TAPE_STATE + 4 * d->n;
    for (size_t k = 0; k < contacts->n; k++) { /* a neighbour has other contacts */
        const size_t mode = contacts->table[k].mode;
        if (pk_abs(d->u[mode] - after[mode]) > 0)
            return PK_NO_CONTACT;
    }
    return PK_DONE;
}

enum pk_status differences_find(struct differences *d, size_t row, pk_real t,
                                const struct shift *shift, double *out)
{
    static const pk_real offset[] = {-2, -1, 1, 2}, weight[] = {1, -8, 8, -1};
    const struct pk_system *system = d->problem.system;
    const pk_real *at = tape_row(d->run->tape, row), by = scaled(d, at, shift);
    const size_t n = d->n, m = system->n_inputs;
    if (!d->it.own) /* begins on the constraints, which a displacement leaves */
        PK_TRY(differences_step(d, row, at[TAPE_T0]));
    pk_zero(d->found, 2 * n + m);
    for (size_t s = 0; s < 4; s++) {
        const pk_real e = offset[s] * by;
        differences_place(d, at);
        if (shift->jumps)
            pk_copy(d->q, at + TAPE_STATE + 2 * n, 2 * n);
        for (size_t i = 0; shift->D && i < 2 * n; i++)
            d->q[i] += e * (pk_real)shift->D[i];
        for (size_t j = 0; shift->D && j < m; j++)
            d->u[j] += e * (pk_real)shift->D[2 * n + j];
        for (size_t k = 0; shift->D && k < system->n_parameters; k++)
            *parameter(d, k) += e * (pk_real)shift->D[2 * n + m + k];
        if (shift->D && system->prepare(d->params))
            return PK_OUT_OF_BOUNDS;
        const pk_real t0 = at[TAPE_T0] + e * shift->t0, t1 = t + e * shift->t1;
        PK_TRY(shift->jumps ? act(d, row, t1) : step(d, row, t0, t1, shift->D != NULL));
        pk_add(d->found, weight[s] / (12 * by), d->q, 2 * n);
        pk_add(d->found + 2 * n, weight[s] / (12 * by), d->u, m);
    }
    for (size_t i = 0; i < 2 * n + (shift->jumps ? m : 0); i++)
        out[i] = i >= d->n_q && i < n ? 0 : (double)d->found[i];
    return PK_DONE;
}
