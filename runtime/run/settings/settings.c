/* What was asked for, as the run uses it: sizes first, since they say how many numbers there are,
 * then parameters by default, those given, and those that follow; then the start, computed from
 * them, and what is given of it.
 */
#define _POSIX_C_SOURCE 200809L

#include "settings.h"

struct pk_run_settings pk_run_defaults(void)
{
    const struct pk_options o = pk_options_default();
    const struct pk_run_settings s = {.every = -1,
                                      .rtol = (double)o.rtol,
                                      .atol = (double)o.atol,
                                      .max_steps = o.max_steps,
                                      .land = -1,
                                      .first_member = 1,
                                      .csv = -1,
                                      .header = 1};
    return s;
}

/* Sizes and memory that depends on them, and all defaults. */
static int sizes(struct settings *s, const struct pk_run_settings *given)
{
    const struct pk_system *system = s->system;
    if (system->families.set_sizes)
        system->families.set_sizes(s->params);
    for (size_t k = 0; k < given->n_sizes; k++) {
        const struct pk_run_value x = given->sizes[k];
        if (x.index >= system->families.n_sizes || !(x.value >= 1) || !(x.value < PTRDIFF_MAX / 64))
            return 0;
        const ptrdiff_t length = (ptrdiff_t)x.value;
        memcpy((char *)s->params + system->families.sizes[x.index].offset, &length, sizeof length);
    }
    if (system->families.attach)
        system->families.attach(s->params,
                                memory_take(s->memory, system->families.block_size(s->params), 1));
    s->n = pk_system_count(system, s->params);
    s->q = memory_take(s->memory, 2 * s->n + system->quadratures.n, sizeof *s->q);
    s->v = s->q + s->n;
    s->z = s->v + s->n;
    s->start_given = memory_take(s->memory, 2 * s->n + system->quadratures.n, 1);
    system->defaults(s->params);
    return 1;
}

/* Sets one parameter; a member of a family only if `members`, after the dependent defaults are
 * computed. 0: there is none. */
static int parameter(struct settings *s, const struct pk_run_value *x, int members)
{
    const struct pk_system *system = s->system;
    struct pk_range range = {0, 1, 0};
    const pk_real value = (pk_real)x->value;
    pk_real *values;
    if (x->index >= system->n_parameters || !(x->value - x->value == 0))
        return 0;
    if (system->families.range)
        system->families.range(s->params, 1, x->index, &range);
    void *const place = (char *)s->params + system->parameters[x->index].offset;
    s->given[x->index] = 1;
    if (!range.is_family) {
        memcpy(place, &value, sizeof value);
        return 1;
    }
    memcpy(&values, place, sizeof values);
    if (x->member >= range.count)
        return 0;
    if (members)
        values[x->member] = value;
    return 1;
}

/* Defaults that follow. Of a family of which some members are given, the others follow first. */
static int parameters(struct settings *s, const struct pk_run_settings *given)
{
    const struct pk_system *system = s->system;
    unsigned char *whole = memory_take(s->memory, system->n_parameters, 1);
    int families = 0;
    for (size_t k = 0; k < given->n_parameters; k++) {
        struct pk_range range = {0, 1, 0};
        if (!parameter(s, &given->parameters[k], 0))
            return 0;
        const size_t i = given->parameters[k].index;
        if (system->families.range)
            system->families.range(s->params, 1, i, &range);
        families |= range.is_family;
        whole[i] = !range.is_family;
    }
    if (families) {
        system->derive(s->params, whole);
        for (size_t k = 0; k < given->n_parameters; k++)
            parameter(s, &given->parameters[k], 1);
    }
    system->derive(s->params, s->given);
    return 1;
}

static int starts(struct settings *s, const struct pk_run_value *x, size_t n_x, pk_real *to,
                  size_t n)
{
    for (size_t k = 0; k < n_x; k++) {
        if (x[k].index >= n || !(x[k].value - x[k].value == 0))
            return 0;
        to[x[k].index] = (pk_real)x[k].value;
        s->start_given[(size_t)(to - s->q) + x[k].index] = 1;
    }
    return 1;
}

