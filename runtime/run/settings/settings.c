/* Converts the caller's settings to those that the run uses. Sizes of families come first, since
 * the number of other values depends on them; then parameters (defaults, given and derived values);
 * then the initial state, which is computed from the parameters and overridden by given values.
 * Each step returns NULL, or a message if a setting is wrong. */
#include "settings.h"

struct pk_run_settings pk_run_defaults(void)
{
    const struct pk_options o = pk_options_default();
    return (struct pk_run_settings){.every = -1,
                                    .rtol = (double)o.rtol,
                                    .atol = (double)o.atol,
                                    .max_steps = o.max_steps,
                                    .land = -1,
                                    .first_member = 1,
                                    .csv = -1,
                                    .header = 1};
}

static void *copy(struct settings *s, const void *from, size_t count, size_t size)
{
    void *to = memory_take(s->memory, count, size);
    if (count)
        memcpy(to, from, count * size);
    return to;
}

static const char *text(struct settings *s, const char *from)
{
    return from ? copy(s, from, strlen(from) + 1, 1) : NULL;
}

/* Replaces the caller's lists and texts by copies. */
static const char *lists(struct settings *s)
{
    struct pk_run_settings *x = &s->asked;
#define COPY_LIST(list, count) x->list = x->list ? copy(s, x->list, count, sizeof *x->list) : NULL
#define COPY(list) COPY_LIST(list, x->n_##list)
    COPY(sizes), COPY(parameters), COPY(inputs), COPY(q), COPY(v), COPY(columns), COPY(hidden);
    COPY(expected), COPY(drifts), COPY(member_columns), COPY(reduced), COPY(stops);
    COPY_LIST(member_values, x->members * x->n_member_columns);
    x->method = text(s, x->method);
    x->member_name = text(s, x->member_name ? x->member_name : "member");
    x->checkpoint = text(s, x->checkpoint);
    x->checkpoint_note = text(s, x->checkpoint_note);
    struct pk_run_part *parts = x->n_parts ? copy(s, x->parts, x->n_parts, sizeof *parts) : NULL;
    for (size_t k = 0; k < x->n_parts; k++)
        parts[k].method = text(s, parts[k].method);
    x->parts = parts;
    return NULL;
}

static const char *steps(struct settings *s)
{
    const struct pk_run_settings *x = &s->asked;
    if (x->n_parts && x->n_parts != s->n_parts)
        return "there is no such part, or no such method of one";
    for (size_t k = 0; x->parts && k < s->n_parts; k++)
        if (x->parts[k].method && !run_method_find(s->run->model, x->parts[k].method))
            return "there is no such part, or no such method of one";
    s->options = pk_options_default();
    s->options.words = &run_options;
    s->options.h = (pk_real)x->step;
    s->options.rtol = (pk_real)x->rtol;
    s->options.atol = (pk_real)x->atol;
    s->options.h_min = (pk_real)x->h_min;
    s->options.h_max = (pk_real)x->h_max;
    s->options.max_steps = x->max_steps;
    s->options.iteration = x->fixed_point ? PK_FIXED_POINT : PK_NEWTON;
    s->options.seed = x->seed;
    s->until = (pk_real)x->until;
    s->every = (pk_real)x->every;
    if (!(x->until > 0) || !isfinite(x->until))
        return "`until` must be positive";
    if (!(x->step >= 0) || !(x->rtol >= 0) || !(x->h_min >= 0) || !(x->h_max >= 0))
        return "steps and tolerances must not be negative";
    return NULL;
}

static const pk_real *numbers(struct settings *s, const double *from, size_t count)
{
    pk_real *to = memory_take(s->memory, count, sizeof *to);
    for (size_t i = 0; i < count; i++)
        to[i] = (pk_real)from[i];
    return to;
}

