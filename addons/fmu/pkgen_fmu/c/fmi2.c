/* The functions of FMI 2.0. */
#include "fmi2.h"

#include <stdlib.h>
#include <string.h>

#include "unit.h"

/* The type of *unit.environment in FMI 2: callbacks of the importer, and data for later calls. */
struct importer {
    fmi2ComponentEnvironment environment;
    fmi2CallbackLogger log;
    double start, tolerance;
    int with_tolerance;
    struct unit_stepped made;
};

static void say(const struct importer *importer, const char *name, fmi2Status status,
                const char *category, const char *text)
{
    if (importer->log)
        importer->log(importer->environment, name, status, category, "%s", text);
}

/* FMI 2 spells these names differently from FMI 3. */
#define fmi2FMUState fmi2FMUstate
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#define fmi2GetContinuousStateDerivatives fmi2GetDerivatives
#define FMI(name) fmi2##name
typedef fmi2Component instance_type;
typedef fmi2Integer whole_type;
#include "calls.h"

UNIT_SHOWN const char *fmi2GetTypesPlatform(void) { return "default"; }

UNIT_SHOWN const char *fmi2GetVersion(void) { return "2.0"; }

UNIT_SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                                         fmi2String resources,
                                         const fmi2CallbackFunctions *functions,
                                         fmi2Boolean visible, fmi2Boolean logging)
{
    if (!functions)
        return NULL;
    const struct importer importer = {.environment = functions->componentEnvironment,
                                      .log = functions->logger};
    return instantiate(name, token, type == fmi2CoSimulation, logging, &importer);
}

UNIT_SHOWN fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean with_tolerance,
                                          fmi2Real tolerance, fmi2Real start, fmi2Boolean with_stop,
                                          fmi2Real stop)
{
    CALL(__func__, UNIT_INSTANTIATED);
    struct importer *importer = (struct importer *)unit->environment;
    importer->with_tolerance = with_tolerance != 0;
    importer->tolerance = tolerance;
    importer->start = start;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2EnterInitializationMode(fmi2Component instance)
{
    CALL(__func__, UNIT_INSTANTIATED);
    const struct importer *importer = (const struct importer *)unit->environment;
    return (fmi2Status)unit_enter_initialization(unit, importer->start, importer->with_tolerance,
                                                 importer->tolerance);
}

UNIT_SHOWN fmi2Status fmi2EnterEventMode(fmi2Component instance)
{
    CALL(__func__, UNIT_CONTINUOUS | UNIT_EVENT);
    return (fmi2Status)unit_enter_event(unit);
}

#define VALUES(call, how, type)                                                               \
    UNIT_SHOWN fmi2Status call(fmi2Component instance, const fmi2ValueReference references[], \
                               size_t n, type values[])                                       \
    {                                                                                         \
        return how(instance, __func__, references, n, values, n);                             \
    }

VALUES(fmi2GetReal, get_reals, fmi2Real)
VALUES(fmi2SetReal, set_reals, const fmi2Real)
VALUES(fmi2GetInteger, get_wholes, fmi2Integer)
VALUES(fmi2SetInteger, set_wholes, const fmi2Integer)

#define NO_VARIABLES(call, type)                                                              \
    UNIT_SHOWN fmi2Status call(fmi2Component instance, const fmi2ValueReference references[], \
                               size_t n, type values[])                                       \
    {                                                                                         \
        return none(instance, __func__, n);                                                   \
    }

NO_VARIABLES(fmi2GetBoolean, fmi2Boolean)
NO_VARIABLES(fmi2SetBoolean, const fmi2Boolean)
NO_VARIABLES(fmi2GetString, fmi2String)
NO_VARIABLES(fmi2SetString, const fmi2String)

UNIT_SHOWN fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance,
                                                   const fmi2ValueReference unknowns[],
                                                   size_t n_unknowns,
                                                   const fmi2ValueReference knowns[],
                                                   size_t n_knowns, const fmi2Real seed[],
                                                   fmi2Real sensitivity[])
{
    return derivative(instance, __func__, unknowns, n_unknowns, knowns, n_knowns, seed, n_knowns, 0,
                      sensitivity, n_unknowns);
}

