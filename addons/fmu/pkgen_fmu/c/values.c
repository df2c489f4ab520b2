/* Reads and sets the variables of a unit by value reference. */
#include "unit.h"

#include <math.h>
#include <string.h>

/* the bit of unit->known that says that the indicators are valid */
enum { FUNCTIONS = 1 << PK_HOST_MOMENTA };

static size_t count(const struct unit *unit, enum unit_kind kind)
{
    const struct pk_system *s = unit->system;
    switch (kind) {
    case UNIT_TIME:
        return 1;
    case UNIT_PARAMETER:
        return pk_host_model.n_parameters;
    case UNIT_INPUT:
    case UNIT_SLOPE:
        return unit->n_inputs;
    case UNIT_STATE:
    case UNIT_RATE:
        return unit->n_x;
    case UNIT_OUTPUT:
        return s->observe ? unit->n_outputs : 0;
    case UNIT_ENERGY:
        return s->energy != NULL;
    case UNIT_CLAIM:
        return s->conserve ? s->n_conserved : 0;
    case UNIT_INDICATOR:
        return unit->n_events + unit->n_switches;
    case UNIT_SETTING:
        return UNIT_SETTINGS;
    case UNIT_KINDS:
        break;
    }
    return 0;
}

static enum unit_status none(const struct unit *unit, unsigned reference)
{
    return unit_say(unit, UNIT_ERROR, "logStatusError", "there is no variable %u", reference);
}

/* Returns the values of a kind at the current state, computed if they are not yet. Returns NULL if
 * they cannot be computed at this state. */
static const double *computed(struct unit *unit, enum pk_host_kind kind)
{
    double *const out = unit->values[kind];
    if (!(unit->known >> kind & 1) &&
        !pk_host_values(unit_params(unit), (int)kind, 1, unit->time, unit->y, unit->inputs, out))
        return NULL;
    unit->known |= 1u << kind;
    return out;
}

enum unit_status unit_rates(struct unit *unit)
{
    const double *const rates = computed(unit, PK_HOST_ACCELERATIONS);
    for (size_t i = 0; i < unit->n; i++)
        if (!rates || !isfinite(rates[i]))
            return unit_say(unit, UNIT_DISCARD, "logStatusDiscard",
                            "there is no acceleration at t = %g: %s", *unit->time,
                            rates ? "it is not finite"
                                  : "the mass matrix is singular or indefinite");
    return UNIT_OK;
}

enum unit_status unit_functions(struct unit *unit)
{
    const struct pk_system *s = unit->system;
    if (unit->known & FUNCTIONS)
        return UNIT_OK;
    if (s->events.values)
        s->events.values(unit_params(unit), *unit->time, unit->y, unit_v(unit), unit->inputs,
                         unit->indicators);
    if (s->switches.values)
        s->switches.values(unit_params(unit), *unit->time, unit->y, unit_v(unit), unit->inputs,
                           unit->indicators + unit->n_events);
    unit->known |= FUNCTIONS;
    return UNIT_OK;
}

enum unit_status unit_get(struct unit *unit, unsigned reference, double *value)
{
    const enum unit_kind kind = unit_kind_of(reference);
    const size_t i = unit_index_of(reference);
    if (i >= count(unit, kind))
        return none(unit, reference);
    enum unit_status status = UNIT_OK;
    if (kind != UNIT_SETTING && kind != UNIT_INPUT && kind != UNIT_SLOPE)
        status = unit_refresh(unit);
    if (status != UNIT_OK)
        return status;
    switch (kind) {
    case UNIT_TIME:
        *value = *unit->time;
        break;
    case UNIT_PARAMETER:
        *value = unit->parameters[i];
        break;
    case UNIT_INPUT:
        *value = unit->inputs[i];
        break;
    case UNIT_SLOPE:
        *value = unit->slopes[UNIT_ORDERS * i];
        break;
    case UNIT_STATE:
        *value = unit->y[i];
        break;
    case UNIT_RATE:
        if (i >= unit->n_q)
            status = unit_rates(unit);
        *value = i < unit->n_q ? unit_v(unit)[i]
                               : unit->values[PK_HOST_ACCELERATIONS][i - unit->n_q];
        break;
    case UNIT_OUTPUT:
        *value = computed(unit, PK_HOST_OUTPUTS)[i];
        break;
    case UNIT_ENERGY:
        *value = computed(unit, PK_HOST_ENERGY)[i];
        break;
    case UNIT_CLAIM:
        *value = computed(unit, PK_HOST_CLAIMS)[i];
        break;
    case UNIT_INDICATOR:
        status = unit_functions(unit);
        *value = unit->indicators[i];
        break;
    case UNIT_SETTING:
        *value = unit->settings[i] + (i == UNIT_METHOD);
        break;
    case UNIT_KINDS:
        break;
    }
    return status;
}

static enum unit_status set_parameter(struct unit *unit, size_t k, double value)
{
    const struct pk_host_model *m = &pk_host_model;
    if (!(value >= m->lo[k] && value <= m->hi[k]))
        return unit_say(unit, UNIT_ERROR, "logStatusError",
                        "%s = %.17g is outside its bounds, from %.17g to %.17g", m->names[k], value,
                        m->lo[k], m->hi[k]);
    const int as_it_follows = m->follows[k] && value == m->parameters[k];
    if (unit->is_set[k] ? unit->parameters[k] == value : as_it_follows)
        return UNIT_OK;
    unit->is_set[k] = !as_it_follows;
    unit->parameters[k] = value;
    unit->stale = 1;
    unit->ready = 0;
    return UNIT_OK;
}