/* Copies the data of tables, and sets the pointers to them in the params. */
static const char *tables(struct settings *s)
{
    for (size_t k = 0; k < s->asked.n_tables; k++) {
        const struct pk_run_table x = s->asked.tables[k];
        if (!PK_SYSTEM_HAS(s->system, n_tables) || x.index >= s->system->n_tables)
            return "there is no such table";
        struct pk_table *table = memory_take(s->memory, 1, sizeof *table);
        table->axes[0] = (struct pk_table_axis){x.count_x, numbers(s, x.x, x.count_x),
                                                (pk_real)x.period_x, x.strict};
        table->axes[1] = (struct pk_table_axis){x.count_y, numbers(s, x.y, x.count_y),
                                                (pk_real)x.period_y, x.strict};
        table->c = numbers(s, x.c, x.coefficients);
        const struct pk_table *const found = table;
        memcpy((char *)s->params + s->system->tables[x.index], &found, sizeof found);
    }
    return NULL;
}

/* Sets the sizes of families, allocates the memory that depends on them, and sets all defaults. */
static const char *sizes(struct settings *s)
{
    const struct pk_system *system = s->system;
    if (system->families.set_sizes)
        system->families.set_sizes(s->params);
    for (size_t k = 0; k < s->asked.n_sizes; k++) {
        const struct pk_run_value x = s->asked.sizes[k];
        if (x.index >= system->families.n_sizes || !(x.value >= 1) ||
            !(x.value < (double)(PTRDIFF_MAX / 64)))
            return "there is no such size";
        const ptrdiff_t length = (ptrdiff_t)x.value;
        memcpy((char *)s->params + system->families.sizes[x.index].offset, &length, sizeof length);
    }
    if (system->families.attach) {
        s->families_size = system->families.block_size(s->params);
        s->families = memory_take(s->memory, s->families_size, 1);
        system->families.attach(s->params, s->families);
    }
    s->n = pk_system_count(system, s->params);
    s->q = memory_take(s->memory, 2 * s->n, sizeof *s->q);
    s->v = s->q + s->n;
    s->start_given = memory_take(s->memory, 2 * s->n, 1);
    system->defaults(s->params);
    return tables(s);
}

static struct pk_range range_of(const struct settings *s, size_t parameter)
{
    struct pk_range range = {0, 1, 0};
    if (s->system->families.range)
        s->system->families.range(s->params, PK_OF_PARAMETER, parameter, &range);
    return range;
}

static int has_value(const struct pk_run_value *given, size_t n_given, size_t parameter)
{
    for (size_t k = 0; k < n_given; k++)
        if (given[k].index == parameter)
            return 1;
    return 0;
}

/* Sets the value of a parameter, or the values of those members of a family that are given. Returns
 * 0 if the index of a member is out of range. */
static int set(const struct settings *s, void *params, const struct pk_run_value *given,
               size_t n_given, size_t parameter)
{
    const struct pk_range range = range_of(s, parameter);
    void *const place = (char *)params + s->system->parameters[parameter].offset;
    pk_real *values = place;
    if (range.is_family)
        memcpy(&values, place, sizeof values);
    for (size_t k = 0; k < n_given; k++) {
        if (given[k].index != parameter)
            continue;
        if (given[k].member >= range.count)
            return 0;
        values[given[k].member] = (pk_real)given[k].value;
    }
    return 1;
}

int settings_assign(struct settings *s, void *params, const struct pk_run_value *more,
                    size_t n_more)
{
    const struct pk_system *system = s->system;
    const struct pk_run_value *asked = s->asked.parameters;
    const size_t n = s->asked.n_parameters;
    for (size_t k = 0; k < n + n_more; k++) {
        const struct pk_run_value x = k < n ? asked[k] : more[k - n];
        if (x.index >= system->n_parameters || !isfinite(x.value))
            return 0;
    }
    memset(s->given, 0, system->n_parameters);
    for (int families = 0; families < 2; families++)
        for (size_t at = 0; at < system->n_parameters; at++) {
            if (!has_value(asked, n, at) && !has_value(more, n_more, at))
                continue;
            if (range_of(s, at).is_family != families)
                continue;
            /* Defaults of members come before given values, and may depend on earlier families. */
            if (families)
                system->derive(params, s->given);
            if (!set(s, params, asked, n, at) || !set(s, params, more, n_more, at))
                return 0;
            s->given[at] = 1;
        }
    system->derive(params, s->given);
    return 1;
}

