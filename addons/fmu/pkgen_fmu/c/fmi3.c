/* The functions of FMI 3.0. */
#include "fmi3.h"

#include <stdlib.h>
#include <string.h>

#include "unit.h"

/* The type of *unit.environment in FMI 3: callbacks of the importer. */
struct importer {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    bool may_return;
};

static void say(const struct importer *importer, const char *name, fmi3Status status,
                const char *category, const char *text)
{
    (void)name;
    if (importer->log)
        importer->log(importer->environment, status, category, text);
}

#define FMI(name) fmi3##name
typedef fmi3Instance instance_type;
typedef fmi3Int64 whole_type;
#include "calls.h"

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

UNIT_SHOWN const char *fmi3GetVersion(void) { return "3.0"; }

UNIT_SHOWN fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                                     fmi3String resources, fmi3Boolean visible,
                                                     fmi3Boolean logging,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log)
{
    const struct importer importer = {environment, log, NULL, false};
    return instantiate(name, token, 0, logging, &importer);
}

UNIT_SHOWN fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean may_return,
    const fmi3ValueReference required[], size_t n_required, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    const struct importer importer = {environment, log, update, may_return};
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
    if (log)
        log(environment, fmi3Error, "logStatusError", "the unit has no scheduled execution");
    return NULL;
}

UNIT_SHOWN fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean with_tolerance,
                                                  fmi3Float64 tolerance, fmi3Float64 start,
                                                  fmi3Boolean with_stop, fmi3Float64 stop)
{
    CALL(__func__, UNIT_INSTANTIATED);
    return (fmi3Status)unit_enter_initialization(unit, start, with_tolerance, tolerance);
}

UNIT_SHOWN fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    CALL(__func__, UNIT_CONTINUOUS);
    return (fmi3Status)unit_enter_event(unit);
}

#define VALUES(call, how, type)                                                              \
    UNIT_SHOWN fmi3Status call(fmi3Instance instance, const fmi3ValueReference references[], \
                               size_t n, type values[], size_t n_values)                     \
    {                                                                                        \
        return how(instance, __func__, references, n, values, n_values);                     \
    }

VALUES(fmi3GetFloat64, get_reals, fmi3Float64)
VALUES(fmi3SetFloat64, set_reals, const fmi3Float64)
VALUES(fmi3GetInt64, get_wholes, fmi3Int64)
VALUES(fmi3SetInt64, set_wholes, const fmi3Int64)

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
    CALL(__func__, UNIT_INITIALIZATION | UNIT_EVENT);
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again,
                                               fmi3Boolean *ends, fmi3Boolean *nominals,
                                               fmi3Boolean *states, fmi3Boolean *with_time,
                                               fmi3Float64 *next)
{
    CALL(__func__, UNIT_EVENT);
    if (!again || !ends || !nominals || !states || !with_time || !next)
        return null(unit, __func__);
    int stops;
    const enum unit_status status = unit_update(unit, &stops);
    *ends = stops != 0;
    *states = unit_moved(unit) != 0;
    *again = *nominals = *with_time = false;
    return (fmi3Status)status;
}

UNIT_SHOWN fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[],
                                              size_t n)
{
    CALL(__func__, UNIT_CONTINUOUS);
    return (fmi3Status)unit_set_states(unit, x, n);
}

UNIT_SHOWN fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    CALL(__func__, UNIT_ANY);
    if (!n)
        return null(unit, __func__);
    *n = unit->n_events + unit->n_switches;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    CALL(__func__, UNIT_ANY);
    if (!n)
        return null(unit, __func__);
    *n = unit->n_x;
    return fmi3OK;
}

UNIT_SHOWN fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 length,
                                 fmi3Boolean no_set_state, fmi3Boolean *event, fmi3Boolean *ends,
                                 fmi3Boolean *early, fmi3Float64 *last)
{
    CALL(__func__, UNIT_STEPPING);
    struct unit_stepped made;
    if (!event || !ends || !early || !last)
        return null(unit, __func__);
    const enum unit_status status = unit_step(unit, t, length, &made);
    const struct importer *importer = (const struct importer *)unit->environment;
    *event = false;
    *ends = made.ends != 0;
    *early = made.early || (made.ends && importer->may_return);
    *last = made.t;
    if (status == UNIT_OK && made.ends && !importer->may_return && made.t < t + length)
        /* the step ended early, but the importer does not accept that with the status fmi3OK */
        return (fmi3Status)unit_early(unit);
    return (fmi3Status)status;
}

/* Functions for features that a unit lacks: types that no variable has, clocks, and others. */
#define NO(call, n, parameters) \
    UNIT_SHOWN fmi3Status call parameters { return none(instance, __func__, n); }
#define OF fmi3Instance instance, const fmi3ValueReference r[], size_t n
#define NO_VARIABLES(name, type)                               \
    NO(fmi3Get##name, n, (OF, type values[], size_t n_values)) \
    NO(fmi3Set##name, n, (OF, const type values[], size_t n_values))

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
NO(fmi3GetBinary, n, (OF, size_t sizes[], fmi3Binary values[], size_t n_values))
NO(fmi3SetBinary, n, (OF, const size_t sizes[], const fmi3Binary values[], size_t n_values))
NO(fmi3GetClock, n, (OF, fmi3Clock values[]))
NO(fmi3SetClock, n, (OF, const fmi3Clock values[]))
NO(fmi3GetShiftDecimal, n, (OF, fmi3Float64 shifts[]))
NO(fmi3SetShiftDecimal, n, (OF, const fmi3Float64 shifts[]))
NO(fmi3GetShiftFraction, n, (OF, fmi3UInt64 counters[], fmi3UInt64 resolutions[]))
NO(fmi3SetShiftFraction, n, (OF, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
NO(fmi3GetIntervalDecimal, n, (OF, fmi3Float64 lengths[], fmi3IntervalQualifier qualifiers[]))
NO(fmi3SetIntervalDecimal, n, (OF, const fmi3Float64 lengths[]))
NO(fmi3GetIntervalFraction, n,
   (OF, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]))
NO(fmi3SetIntervalFraction, n, (OF, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
NO(fmi3GetOutputDerivatives, n,
   (OF, const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values))
NO(fmi3ActivateModelPartition, 1, (fmi3Instance instance, fmi3ValueReference r, fmi3Float64 t))
NO(fmi3GetNumberOfVariableDependencies, 1, (fmi3Instance instance, fmi3ValueReference r, size_t *n))
NO(fmi3GetVariableDependencies, 1,
   (fmi3Instance instance, fmi3ValueReference r, size_t elements[],
    fmi3ValueReference independents[], size_t of_independents[], fmi3DependencyKind kinds[],
    size_t n))
NO(fmi3EnterConfigurationMode, 1, (fmi3Instance instance))
NO(fmi3ExitConfigurationMode, 1, (fmi3Instance instance))
NO(fmi3EnterStepMode, 1, (fmi3Instance instance)) /* unused: co-simulation has no event mode */
