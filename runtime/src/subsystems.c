/* Blocks of coordinates with integrators of their own, called parts; see pk/subsystems.h. The
 * memory block holds the structs of the parts, the whole state, parameters and input map of each
 * part, then the integrators, all padded for alignment. */
#include <stdio.h>
#include <string.h>

#include <pk/subsystems.h>
#include <pk/keep.h>

#include "core/internal.h"

enum { ALIGNED = 64 };

static size_t padded(size_t bytes) { return (bytes + ALIGNED - 1) / ALIGNED * ALIGNED; }

/* Families kept as loops cannot be split into parts. */
static size_t coordinates(const struct pk_system *system)
{
    return pk_system_coordinates(system, NULL);
}

static size_t state_reals(const struct pk_system *whole)
{
    return coordinates(whole) + whole->n + whole->n_inputs;
}

/* Returns the bytes of the parameters and the map of inputs. */
static size_t own_size(const struct pk_system *system)
{
    return padded(system->params_size) + padded(system->n_inputs * sizeof(size_t));
}

size_t pk_subsystems_size(const struct pk_problem *whole, const struct pk_part *parts,
                          const struct pk_choice *choices, size_t count)
{
    if (!whole || !whole->system || !parts || !choices || whole->system->abi != PK_ABI ||
        whole->system->families.count)
        return 0;
    size_t bytes = padded(count * sizeof(struct pk_subsystem)) +
                   padded(state_reals(whole->system) * sizeof(pk_real));
    for (size_t k = 0; k < count; k++) {
        const struct pk_problem problem = {.system = parts[k].system};
        if (!problem.system || problem.system->abi != PK_ABI || problem.system->families.count)
            return 0;
        const size_t size = pk_integrator_size(&problem, choices[k].method);
        if (size == 0)
            return 0;
        bytes += own_size(problem.system) + 2 * padded(size);
    }
    return bytes;
}

static enum pk_status bad(struct pk_subsystems *a, const char *why, size_t part)
{
    a->why = why;
    a->failed = part;
    return a->status = PK_BAD_ARGUMENT;
}

/* Finds the index of each name of `of` among those of the whole. Returns 0 if one is missing. */
static int find(const struct pk_quantity *of, size_t count, const struct pk_quantity *whole,
                size_t n, size_t *where)
{
    for (size_t i = 0; i < count; i++) {
        size_t k = 0;
        while (k < n && strcmp(of[i].name, whole[k].name) != 0)
            k++;
        if (k == n)
            return 0;
        where[i] = k;
    }
    return 1;
}

/* Copies the parameters with equal names, sets their flags in `given`, and derives the others. */
static int take_parameters(struct pk_subsystem *part, const struct pk_problem *whole,
                           unsigned char *given)
{
    const struct pk_system *system = part->of.system, *from = whole->system;
    system->defaults(part->params);
    for (size_t i = 0; i < system->n_parameters; i++) {
        const struct pk_parameter *to = &system->parameters[i];
        given[i] = 0;
        for (size_t k = 0; k < from->n_parameters; k++)
            if (strcmp(to->what.name, from->parameters[k].what.name) == 0) {
                memcpy((char *)part->params + to->offset,
                       (const char *)whole->params + from->parameters[k].offset, sizeof(pk_real));
                given[i] = 1;
            }
    }
    system->derive(part->params, given);
    return system->prepare(part->params);
}

static void input(void *context, pk_real t, pk_real *u)
{
    const struct pk_subsystem *part = (const struct pk_subsystem *)context;
    const struct pk_problem *whole = &part->apart->whole;
    whole->input(whole->context, t, part->u);
    for (size_t i = 0; i < part->of.system->n_inputs; i++)
        u[i] = part->u[part->inputs[i]];
}