static const char *parameters(struct settings *s)
{
    return settings_assign(s, s->params, NULL, 0) ? NULL : "there is no such parameter";
}

/* Copies given values to inputs or to the initial state; for the initial state, also sets `flags`.
 * Returns 0 if an index is out of range. */
static int take(const struct pk_run_value *x, size_t n_x, pk_real *to, size_t n,
                unsigned char *flags)
{
    for (size_t k = 0; k < n_x; k++) {
        if (x[k].index >= n || (flags && !isfinite(x[k].value)))
            return 0;
        to[x[k].index] = (pk_real)x[k].value;
        if (flags)
            flags[x[k].index] = 1;
    }
    return 1;
}

static const char *start(struct settings *s)
{
    const struct pk_run_settings *x = &s->asked;
    const size_t n = s->n;
    unsigned char *const given = s->start_given;
    s->system->start(s->params, s->q, s->v);
    for (size_t k = 0; s->system->samples.held && k < x->n_inputs; k++)
        if (x->inputs[k].index < s->system->n_inputs && s->system->samples.held[x->inputs[k].index])
            return "an input that a sample block sets has no value of its own";
    return take(x->inputs, x->n_inputs, s->u, s->system->n_inputs, NULL) &&
                   take(x->q, x->n_q, s->q, n, given) && take(x->v, x->n_v, s->v, n, given + n)
               ? NULL
               : "there is no such start or input";
}

/* Returns the number of quantities of the model that a column of this kind may show. */
static size_t count_of(const struct settings *s, char kind)
{
    const struct pk_system *system = s->system;
    return kind == 'q' || kind == 'v' ? s->n
           : kind == 'o'              ? pk_system_outputs(system, s->params)
           : kind == 'i'              ? system->n_inputs
           : kind == 'p'              ? system->n_parameters
                                      : kind == 'e' && system->energy;
}

static int is_column(const struct settings *s, struct pk_run_column c)
{
    return c.index < count_of(s, c.kind);
}

/* Sets the columns of rows to the requested ones, or to all that are not hidden. */
static const char *columns(struct settings *s)
{
    static const char kinds[] = "qvoe";
    const struct pk_run_settings *x = &s->asked;
    size_t all = 0;
    s->n_show = x->n_columns;
    s->show = s->n_show ? copy(s, x->columns, s->n_show, sizeof *s->show) : NULL;
    for (size_t i = 0; i < s->n_show; i++)
        if (!is_column(s, s->show[i]))
            return "there is no such column or event";
    if (s->n_show)
        return NULL;
    for (const char *kind = kinds; *kind; kind++)
        all += count_of(s, *kind);
    s->show = memory_take(s->memory, all, sizeof *s->show);
    for (const char *kind = kinds; *kind; kind++) {
        const size_t count = *kind == 'q' ? settings_coordinates(s) : count_of(s, *kind);
        for (size_t i = 0; i < count; i++) {
            int hidden = 0;
            for (size_t j = 0; *kind == 'o' && j < x->n_hidden; j++)
                hidden |= x->hidden[j] == i;
            if (!hidden)
                s->show[s->n_show++] = (struct pk_run_column){*kind, i, 0};
        }
    }
    return NULL;
}

static const char *expectations(struct settings *s)
{
    static const char none[] = "there is no such column or event";
    const struct pk_run_settings *asked = &s->asked;
    s->expected = memory_take(s->memory, asked->n_expected, sizeof *s->expected);
    s->drifting = memory_take(s->memory, asked->n_drifts, sizeof *s->drifting);
    for (size_t i = 0; i < asked->n_expected; i++) {
        const struct pk_run_expected *x = &asked->expected[i];
        if (!strchr("=<>", x->relation) || !strchr("rte", x->when) || !is_column(s, x->a) ||
            !is_column(s, x->b) || (x->within.kind && !is_column(s, x->within)) ||
            (x->when == 'e' && x->event >= s->system->events.n))
            return none;
        s->expected[i].of = *x;
    }
    for (size_t i = 0; i < asked->n_drifts; i++) {
        const struct pk_run_column c = asked->drifts[i];
        s->drifting[i].energy = c.kind == 'e';
        s->drifting[i].output = c.index;
        if (c.kind == 'o' && !is_column(s, c))
            return none;
    }
    return asked->at > s->system->events.n ? none : NULL;
}

