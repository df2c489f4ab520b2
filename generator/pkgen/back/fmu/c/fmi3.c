/* FMI 3.0 over a unit. */
#include "fmi3.h"

#include <stdlib.h>
#include <string.h>

#include "unit.h"

#define CALL(modes)                                                       \
    struct unit *const unit = (struct unit *)instance;                    \
    const enum unit_status refused = unit_allowed(unit, __func__, modes); \
    if (refused != UNIT_OK)                                               \
    return (fmi3Status)refused

/* What unit.environment is of FMI 3. */
struct importer {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    bool may_return;
};

static void log_message(const struct unit *unit, enum unit_status status, const char *category,
                        const char *text)
{
    const struct importer *importer = (const struct importer *)unit->environment;
    if (importer->log)
        importer->log(importer->environment, (fmi3Status)status, category, text);
}

static void inputs_at(struct unit *unit, double t)
{
    const struct importer *importer = (const struct importer *)unit->environment;
    fmi3Boolean asked = false;
    fmi3Float64 when = t;
    importer->update(importer->environment, t, true, false, false, false, &asked, &when);
}

static int stepped(struct unit *unit, double t)
{
    const struct importer *importer = (const struct importer *)unit->environment;
    fmi3Boolean asked = false;
    fmi3Float64 when = t;
    unit->busy = 1;
    importer->update(importer->environment, t, false, true, true, importer->may_return, &asked,
                     &when);
    unit->busy = 0;
    return importer->may_return && asked && when <= t;
}

static fmi3Status null(const struct unit *unit, const char *call)
{
    return (fmi3Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                "%s: a pointer is null, or counts differ", call);
}

static struct unit *instantiate(fmi3String name, fmi3String token, int co_simulation, bool logging,
                                const struct importer *importer)
{
    struct unit *unit = unit_new(name, token, co_simulation);
    struct importer *kept = (struct importer *)malloc(sizeof *kept);
    if (unit && kept) {
        *kept = *importer;
        unit->environment = kept;
        unit->log = log_message;
        unit->logging = logging;
        return unit;
    }
    if (importer->log)
        importer->log(importer->environment, fmi3Error, "logStatusError",
                      "the instantiation token is not that of this model");
    unit_free(unit);
    free(kept);
    return NULL;
}

UNIT_SHOWN const char *fmi3GetVersion(void) { return "3.0"; }

UNIT_SHOWN fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n,
                                          const fmi3String categories[])
{
    CALL(UNIT_ANY);
    if (n && !categories)
        return null(unit, __func__);
    unit->logging = on;
    return fmi3OK;
}

UNIT_SHOWN fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                                     fmi3String resources, fmi3Boolean visible,
                                                     fmi3Boolean logging,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log)
{
    const struct importer importer = {environment, log, NULL, false};
    (void)resources;
    (void)visible;
    return instantiate(name, token, 0, logging, &importer);
}

UNIT_SHOWN fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean may_return,
    const fmi3ValueReference required[], size_t n_required, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    const struct importer importer = {environment, log, update, may_return};
    (void)resources;
    (void)visible;
    if (events) {
        if (log)
            log(environment, fmi3Error, "logStatusError", "the unit has no event mode");
        return NULL;
    }
    struct unit *unit = instantiate(name, token, 1, logging, &importer);
    if (!unit || !update)
        return unit;
    unit->stepped = stepped;
    for (size_t i = 0; required && i < n_required; i++)
        if (required[i] >> UNIT_SHIFT == UNIT_INPUT)
            unit->inputs_at = inputs_at;
    return unit;
}

UNIT_SHOWN fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)update;
    (void)lock, (void)unlock;
    if (log)
        log(environment, fmi3Error, "logStatusError", "the unit has no scheduled execution");
    return NULL;
}

UNIT_SHOWN void fmi3FreeInstance(fmi3Instance instance)
{
    struct unit *unit = (struct unit *)instance;
    if (!unit || unit->busy)
        return;
    free(unit->environment);
    unit_free(unit);
}

UNIT_SHOWN fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean with_tolerance,
                                                  fmi3Float64 tolerance, fmi3Float64 start,
                                                  fmi3Boolean with_stop, fmi3Float64 stop)
{
    CALL(UNIT_INSTANTIATED);
    (void)with_stop;
    (void)stop;
    return (fmi3Status)unit_enter_initialization(unit, start, with_tolerance, tolerance);
}

UNIT_SHOWN fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    CALL(UNIT_INITIALIZATION);
    return (fmi3Status)unit_exit_initialization(unit);
}