UNIT_SHOWN fmi2Status fmi2NewDiscreteStates(fmi2Component instance, fmi2EventInfo *info)
{
    CALL(__func__, UNIT_EVENT);
    if (!info)
        return null(unit, __func__);
    int ends;
    const enum unit_status status = unit_update(unit, &ends);
    memset(info, 0, sizeof *info);
    info->terminateSimulation = ends != 0;
    info->valuesOfContinuousStatesChanged = unit_moved(unit) != 0;
    return (fmi2Status)status;
}

UNIT_SHOWN fmi2Status fmi2SetContinuousStates(fmi2Component instance, const fmi2Real x[], size_t n)
{
    CALL(__func__, UNIT_CONTINUOUS | UNIT_EVENT);
    return (fmi2Status)unit_set_states(unit, x, n);
}

UNIT_SHOWN fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance,
                                                  const fmi2ValueReference references[], size_t n,
                                                  const fmi2Integer orders[],
                                                  const fmi2Real values[])
{
    CALL(__func__, UNIT_BEFORE | UNIT_STEPPING);
    if (n && (!references || !orders || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_slope(unit, references[i], orders[i], values[i]);
        if (status != UNIT_OK)
            return (fmi2Status)status;
    }
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance,
                                                   const fmi2ValueReference references[], size_t n,
                                                   const fmi2Integer orders[], fmi2Real values[])
{
    CALL(__func__, UNIT_ANY);
    return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                "the unit has no derivatives of outputs");
}

UNIT_SHOWN fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real t, fmi2Real length,
                                 fmi2Boolean no_set_state)
{
    CALL(__func__, UNIT_STEPPING);
    struct importer *importer = (struct importer *)unit->environment;
    const enum unit_status status = unit_step(unit, t, length, &importer->made);
    /* Derivatives of inputs that the importer sets apply to one step only. */
    for (size_t i = 0; i < UNIT_ORDERS * unit->n_inputs; i++) {
        if (unit->slopes[i] != 0)
            unit->ready = 0;
        unit->slopes[i] = 0;
    }
    if (status == UNIT_OK && importer->made.ends)
        /* the importer learns that the motion has ended from fmi2GetBooleanStatus() */
        return (fmi2Status)unit_early(unit);
    return (fmi2Status)status;
}

UNIT_SHOWN fmi2Status fmi2CancelStep(fmi2Component instance)
{
    CALL(__func__, UNIT_ANY);
    return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError", "no step is pending");
}

UNIT_SHOWN fmi2Status fmi2GetRealStatus(fmi2Component instance, const fmi2StatusKind kind,
                                        fmi2Real *value)
{
    CALL(__func__, UNIT_STEPPING | UNIT_TERMINATED);
    if (!value || kind != fmi2LastSuccessfulTime)
        return null(unit, __func__);
    *value = *unit->time;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2GetBooleanStatus(fmi2Component instance, const fmi2StatusKind kind,
                                           fmi2Boolean *value)
{
    CALL(__func__, UNIT_STEPPING | UNIT_TERMINATED);
    const struct importer *importer = (const struct importer *)unit->environment;
    if (!value || kind != fmi2Terminated)
        return null(unit, __func__);
    *value = importer->made.ends;
    return fmi2OK;
}

/* Status calls fail: they are for asynchronous steps, which a unit does not have. */
#define NO_STATUS(call, type)                                                                     \
    UNIT_SHOWN fmi2Status call(fmi2Component instance, const fmi2StatusKind kind, type *value)    \
    {                                                                                             \
        CALL(__func__, UNIT_ANY);                                                                 \
        return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError", "%s: no step is pending", \
                                    __func__);                                                    \
    }

NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)
