/* Memory, modes, parameters and initial state of a unit. */
#include "unit.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char MARK[8] = {'p', 'k', 'u', 'n', 'i', 't', '0', '1'};

enum unit_status unit_say(const struct unit *unit, enum unit_status status, const char *category,
                          const char *format, ...)
{
    char text[UNIT_LONGEST_TEXT];
    va_list rest;
    if (!unit->log || (status == UNIT_OK && !unit->logging))
        return status;
    va_start(rest, format);
    vsnprintf(text, sizeof text, format, rest);
    va_end(rest);
    unit->log(unit, status, category, text);
    return status;
}

enum unit_status unit_allowed(const struct unit *unit, const char *call, int modes)
{
    static const char *const names[] = {"instantiated",  "in initialization mode",
                                        "in event mode", "in continuous-time mode",
                                        "in step mode",  "terminated"};
    if (!unit)
        return UNIT_ERROR;
    const int mode = (int)*unit->mode;
    if (unit->busy && !(modes & UNIT_WITHIN))
        return unit_say(unit, UNIT_ERROR, "logStatusError", "%s cannot be called within a callback",
                        call);
    if (mode & modes)
        return UNIT_OK;
    size_t k = 0;
    while (mode >> (k + 1))
        k++;
    return unit_say(unit, UNIT_ERROR, "logStatusError", "%s cannot be called while the unit is %s",
                    call, names[k]);
}

/* Returns the number of doubles in the array `all`. Unless `all` is NULL, sets the pointers of unit
 * to the parts of `all`. */
static size_t lay_out(struct unit *unit, double *all)
{
    const size_t n_p = pk_host_model.n_parameters, n_u = unit->n_inputs;
    const struct {
        double **part;
        size_t count;
    } parts[] = {{&unit->mode, 1},
                 {&unit->time, 1},
                 {&unit->input_time, 1},
                 {&unit->settings, UNIT_SETTINGS},
                 {&unit->length, 1},
                 {&unit->parameters, n_p},
                 {&unit->is_set, n_p},
                 {&unit->start, unit->n_x},
                 {&unit->start_is_set, unit->n_x},
                 {&unit->y, unit->n_x},
                 {&unit->inputs, n_u},
                 {&unit->slopes, UNIT_ORDERS * n_u},
                 {&unit->sides, unit->n_switches},
                 {&unit->before, unit->n_events},
                 {&unit->anchor, unit_anchor_size(unit)}};
    size_t at = 0;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        if (all)
            *parts[k].part = all + at;
        at += parts[k].count;
    }
    return at;
}

struct unit *unit_new(const char *name, const char *token, int co_simulation)
{
    const struct unit_model *model = &unit_model;
    if (!name || !token || strcmp(token, model->token) != 0)
        return NULL;
    struct unit *unit = (struct unit *)calloc(1, sizeof *unit);
    if (!unit)
        return NULL;
    const struct pk_system *s = pk_host_model.system;
    unit->model = model;
    unit->system = s;
    unit->co_simulation = co_simulation;
    unit->n_inputs = s->n_inputs;
    unit->n_events = s->events.n;
    unit->name = (char *)malloc(strlen(name) + 1);
    unit->params = pk_host_params(1, 1);
    unit->held = calloc(1, s->params_size);
    if (!unit->name || !unit->params || !unit->held) {
        unit_free(unit);
        return NULL;
    }
    strcpy(unit->name, name);
    unit->n = pk_system_count(s, unit->params);
    unit->n_switches = pk_system_switch_count(s, unit->params);
    unit->n_q = pk_system_coordinates(s, unit->params);
    unit->n_outputs = pk_system_outputs(s, unit->params);
    unit->n_x = unit->n_q + unit->n;
    unit->n_all = lay_out(unit, NULL);
    unit->all = (double *)calloc(unit->n_all, sizeof *unit->all);
    const size_t counts[] = {unit->n, 1, unit->n_outputs, s->n_conserved};
    const size_t indicators = unit->n_events + unit->n_switches;
    size_t computed = 0;
    for (size_t k = 0; k < PK_HOST_MOMENTA; k++)
        computed += counts[k];
    double *at = (double *)calloc(computed + indicators + 2 * unit->n + 1, sizeof *at);
    unit->values[0] = at;
    if (!unit->all || !at) {
        unit_free(unit);
        return NULL;
    }
    for (size_t k = 0; k < PK_HOST_MOMENTA; at += counts[k++])
        unit->values[k] = at;
    unit->indicators = at;
    unit->near = at + indicators;
    lay_out(unit, unit->all);
    unit_reset(unit);
    return unit;
}

static void drop_integrator(struct unit *unit)
{
    free(unit->block);
    free(unit->events_block);
    unit->block = unit->events_block = NULL;
    unit->ready = 0;
}

void unit_free(struct unit *unit)
{
    if (!unit || unit->busy)
        return;
    drop_integrator(unit);
    free(unit->name);
    pk_host_params_free(unit->params);
    free(unit->held);
    free(unit->all);
    free(unit->values[0]);
    free(unit);
}

void unit_forget(struct unit *unit) { unit->known = 0; }