UNIT_SHOWN fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    CALL(UNIT_CONTINUOUS);
    *unit->mode = UNIT_EVENT;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3Terminate(fmi3Instance instance)
{
    CALL(UNIT_RUNNING);
    *unit->mode = UNIT_TERMINATED;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3Reset(fmi3Instance instance)
{
    CALL(UNIT_ANY);
    return (fmi3Status)unit_reset(unit);
}

UNIT_SHOWN fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[],
                                     size_t n, fmi3Float64 values[], size_t n_values)
{
    CALL(UNIT_ANY | UNIT_WITHIN);
    if ((n && (!references || !values)) || n != n_values)
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_get(unit, references[i], values + i);
        if (status != UNIT_OK)
            return (fmi3Status)status;
    }
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[],
                                     size_t n, const fmi3Float64 values[], size_t n_values)
{
    CALL(UNIT_ANY | UNIT_WITHIN);
    if ((n && (!references || !values)) || n != n_values)
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_set(unit, references[i], values[i]);
        if (status != UNIT_OK)
            return (fmi3Status)status;
    }
    return fmi3OK;
}

/* The method: the one variable that is no Float64. */
static const fmi3ValueReference METHOD = UNIT_SETTING << UNIT_SHIFT | UNIT_METHOD;

UNIT_SHOWN fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference references[],
                                   size_t n, fmi3Int64 values[], size_t n_values)
{
    CALL(UNIT_ANY | UNIT_WITHIN);
    if ((n && (!references || !values)) || n != n_values)
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        double value = 0;
        if (references[i] != METHOD)
            return (fmi3Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                        "variable %u is no enumeration", references[i]);
        unit_get(unit, METHOD, &value);
        values[i] = (fmi3Int64)value;
    }
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference references[],
                                   size_t n, const fmi3Int64 values[], size_t n_values)
{
    CALL(UNIT_ANY | UNIT_WITHIN);
    if ((n && (!references || !values)) || n != n_values)
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        if (references[i] != METHOD)
            return (fmi3Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                        "variable %u is no enumeration", references[i]);
        const enum unit_status status = unit_set(unit, METHOD, (double)values[i]);
        if (status != UNIT_OK)
            return (fmi3Status)status;
    }
    return fmi3OK;
}

/* No variable is of these types. */
static fmi3Status none(fmi3Instance instance, const char *call, size_t n)
{
    const struct unit *const unit = (const struct unit *)instance;
    const enum unit_status refused = unit_allowed(unit, call, UNIT_ANY | UNIT_WITHIN);
    if (refused != UNIT_OK || n == 0)
        return (fmi3Status)refused;
    return (fmi3Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                "%s: no variable is of that type", call);
}

#define NO_VARIABLES(name, type)                                                             \
    UNIT_SHOWN fmi3Status fmi3Get##name(fmi3Instance instance, const fmi3ValueReference r[], \
                                        size_t n, type values[], size_t n_values)            \
    {                                                                                        \
        (void)r, (void)values, (void)n_values;                                               \
        return none(instance, __func__, n);                                                  \
    }                                                                                        \
    UNIT_SHOWN fmi3Status fmi3Set##name(fmi3Instance instance, const fmi3ValueReference r[], \
                                        size_t n, const type values[], size_t n_values)      \
    {                                                                                        \
        (void)r, (void)values, (void)n_values;                                               \
        return none(instance, __func__, n);                                                  \
    }

NO_VARIABLES(Float32, fmi3Float32)
NO_VARIABLES(Int8, fmi3Int8)
NO_VARIABLES(UInt8, fmi3UInt8)
NO_VARIABLES(Int16, fmi3Int16)
NO_VARIABLES(UInt16, fmi3UInt16)
NO_VARIABLES(Int32, fmi3Int32)
NO_VARIABLES(UInt32, fmi3UInt32)
NO_VARIABLES(UInt64, fmi3UInt64)
NO_VARIABLES(Boolean, fmi3Boolean)
NO_VARIABLES(String, fmi3String)

UNIT_SHOWN fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                    size_t sizes[], fmi3Binary values[], size_t n_values)
{
    (void)r, (void)sizes, (void)values, (void)n_values;
    return none(instance, __func__, n);
}

UNIT_SHOWN fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference r[], size_t n,
                                    const size_t sizes[], const fmi3Binary values[],
                                    size_t n_values)
{
    (void)r, (void)sizes, (void)values, (void)n_values;
    return none(instance, __func__, n);
}