/* Checks that each coordinate is in one part, and each input of a part in the whole. */
static enum pk_status check_parts(struct pk_subsystems *a)
{
    const struct pk_system *whole = a->whole.system;
    size_t n = 0;
    for (size_t k = 0; k < a->count; k++) {
        const struct pk_part *of = &a->parts[k].of;
        n += of->system->n;
        for (size_t i = 0; i < of->system->n; i++)
            if (of->coordinates[i] >= whole->n)
                return bad(a, "a coordinate is not of the whole", k + 1);
        if (!find(of->system->inputs, of->system->n_inputs, whole->inputs, whole->n_inputs,
                  a->parts[k].inputs))
            return bad(a, "an input is not of the whole", k + 1);
    }
    if (n != whole->n)
        return bad(a, "the parts are not the whole", 0);
    for (size_t i = 0; i < n; i++) {
        size_t times = 0;
        for (size_t k = 0; k < a->count; k++)
            for (size_t j = 0; j < a->parts[k].of.system->n; j++)
                times += a->parts[k].of.coordinates[j] == i &&
                         (i < coordinates(whole)) == (j < coordinates(a->parts[k].of.system));
        if (times != 1)
            return bad(a, "the parts are not the whole", 0);
    }
    return PK_DONE;
}

/* Copies the states of the parts into the whole state. */
static void assemble(struct pk_subsystems *a)
{
    const size_t n_q = coordinates(a->whole.system);
    for (size_t k = 0; k < a->count; k++) {
        const struct pk_subsystem *part = &a->parts[k];
        for (size_t i = 0; i < coordinates(part->of.system); i++)
            a->state[part->of.coordinates[i]] = part->there->q[i];
        for (size_t i = 0; i < part->of.system->n; i++)
            a->state[n_q + part->of.coordinates[i]] = part->there->v[i];
    }
}

static enum pk_status start(struct pk_subsystems *a, size_t k, const struct pk_choice *choice,
                            pk_real t0, const pk_real *q0, const pk_real *v0, void *block,
                            size_t size)
{
    struct pk_subsystem *part = &a->parts[k];
    const struct pk_system *system = part->of.system;
    const size_t n_q = coordinates(system), n = system->n;
    pk_real *q = a->state, *v = q + n_q; /* scratch memory until all parts have started */
    struct pk_problem problem = {.system = system, .params = part->params};
    a->failed = k + 1;
    const int outside = take_parameters(part, &a->whole, (unsigned char *)block);
    if (outside) { /* reports it as an integrator would */
        part->it.problem = problem;
        part->it.method = choice->method;
        part->it.reason.index = pk_refused_parameter(system, outside);
        return a->status = part->it.status = PK_OUT_OF_BOUNDS;
    }
    if (system->n_inputs && a->whole.input) {
        problem.input = input;
        problem.context = part;
    }
    for (size_t i = 0; i < n_q; i++)
        q[i] = q0[part->of.coordinates[i]];
    for (size_t i = 0; i < n; i++)
        v[i] = v0[part->of.coordinates[i]];
    part->there = &part->it;
    a->status = pk_integrator_init(&part->it, &problem, choice->method, &choice->options, t0, q, v,
                                   block, size);
    if (a->status == PK_DONE)
        a->status = pk_integrator_init(&part->aside, &problem, choice->method, &choice->options, t0,
                                       q, v, (char *)block + padded(size), size);
    if (a->status == PK_DONE)
        a->failed = 0;
    return a->status;
}

enum pk_status pk_subsystems_init(struct pk_subsystems *a, const struct pk_problem *whole,
                                  const struct pk_part *parts, const struct pk_choice *choices,
                                  size_t count, pk_real t0, const pk_real *q0, const pk_real *v0,
                                  void *block, size_t block_size)
{
    memset(a, 0, sizeof *a);
    const size_t size = pk_subsystems_size(whole, parts, choices, count);
    if (size == 0 || !q0 || !v0 || !block)
        return bad(a, "a pointer is null, or a system of another version, or of loops", 0);
    if (block_size < size || (size_t)block % _Alignof(struct pk_subsystem) ||
        (size_t)block % _Alignof(pk_real))
        return a->status = PK_BLOCK_TOO_SMALL;
    memset(block, 0, size);
    char *at = (char *)block;
    a->whole = *whole;
    a->count = count;
    a->parts = (struct pk_subsystem *)(void *)at;
    at += padded(count * sizeof *a->parts);
    a->state = (pk_real *)(void *)at;
    at += padded(state_reals(whole->system) * sizeof(pk_real));
    for (size_t k = 0; k < count; k++) {
        struct pk_subsystem *part = &a->parts[k];
        part->of = parts[k];
        part->apart = a;
        part->u = a->state + coordinates(whole->system) + whole->system->n;
        part->params = at;
        part->inputs = (size_t *)(void *)(at + padded(parts[k].system->params_size));
        at += own_size(parts[k].system);
    }
    PK_TRY(check_parts(a));
    for (size_t k = 0; k < count; k++) {
        const struct pk_problem problem = {.system = parts[k].system};
        const size_t own = pk_integrator_size(&problem, choices[k].method);
        PK_TRY(start(a, k, &choices[k], t0, q0, v0, at, own));
        at += 2 * padded(own);
    }
    assemble(a);
    a->t = t0;
    a->q = a->state;
    a->v = a->q + coordinates(whole->system);
    return a->status;
}