enum unit_status unit_reset(struct unit *unit)
{
    const struct pk_host_model *m = &pk_host_model;
    memset(unit->all, 0, unit->n_all * sizeof *unit->all);
    *unit->mode = UNIT_INSTANTIATED;
    unit->settings[UNIT_METHOD] = (double)unit->model->method;
    unit->settings[UNIT_STEP] = unit->model->step;
    unit->settings[UNIT_RTOL] = unit->model->rtol;
    for (size_t k = 0; k < m->n_parameters; k++) {
        unit->parameters[k] = m->parameters[k];
        unit->is_set[k] = !m->follows[k];
    }
    for (size_t i = 0; i < unit->n_inputs; i++)
        unit->inputs[i] = m->inputs[i];
    for (size_t i = 0; i < unit->n_x; i++) {
        unit->start[i] = isnan(m->start[i]) ? 0 : m->start[i];
        unit->start_is_set[i] = !m->start_follows[i];
    }
    unit->stale = 1;
    unit->ready = 0;
    unit_forget(unit);
    return UNIT_OK;
}

/* Sets the model's params from unit->parameters. A parameter that the importer has not set is first
 * replaced in unit->parameters by its default, which may depend on other parameters. */
static enum unit_status apply(struct unit *unit)
{
    for (size_t k = 0; k < pk_host_model.n_parameters; k++)
        if (!unit->is_set[k])
            unit->parameters[k] = (double)NAN;
    if (!pk_host_set(unit->params, unit->parameters))
        return unit_say(unit, UNIT_ERROR, "logStatusError", "%s", pk_host_why());
    memcpy(unit->held, unit->params, unit->system->params_size);
    if (!unit->co_simulation)
        unit_hold_sides(unit);
    return UNIT_OK;
}

void unit_hold_sides(struct unit *unit)
{
    char *const place = (char *)unit->held + unit->system->switches.sides;
    if (unit->n_switches && unit->system->switches.count)
        memcpy(place, &unit->sides, sizeof unit->sides);
    else if (unit->n_switches)
        memcpy(place, unit->sides, unit->n_switches * sizeof *unit->sides);
}

enum unit_status unit_refresh(struct unit *unit)
{
    if (!unit->stale)
        return UNIT_OK;
    const enum unit_status status = apply(unit);
    if (status != UNIT_OK)
        return status;
    unit->stale = 0;
    if (!((int)*unit->mode & UNIT_BEFORE))
        return UNIT_OK;
    pk_host_start(unit->params, unit->near);
    for (size_t i = 0; i < unit->n_x; i++)
        unit->y[i] = unit->start_is_set[i] ? unit->start[i] : unit->near[i];
    return UNIT_OK;
}

const void *unit_params(const struct unit *unit)
{
    return unit->co_simulation ? unit->params : unit->held;
}

enum unit_status unit_enter_initialization(struct unit *unit, double t, int with_rtol, double rtol)
{
    if (!isfinite(t))
        return unit_say(unit, UNIT_ERROR, "logStatusError", "the start time is not finite");
    if (with_rtol && unit->settings[UNIT_RTOL] == unit->model->rtol) {
        if (!(rtol > 0) || !isfinite(rtol))
            return unit_say(unit, UNIT_ERROR, "logStatusError", "the tolerance is not positive");
        unit->settings[UNIT_RTOL] = rtol;
    }
    *unit->time = *unit->input_time = t;
    *unit->mode = UNIT_INITIALIZATION;
    unit_forget(unit);
    return UNIT_OK;
}

double *unit_state(const struct unit *unit)
{
    double *state = (double *)malloc(unit->n_all * sizeof *state);
    if (state)
        memcpy(state, unit->all, unit->n_all * sizeof *state);
    return state;
}

enum unit_status unit_restore(struct unit *unit, const double *state)
{
    memcpy(unit->all, state, unit->n_all * sizeof *state);
    unit->stale = 1;
    unit->ready = 0;
    unit_forget(unit);
    return UNIT_OK;
}

size_t unit_serial_size(const struct unit *unit)
{
    return sizeof MARK + sizeof(uint64_t) + unit->n_all * sizeof(double);
}

/* Returns a hash of the model's token. unit_deserialise() refuses states with a different hash. */
static uint64_t mark_of(const struct unit *unit)
{
    uint64_t mark = unit->n_all;
    for (const char *c = unit->model->token; *c; c++)
        mark = mark * 1099511628211u ^ (unsigned char)*c;
    return mark;
}

void unit_serialise(const struct unit *unit, const double *state, unsigned char *bytes)
{
    const uint64_t mark = mark_of(unit);
    memcpy(bytes, MARK, sizeof MARK);
    memcpy(bytes + sizeof MARK, &mark, sizeof mark);
    memcpy(bytes + sizeof MARK + sizeof mark, state, unit->n_all * sizeof *state);
}

/* Returns the state; NULL if the bytes are no valid state of this model, or memory is lacking. */
double *unit_deserialise(const struct unit *unit, const unsigned char *bytes, size_t size)
{
    const uint64_t mark = mark_of(unit);
    if (size != unit_serial_size(unit) || memcmp(bytes, MARK, sizeof MARK) != 0 ||
        memcmp(bytes + sizeof MARK, &mark, sizeof mark) != 0)
        return NULL;
    double *state = unit_state(unit);
    if (!state)
        return NULL;
    memcpy(state, bytes + sizeof MARK + sizeof mark, unit->n_all * sizeof *state);
    /* The mode and the method of the state are checked, since they are used as indices. */
    const double mode = state[unit->mode - unit->all],
                 method = state[unit->settings - unit->all + UNIT_METHOD];
    const int known = mode == UNIT_INSTANTIATED || mode == UNIT_INITIALIZATION ||
                      mode == UNIT_TERMINATED ||
                      (unit->co_simulation ? mode == UNIT_STEPPING
                                           : mode == UNIT_EVENT || mode == UNIT_CONTINUOUS);
    if (known && method >= 0 && method < (double)unit->model->n_methods && method == floor(method))
        return state;
    free(state);
    return NULL;
}