static int start(struct pk_run *run, const struct pk_run_settings *given)
{
    struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    const size_t n = s->n, quadratures = system->quadratures.n;
    pk_real *q = memory_take(s->memory, 2 * n, sizeof *q);
    system->start(s->params, q, q + n);
    memcpy(s->q, q, 2 * n * sizeof *q);
    memory_drop(s->memory, q);
    for (size_t k = 0; k < given->n_inputs; k++) {
        if (given->inputs[k].index >= system->n_inputs)
            return 0;
        s->u[given->inputs[k].index] = (pk_real)given->inputs[k].value;
    }
    return starts(s, given->q, given->n_q, s->q, n) && starts(s, given->v, given->n_v, s->v, n) &&
           starts(s, given->z, given->n_z, s->z, quadratures);
}

static int is_column(const struct settings *s, struct pk_run_column c)
{
    const struct pk_system *system = s->system;
    const size_t count = c.kind == 'q' || c.kind == 'v' ? s->n
                         : c.kind == 'o'                ? system->n_observed
                         : c.kind == 'z'                ? system->quadratures.n
                         : c.kind == 'i'                ? system->n_inputs
                         : c.kind == 'p'                ? system->n_parameters
                                                        : c.kind == 'e' && system->energy;
    return c.index < count;
}

static void *copy(struct settings *s, const void *from, size_t count, size_t size)
{
    void *to = memory_take(s->memory, count, size);
    if (count)
        memcpy(to, from, count * size);
    return to;
}

/* The columns of rows: those asked for, or all that are not hidden. */
static int columns(struct settings *s, const struct pk_run_settings *given)
{
    const struct pk_system *system = s->system;
    const size_t q = pk_system_coordinates(system, s->params);
    const size_t counts[] = {q, s->n, system->n_observed, system->quadratures.n,
                             system->energy != NULL};
    size_t all = 0;
    s->n_show = given->n_columns;
    s->show = (struct pk_run_column *)copy(s, given->columns, s->n_show, sizeof *s->show);
    for (size_t i = 0; i < s->n_show; i++)
        if (!is_column(s, s->show[i]))
            return 0;
    if (s->n_show)
        return 1;
    for (size_t k = 0; k < 5; k++)
        all += counts[k];
    s->show = memory_take(s->memory, all, sizeof *s->show);
    for (size_t k = 0; k < 5; k++)
        for (size_t i = 0; i < counts[k]; i++) {
            int hidden = 0;
            for (size_t j = 0; k == 2 && j < given->n_hidden; j++)
                hidden |= given->hidden[j] == i;
            if (!hidden)
                s->show[s->n_show++] = (struct pk_run_column){"qvoze"[k], i};
        }
    return 1;
}

static int expectations(struct settings *s, const struct pk_run_settings *given)
{
    s->n_expected = given->n_expected;
    s->n_drifting = given->n_drifts;
    s->expected = memory_take(s->memory, s->n_expected, sizeof *s->expected);
    s->drifting = memory_take(s->memory, s->n_drifting, sizeof *s->drifting);
    for (size_t i = 0; i < s->n_expected; i++) {
        const struct pk_run_expected *x = &given->expected[i];
        if (!strchr("=<>", x->relation) || !strchr("rte", x->when) || !is_column(s, x->a) ||
            !is_column(s, x->b) || (x->within.kind && !is_column(s, x->within)) ||
            (x->when == 'e' && x->event >= s->system->events.n))
            return 0;
        s->expected[i].of = *x;
    }
    for (size_t i = 0; i < s->n_drifting; i++) {
        const struct pk_run_column c = given->drifts[i];
        s->drifting[i].energy = c.kind == 'e';
        s->drifting[i].output = c.index;
        if (c.kind == 'o' && !is_column(s, c))
            return 0;
    }
    return 1;
}