/* The same of clocks: a type of values, const where they are read, and a second array. */
#define NO_CLOCKS(call, type)                                                                 \
    UNIT_SHOWN fmi3Status call(fmi3Instance instance, const fmi3ValueReference r[], size_t n, \
                               type values[])                                                 \
    {                                                                                         \
        (void)r, (void)values;                                                                \
        return none(instance, __func__, n);                                                   \
    }
#define NO_FRACTIONS(call, type)                                                              \
    UNIT_SHOWN fmi3Status call(fmi3Instance instance, const fmi3ValueReference r[], size_t n, \
                               type counters[], type resolutions[])                           \
    {                                                                                         \
        (void)r, (void)counters, (void)resolutions;                                           \
        return none(instance, __func__, n);                                                   \
    }

NO_CLOCKS(fmi3GetClock, fmi3Clock)
NO_CLOCKS(fmi3SetClock, const fmi3Clock)
NO_CLOCKS(fmi3GetShiftDecimal, fmi3Float64)
NO_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64)
NO_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64)
NO_FRACTIONS(fmi3GetShiftFraction, fmi3UInt64)
NO_FRACTIONS(fmi3SetShiftFraction, const fmi3UInt64)
NO_FRACTIONS(fmi3SetIntervalFraction, const fmi3UInt64)

UNIT_SHOWN fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference r[],
                                             size_t n, fmi3Float64 intervals[],
                                             fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)intervals, (void)qualifiers;
    return none(instance, __func__, n);
}

UNIT_SHOWN fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference r[],
                                              size_t n, fmi3UInt64 counters[],
                                              fmi3UInt64 resolutions[],
                                              fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)counters, (void)resolutions, (void)qualifiers;
    return none(instance, __func__, n);
}

UNIT_SHOWN fmi3Status fmi3ActivateModelPartition(fmi3Instance instance,
                                                 fmi3ValueReference reference, fmi3Float64 t)
{
    (void)reference, (void)t;
    return none(instance, __func__, 1);
}

UNIT_SHOWN fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
                                                          fmi3ValueReference reference, size_t *n)
{
    (void)reference, (void)n;
    return none(instance, __func__, 1);
}

UNIT_SHOWN fmi3Status fmi3GetVariableDependencies(fmi3Instance instance,
                                                  fmi3ValueReference reference, size_t elements[],
                                                  fmi3ValueReference independents[],
                                                  size_t of_independents[],
                                                  fmi3DependencyKind kinds[], size_t n)
{
    (void)reference, (void)elements, (void)independents, (void)of_independents, (void)kinds;
    (void)n;
    return none(instance, __func__, 1);
}

UNIT_SHOWN fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return none(instance, __func__, 1);
}

UNIT_SHOWN fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return none(instance, __func__, 1);
}

UNIT_SHOWN fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    CALL(UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    if (*state) { /* a state that is there is written over */
        memcpy(*state, unit->all, unit->n_all * sizeof *unit->all);
        return fmi3OK;
    }
    *state = unit_state(unit);
    return *state ? fmi3OK : null(unit, __func__);
}

UNIT_SHOWN fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    CALL(UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    return (fmi3Status)unit_restore(unit, (const double *)state);
}

UNIT_SHOWN fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    CALL(UNIT_ANY | UNIT_WITHIN);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state,
                                                 size_t *size)
{
    CALL(UNIT_ANY);
    if (!state || !size)
        return null(unit, __func__);
    *size = unit_serial_size(unit);
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state,
                                            fmi3Byte bytes[], size_t size)
{
    CALL(UNIT_ANY);
    if (!state || !bytes || size != unit_serial_size(unit))
        return null(unit, __func__);
    unit_serialise(unit, (const double *)state, bytes);
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[],
                                              size_t size, fmi3FMUState *state)
{
    CALL(UNIT_ANY);
    double *found = bytes && state ? unit_deserialise(unit, bytes, size) : NULL;
    if (!found)
        return (fmi3Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                    "these bytes are no state of this model");
    if (*state)
        free(*state);
    *state = found;
    return fmi3OK;
}

static fmi3Status derivative(fmi3Instance instance, const char *call,
                             const fmi3ValueReference unknowns[], size_t n_unknowns,
                             const fmi3ValueReference knowns[], size_t n_knowns,
                             const fmi3Float64 seed[], size_t n_seed, int transposed,
                             fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    struct unit *const unit = (struct unit *)instance;
    const enum unit_status refused =
        unit_allowed(unit, call, UNIT_INITIALIZATION | UNIT_RUNNING | UNIT_TERMINATED);
    if (refused != UNIT_OK)
        return (fmi3Status)refused;
    const size_t in = transposed ? n_unknowns : n_knowns, out = transposed ? n_knowns : n_unknowns;
    if (!unknowns || !knowns || !seed || !sensitivity || n_seed != in || n_sensitivity != out)
        return null(unit, call);
    return (fmi3Status)unit_derivative(unit, unknowns, n_unknowns, knowns, n_knowns, seed,
                                       transposed, sensitivity);
}