static enum pk_status part_to(struct pk_subsystems *a, size_t k, pk_real t, pk_real limit)
{
    struct pk_subsystem *part = &a->parts[k];
    struct pk_integrator *it = &part->it;
    const pk_real way = t < a->t ? -1 : 1;
    const int fixed = pk_is_fixed(it->method);
    part->there = it;
    while (way * (t - it->t) > 0 && !(fixed && pk_integrator_is_at(it, t))) {
        if (pk_integrator_step(it, fixed ? pk_integrator_limit(it, t, limit) : t) != PK_DONE)
            return it->status;
        if (a->stepped)
            a->stepped(a->context, k);
    }
    if (pk_integrator_is_at(it, t))
        return PK_DONE;
    part->there = &part->aside;
    return pk_integrator_aside(it, &part->aside, t);
}

enum pk_status pk_subsystems_to(struct pk_subsystems *a, pk_real t, pk_real limit)
{
    if (a->status < 0)
        return a->status;
    for (size_t k = 0; k < a->count; k++) {
        a->status = part_to(a, k, t, limit);
        if (a->status != PK_DONE) {
            a->failed = k + 1;
            return a->status;
        }
    }
    assemble(a);
    a->t = t;
    return a->status;
}

int pk_subsystems_reason(const struct pk_subsystems *a, char *text, size_t size)
{
    const char *what = pk_status_text(a->status);
    char names[160] = "", reason[400];
    size_t used = 0;
    if (a->why && a->failed)
        return snprintf(text, size, "%s: part %zu: %s", what, a->failed, a->why);
    if (a->why || !a->failed)
        return snprintf(text, size, "%s%s%s", what, a->why ? ": " : "", a->why ? a->why : "");
    const struct pk_subsystem *part = &a->parts[a->failed - 1];
    const size_t own = coordinates(part->of.system);
    for (size_t i = 0; i < own && used < sizeof names; i++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "",
                                 part->of.system->coordinates[i].name);
    if (part->it.method)
        pk_integrator_reason(&part->it, reason, sizeof reason);
    else
        snprintf(reason, sizeof reason, "%s", what);
    return snprintf(text, size, "part %zu (%s): %s; the whole is at t = %.17g", a->failed, names,
                    reason, (double)a->t);
}

void pk_subsystems_free(struct pk_subsystems *a)
{
    for (size_t k = 0; a->parts && k < a->count; k++)
        pk_integrator_free(&a->parts[k].it), pk_integrator_free(&a->parts[k].aside);
}

enum pk_status pk_subsystems_keep(struct pk_subsystems *a, struct pk_keep *k)
{
    PK_KEEP(k, a->t);
    pk_keep(k, a->state, state_reals(a->whole.system) * sizeof *a->state);
    for (size_t i = 0; i < a->count; i++) {
        struct pk_subsystem *part = &a->parts[i];
        int aside = part->there == &part->aside;
        PK_KEEP(k, aside);
        part->there = aside ? &part->aside : &part->it;
        PK_TRY(pk_integrator_keep(&part->it, k));
        PK_TRY(pk_integrator_keep(&part->aside, k));
    }
    return PK_DONE;
}