static const char *members(struct settings *s)
{
    const struct pk_run_settings *x = &s->asked;
    const unsigned char *held = s->system->samples.held;
    for (size_t i = 0; i < x->n_member_columns; i++)
        if (x->member_columns[i].kind == 'i' && held && held[x->member_columns[i].index])
            return "members have no column of an input that a sample block sets";
        else if (!strchr("piqv", x->member_columns[i].kind) || !is_column(s, x->member_columns[i]))
            return "members have no such column";
    return NULL;
}

static const char *reductions(struct settings *s)
{
    const struct pk_run_settings *x = &s->asked;
    for (size_t i = 0; i < x->n_reduced; i++) {
        const char what = x->reduced[i].what;
        const size_t count = what == 'n' || what == 't' ? x->watch ? s->system->events.n : 0
                             : what == 'l'              ? x->watch > 0 && !s->system->samples.n
                             : what == 'd'              ? x->n_drifts
                             : what == 'x'              ? x->n_expected
                             : strchr("fMma", what)     ? s->n_show
                                                        : 0;
        if (!(x->reduced[i].index < count))
            return "members have no such number";
    }
    return NULL;
}

static const char *prepare(struct settings *s)
{
    struct pk_run *run = s->run;
    run->refused = s->system->prepare(s->params);
    if (run->refused)
        settings_refused(run, s->params, run->refused,
                         PK_FAILURE(run->refused) == PK_FAILURE_PARAMETER ? "parameter " : "");
    return run->refused ? "" : NULL;
}

/* Returns which table of functions these settings need and the program lacks, or NULL. */
static const char *lack(const struct pk_run_settings *x, const struct pk_run_model *model)
{
    int diagnoses = x->diagnose != 0;
    for (size_t k = 0; k < x->n_reduced; k++)
        diagnoses |= x->reduced[k].what == 'l';
    return diagnoses && !model->diagnose    ? "pk_run_diagnose"
           : x->members && !model->ensemble ? "pk_run_ensemble"
                                            : NULL;
}

enum pk_run_code settings_take(struct pk_run *run)
{
    const struct pk_run_model *model = run->model;
    static const char *(*const each[])(struct settings *s) = {
        lists, steps,   sizes,        parameters, prepare,
        start, columns, expectations, members,    reductions};
    struct settings *s = &run->settings;
    const struct pk_system *system = model->system;
    const char *wrong = NULL, *method = s->asked.method ? s->asked.method : "";
    *s = (struct settings){.asked = s->asked,
                           .run = run,
                           .system = system,
                           .parts = model->parts,
                           .n_parts = model->parts ? model->n_parts : 0,
                           .method = run_method_find(model, method),
                           .memory = &run->memory,
                           .control = &run->control,
                           .polls = 1};
    if (system->abi != PK_ABI)
        return run_refuse(run, "the model was compiled for another runtime: compile it anew");
    if (!s->method)
        return run_refuse(run, "there is no such method: %s%s", method, run_method_lack(method));
    if (lack(&s->asked, model))
        return run_refuse(run, "the program was linked without %s", lack(&s->asked, model));
    s->params = memory_take(s->memory, 1, system->params_size);
    s->given = memory_take(s->memory, system->n_parameters, 1);
    s->u = memory_take(s->memory, system->n_inputs, sizeof *s->u);
    for (size_t i = 0; i < sizeof each / sizeof *each && !wrong; i++)
        wrong = each[i](s);
    if (!wrong && s->asked.checkpoint)
        settings_mark(s);
    if (wrong && *wrong)
        run_say(run, "%s", wrong);
    return wrong ? PK_RUN_USAGE : PK_RUN_DONE;
}