UNIT_SHOWN fmi3Status fmi3GetDirectionalDerivative(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    return derivative(instance, __func__, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, 0,
                      sensitivity, n_sensitivity);
}

UNIT_SHOWN fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance,
                                               const fmi3ValueReference unknowns[],
                                               size_t n_unknowns, const fmi3ValueReference knowns[],
                                               size_t n_knowns, const fmi3Float64 seed[],
                                               size_t n_seed, fmi3Float64 sensitivity[],
                                               size_t n_sensitivity)
{
    return derivative(instance, __func__, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, 1,
                      sensitivity, n_sensitivity);
}

UNIT_SHOWN fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    CALL(UNIT_INITIALIZATION | UNIT_EVENT);
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again,
                                               fmi3Boolean *ends, fmi3Boolean *nominals,
                                               fmi3Boolean *states, fmi3Boolean *with_time,
                                               fmi3Float64 *next)
{
    CALL(UNIT_EVENT);
    if (!again || !ends || !nominals || !states || !with_time || !next)
        return null(unit, __func__);
    int stops;
    const enum unit_status status = unit_update(unit, &stops);
    *ends = stops != 0;
    *again = *nominals = *states = *with_time = false;
    return (fmi3Status)status;
}

UNIT_SHOWN fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    CALL(UNIT_EVENT);
    if (unit->co_simulation)
        return none(instance, __func__, 1);
    *unit->mode = UNIT_CONTINUOUS;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_state,
                                                  fmi3Boolean *event_mode, fmi3Boolean *ends)
{
    CALL(UNIT_CONTINUOUS);
    (void)no_set_state;
    if (!event_mode || !ends)
        return null(unit, __func__);
    *event_mode = *ends = false;
    return (fmi3Status)unit_completed(unit);
}

UNIT_SHOWN fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 t)
{
    CALL(UNIT_EVENT | UNIT_CONTINUOUS);
    return (fmi3Status)unit_set_time(unit, t);
}

UNIT_SHOWN fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[],
                                              size_t n)
{
    CALL(UNIT_CONTINUOUS);
    return (fmi3Status)unit_set_states(unit, x, n);
}

UNIT_SHOWN fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n)
{
    CALL(UNIT_ANY);
    return (fmi3Status)unit_get_states(unit, x, n);
}

UNIT_SHOWN fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 rates[],
                                                        size_t n)
{
    CALL(UNIT_ANY);
    return (fmi3Status)unit_derivatives(unit, rates, n);
}

UNIT_SHOWN fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 values[], size_t n)
{
    CALL(UNIT_ANY);
    return (fmi3Status)unit_indicators(unit, values, n);
}

UNIT_SHOWN fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance,
                                                        fmi3Float64 nominals[], size_t n)
{
    CALL(UNIT_ANY);
    if (n != unit->n_x || (n && !nominals))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++)
        nominals[i] = 1;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    CALL(UNIT_ANY);
    if (!n)
        return null(unit, __func__);
    *n = unit->n_events + unit->n_switches;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    CALL(UNIT_ANY);
    if (!n)
        return null(unit, __func__);
    *n = unit->n_x;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return none(instance, __func__, 1); /* it is entered behind the initialization */
}

UNIT_SHOWN fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance,
                                               const fmi3ValueReference references[], size_t n,
                                               const fmi3Int32 orders[], fmi3Float64 values[],
                                               size_t n_values)
{
    (void)references, (void)orders, (void)values, (void)n_values;
    return none(instance, __func__, n);
}

UNIT_SHOWN fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 length,
                                 fmi3Boolean no_set_state, fmi3Boolean *event, fmi3Boolean *ends,
                                 fmi3Boolean *early, fmi3Float64 *last)
{
    CALL(UNIT_STEPPING);
    struct unit_stepped made;
    (void)no_set_state;
    if (!event || !ends || !early || !last)
        return null(unit, __func__);
    const enum unit_status status = unit_step(unit, t, length, &made);
    const struct importer *importer = (const struct importer *)unit->environment;
    *event = false;
    *ends = made.ends != 0;
    *early = made.early || (made.ends && importer->may_return);
    *last = made.t;
    if (status == UNIT_OK && made.ends && !importer->may_return && made.t < t + length)
        return (fmi3Status)unit_early(unit); /* which only this can say */
    return (fmi3Status)status;
}