static enum unit_status set_start(struct unit *unit, size_t i, double value)
{
    const struct pk_host_model *m = &pk_host_model;
    unit->start_is_set[i] = !(m->start_follows[i] && value == m->start[i]);
    unit->start[i] = value;
    unit->stale = 1;
    return UNIT_OK;
}

static enum unit_status set_setting(struct unit *unit, size_t i, double value)
{
    static const char *const wrong[] = {"there is no such method",
                                        "the step is negative or not finite",
                                        "the tolerance is not positive and below 1"};
    const int right = i == UNIT_METHOD ? value >= 1 && value <= (double)unit->model->n_methods
                      : i == UNIT_STEP ? value >= 0 && isfinite(value)
                                       : value > 0 && value < 1;
    if (!right)
        return unit_say(unit, UNIT_ERROR, "logStatusError", "%s", wrong[i]);
    unit->settings[i] = i == UNIT_METHOD ? floor(value) - 1 : value;
    return UNIT_OK;
}

/* The modes in which a variable of each kind may be set; 0: never. */
static const int settable[UNIT_KINDS] = {[UNIT_PARAMETER] = UNIT_BEFORE | UNIT_EVENT |
                                                            UNIT_STEPPING,
                                         [UNIT_INPUT] = UNIT_BEFORE | UNIT_RUNNING,
                                         [UNIT_SLOPE] = UNIT_BEFORE | UNIT_RUNNING,
                                         [UNIT_STATE] = UNIT_BEFORE,
                                         [UNIT_SETTING] = UNIT_BEFORE};

enum unit_status unit_set(struct unit *unit, unsigned reference, double value)
{
    const enum unit_kind kind = unit_kind_of(reference);
    const size_t i = unit_index_of(reference);
    if (i >= count(unit, kind))
        return none(unit, reference);
    const int input = kind == UNIT_INPUT || kind == UNIT_SLOPE;
    if (!((int)*unit->mode & settable[kind]) || (unit->busy && !input))
        return unit_say(unit, UNIT_ERROR, "logStatusError", "variable %u cannot be set %s",
                        reference, settable[kind] ? "now" : "at all");
    if (!isfinite(value))
        return unit_say(unit, UNIT_ERROR, "logStatusError",
                        "variable %u cannot be set to what is not finite", reference);
    unit_forget(unit);
    switch (kind) {
    case UNIT_PARAMETER:
        return set_parameter(unit, i, value);
    case UNIT_STATE:
        return set_start(unit, i, value);
    case UNIT_SETTING:
        return set_setting(unit, i, value);
    case UNIT_SLOPE:
        return unit_slope(unit, reference, 1, value);
    default:
        break;
    }
    if (unit->inputs[i] != value && !unit->busy && unit->co_simulation)
        unit->ready = 0;
    unit->inputs[i] = value;
    *unit->input_time = *unit->time;
    return UNIT_OK;
}

/* Sets a time derivative of an input at unit->input_time; `order` is 1 to UNIT_ORDERS. */
enum unit_status unit_slope(struct unit *unit, unsigned reference, int order, double value)
{
    const enum unit_kind kind = unit_kind_of(reference);
    const size_t i = unit_index_of(reference);
    if ((kind != UNIT_INPUT && kind != UNIT_SLOPE) || i >= unit->n_inputs || order < 1 ||
        order > UNIT_ORDERS || !isfinite(value))
        return unit_say(unit, UNIT_ERROR, "logStatusError",
                        "variable %u has no derivative of order %d to set", reference, order);
    double *const slope = unit->slopes + UNIT_ORDERS * i + (order - 1);
    if (*slope != value && !unit->busy && unit->co_simulation)
        unit->ready = 0;
    *slope = value;
    return UNIT_OK;
}

void unit_inputs(void *context, double t, double *u)
{
    struct unit *unit = (struct unit *)context;
    if (unit->inputs_at && !unit->busy) {
        unit->busy = 1;
        unit->inputs_at(unit, t);
        unit->busy = 0;
        memmove(u, unit->inputs, unit->n_inputs * sizeof *u);
        return;
    }
    const double past = t - *unit->input_time;
    for (size_t i = 0; i < unit->n_inputs; i++) {
        const double *d = unit->slopes + UNIT_ORDERS * i;
        u[i] = unit->inputs[i] + past * (d[0] + past / 2 * (d[1] + past / 3 * d[2]));
    }
}

/* Extrapolates the inputs and their derivatives to time t. */
void unit_move_inputs(struct unit *unit, double t)
{
    const double past = t - *unit->input_time;
    unit_inputs(unit, t, unit->inputs);
    for (size_t i = 0; i < unit->n_inputs; i++) {
        double *d = unit->slopes + UNIT_ORDERS * i;
        d[0] += past * (d[1] + past / 2 * d[2]);
        d[1] += past * d[2];
    }
    *unit->input_time = t;
}

static void held_inputs(void *context, double t, double *u)
{
    const struct unit *unit = (const struct unit *)context;
    (void)t;
    memcpy(u, unit->given ? unit->given : unit->inputs, unit->n_inputs * sizeof *u);
}

struct pk_problem unit_problem(struct unit *unit)
{
    return (struct pk_problem){.system = unit->system,
                               .params = unit_params(unit),
                               .input = unit->co_simulation ? unit_inputs : held_inputs,
                               .context = unit};
}