static int members(struct settings *s, const struct pk_run_settings *given)
{
    s->members = given->members;
    s->threads = given->threads;
    s->watch = given->watch;
    s->n_columns = given->n_member_columns;
    s->first_member = given->first_member;
    const char *name = given->member_name ? given->member_name : "member";
    s->member_name = (const char *)copy(s, name, strlen(name) + 1, 1);
    s->columns = (const struct pk_run_column *)copy(s, given->member_columns, s->n_columns,
                                                    sizeof *s->columns);
    for (size_t i = 0; i < s->n_columns; i++)
        if (!strchr("piqvz", s->columns[i].kind) || !is_column(s, s->columns[i]))
            return 0;
    s->values =
        (const double *)copy(s, given->member_values, s->members * s->n_columns, sizeof *s->values);
    return 1;
}

static int methods(struct settings *s, const struct pk_run_model *model,
                   const struct pk_run_settings *given)
{
    s->method = run_method_find(given->method);
    s->parts = model->parts;
    s->n_parts = model->parts ? model->n_parts : 0;
    if (given->n_parts && given->n_parts != s->n_parts)
        return 0;
    if (given->n_parts)
        s->part_given =
            (const struct pk_run_part *)copy(s, given->parts, s->n_parts, sizeof *given->parts);
    for (size_t k = 0; s->part_given && k < s->n_parts; k++)
        if (s->part_given[k].method && !run_method_find(s->part_given[k].method))
            return 0;
    s->options.h = (pk_real)given->step;
    s->options.rtol = (pk_real)given->rtol;
    s->options.atol = (pk_real)given->atol;
    s->options.h_min = (pk_real)given->h_min;
    s->options.h_max = (pk_real)given->h_max;
    s->options.max_steps = given->max_steps;
    s->options.iteration = given->fixed_point ? PK_FIXED_POINT : PK_NEWTON;
    return s->method != NULL;
}

static enum pk_run_code refused(struct pk_run *run, const char *what)
{
    run_say(run, "%s", what);
    return PK_RUN_USAGE;
}

enum pk_run_code settings_take(struct pk_run *run, const struct pk_run_model *model,
                               const struct pk_run_settings *given)
{
    struct settings *s = &run->settings;
    const struct pk_system *system = s->system = model->system;
    if (system->abi != PK_ABI)
        return refused(run, "the model was compiled for another runtime: compile it anew");
    s->memory = &run->memory;
    s->control = &run->control;
    s->control->poll = given->poll;
    s->control->context = given->context;
    s->control->cap = given->cap;
    s->polls = 1;
    s->until = (pk_real)given->until;
    s->every = (pk_real)given->every;
    s->land = given->land;
    s->bare = given->bare;
    s->compared = given->compared;
    s->at = given->at;
    s->diagnose = given->diagnose;
    s->header = given->header;
    s->options = pk_options_default();
    s->options.words = &run_options;
    s->params = memory_take(s->memory, 1, system->params_size);
    s->given = memory_take(s->memory, system->n_parameters, 1);
    s->u = memory_take(s->memory, system->n_inputs, sizeof *s->u);
    if (!methods(s, model, given)) {
        run_say(run,
                s->method ? "there is no such part, or no such method of one"
                          : "there is no such method: %s",
                given->method ? given->method : "");
        return PK_RUN_USAGE;
    }
    if (!(given->until > 0) || !(given->until - given->until == 0))
        return refused(run, "`until` must be positive");
    if (!(given->step >= 0) || !(given->rtol >= 0) || !(given->h_min >= 0) || !(given->h_max >= 0))
        return refused(run, "steps and tolerances must not be negative");
    if (!sizes(s, given))
        return refused(run, "there is no such size");
    if (!parameters(s, given))
        return refused(run, "there is no such parameter");
    const int outside = run->refused = system->prepare(s->params);
    if (outside) {
        char *text = NULL;
        FILE *file = run_text(run, &text);
        parameters_refused(file, system, s->params, outside);
        run_text_end(run);
        run_say(run, "%s%s", PK_FAILURE(outside) == PK_FAILURE_PARAMETER ? "parameter " : "", text);
        free(text);
        return PK_RUN_USAGE;
    }
    if (!start(run, given))
        return refused(run, "there is no such start or input");
    if (!columns(s, given) || !expectations(s, given) || s->at > system->events.n)
        return refused(run, "there is no such column or event");
    if (!members(s, given))
        return refused(run, "members have no such column");
    return PK_RUN_DONE;
}
