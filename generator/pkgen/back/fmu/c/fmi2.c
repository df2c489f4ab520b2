/* FMI 2.0 over a unit. */
#include "fmi2.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit.h"

#define CALL(modes)                                                       \
    struct unit *const unit = (struct unit *)c;                           \
    const enum unit_status refused = unit_allowed(unit, __func__, modes); \
    if (refused != UNIT_OK)                                               \
    return (fmi2Status)refused

/* What unit.environment is of FMI 2, and what its calls leave for later ones. */
struct importer {
    fmi2ComponentEnvironment environment;
    fmi2CallbackLogger log;
    double start, tolerance;
    int with_tolerance;
    struct unit_stepped made;
};

static void log_message(const struct unit *unit, enum unit_status status, const char *category,
                        const char *text)
{
    const struct importer *importer = (const struct importer *)unit->environment;
    importer->log(importer->environment, unit->name, (fmi2Status)status, category, "%s", text);
}

static fmi2Status null(const struct unit *unit, const char *call)
{
    return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                "%s: a pointer is null, or counts differ", call);
}

UNIT_SHOWN const char *fmi2GetTypesPlatform(void) { return "default"; }

UNIT_SHOWN const char *fmi2GetVersion(void) { return "2.0"; }

UNIT_SHOWN fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                          const fmi2String categories[])
{
    CALL(UNIT_ANY);
    if (n && !categories)
        return null(unit, __func__);
    unit->logging = on != 0;
    return fmi2OK;
}

UNIT_SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                                         fmi2String resources,
                                         const fmi2CallbackFunctions *functions,
                                         fmi2Boolean visible, fmi2Boolean logging)
{
    struct unit *unit = unit_new(name, token, type == fmi2CoSimulation);
    struct importer *importer = (struct importer *)calloc(1, sizeof *importer);
    (void)resources;
    (void)visible;
    if (unit && importer && functions) {
        importer->environment = functions->componentEnvironment;
        importer->log = functions->logger;
        unit->environment = importer;
        unit->log = functions->logger ? log_message : NULL;
        unit->logging = logging != 0;
        return unit;
    }
    if (functions && functions->logger)
        functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError",
                          "the GUID is not that of this model");
    unit_free(unit);
    free(importer);
    return NULL;
}

UNIT_SHOWN void fmi2FreeInstance(fmi2Component c)
{
    struct unit *unit = (struct unit *)c;
    if (!unit || unit->busy)
        return;
    free(unit->environment);
    unit_free(unit);
}

UNIT_SHOWN fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance,
                                          fmi2Real tolerance, fmi2Real start, fmi2Boolean with_stop,
                                          fmi2Real stop)
{
    CALL(UNIT_INSTANTIATED);
    struct importer *importer = (struct importer *)unit->environment;
    (void)with_stop;
    (void)stop;
    importer->with_tolerance = with_tolerance != 0;
    importer->tolerance = tolerance;
    importer->start = start;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    CALL(UNIT_INSTANTIATED);
    const struct importer *importer = (const struct importer *)unit->environment;
    return (fmi2Status)unit_enter_initialization(unit, importer->start, importer->with_tolerance,
                                                 importer->tolerance);
}

UNIT_SHOWN fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    CALL(UNIT_INITIALIZATION);
    return (fmi2Status)unit_exit_initialization(unit);
}

UNIT_SHOWN fmi2Status fmi2Terminate(fmi2Component c)
{
    CALL(UNIT_RUNNING);
    *unit->mode = UNIT_TERMINATED;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2Reset(fmi2Component c)
{
    CALL(UNIT_ANY);
    return (fmi2Status)unit_reset(unit);
}

UNIT_SHOWN fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                  fmi2Real values[])
{
    CALL(UNIT_ANY);
    if (n && (!references || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_get(unit, references[i], values + i);
        if (status != UNIT_OK)
            return (fmi2Status)status;
    }
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                                  const fmi2Real values[])
{
    CALL(UNIT_ANY);
    if (n && (!references || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_set(unit, references[i], values[i]);
        if (status != UNIT_OK)
            return (fmi2Status)status;
    }
    return fmi2OK;
}

/* The method: the one variable that is no Real. */
static const fmi2ValueReference METHOD = UNIT_SETTING << UNIT_SHIFT | UNIT_METHOD;

UNIT_SHOWN fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[],
                                     size_t n, fmi2Integer values[])
{
    CALL(UNIT_ANY);
    if (n && (!references || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        double value = 0;
        if (references[i] != METHOD)
            return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                        "variable %u is no enumeration", references[i]);
        unit_get(unit, METHOD, &value);
        values[i] = (fmi2Integer)value;
    }
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[],
                                     size_t n, const fmi2Integer values[])
{
    CALL(UNIT_ANY);
    if (n && (!references || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        if (references[i] != METHOD)
            return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                        "variable %u is no enumeration", references[i]);
        const enum unit_status status = unit_set(unit, METHOD, values[i]);
        if (status != UNIT_OK)
            return (fmi2Status)status;
    }
    return fmi2OK;
}

/* No variable is of these types. */
#define NO_VARIABLES(call, type)                                                                 \
    UNIT_SHOWN fmi2Status call(fmi2Component c, const fmi2ValueReference references[], size_t n, \
                               type values[])                                                    \
    {                                                                                            \
        CALL(UNIT_ANY);                                                                          \
        (void)references, (void)values;                                                          \
        return n ? (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",                      \
                                        "%s: no variable is of that type", __func__)             \
                 : fmi2OK;                                                                       \
    }

NO_VARIABLES(fmi2GetBoolean, fmi2Boolean)
NO_VARIABLES(fmi2SetBoolean, const fmi2Boolean)
NO_VARIABLES(fmi2GetString, fmi2String)
NO_VARIABLES(fmi2SetString, const fmi2String)

UNIT_SHOWN fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    CALL(UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    if (*state) { /* a state that is there is written over */
        memcpy(*state, unit->all, unit->n_all * sizeof *unit->all);
        return fmi2OK;
    }
    *state = unit_state(unit);
    return *state ? fmi2OK : null(unit, __func__);
}

UNIT_SHOWN fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    CALL(UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    return (fmi2Status)unit_restore(unit, (const double *)state);
}

UNIT_SHOWN fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    CALL(UNIT_ANY);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    CALL(UNIT_ANY);
    if (!state || !size)
        return null(unit, __func__);
    *size = unit_serial_size(unit);
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                            size_t size)
{
    CALL(UNIT_ANY);
    if (!state || !bytes || size != unit_serial_size(unit))
        return null(unit, __func__);
    unit_serialise(unit, (const double *)state, (unsigned char *)bytes);
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                              fmi2FMUstate *state)
{
    CALL(UNIT_ANY);
    double *found = bytes && state ? unit_deserialise(unit, (const unsigned char *)bytes, size)
                                   : NULL;
    if (!found)
        return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                    "these bytes are no state of this model");
    if (*state)
        free(*state);
    *state = found;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2GetDirectionalDerivative(fmi2Component c,
                                                   const fmi2ValueReference unknowns[],
                                                   size_t n_unknowns,
                                                   const fmi2ValueReference knowns[],
                                                   size_t n_knowns, const fmi2Real seed[],
                                                   fmi2Real sensitivity[])
{
    CALL(UNIT_INITIALIZATION | UNIT_RUNNING | UNIT_TERMINATED);
    if (!unknowns || !knowns || !seed || !sensitivity)
        return null(unit, __func__);
    return (fmi2Status)unit_derivative(unit, unknowns, n_unknowns, knowns, n_knowns, seed, 0,
                                       sensitivity);
}

UNIT_SHOWN fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    CALL(UNIT_CONTINUOUS | UNIT_EVENT);
    if (unit->co_simulation)
        return null(unit, __func__);
    *unit->mode = UNIT_EVENT;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    CALL(UNIT_EVENT);
    if (!info)
        return null(unit, __func__);
    int ends;
    const enum unit_status status = unit_update(unit, &ends);
    memset(info, 0, sizeof *info);
    info->terminateSimulation = ends != 0;
    return (fmi2Status)status;
}

UNIT_SHOWN fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    CALL(UNIT_EVENT);
    *unit->mode = UNIT_CONTINUOUS;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state,
                                                  fmi2Boolean *event_mode, fmi2Boolean *ends)
{
    CALL(UNIT_CONTINUOUS);
    (void)no_set_state;
    if (!event_mode || !ends)
        return null(unit, __func__);
    *event_mode = *ends = 0;
    return (fmi2Status)unit_completed(unit);
}

UNIT_SHOWN fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t)
{
    CALL(UNIT_EVENT | UNIT_CONTINUOUS);
    return (fmi2Status)unit_set_time(unit, t);
}

UNIT_SHOWN fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    CALL(UNIT_CONTINUOUS | UNIT_EVENT);
    return (fmi2Status)unit_set_states(unit, x, n);
}

UNIT_SHOWN fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n)
{
    CALL(UNIT_ANY);
    return (fmi2Status)unit_derivatives(unit, rates, n);
}

UNIT_SHOWN fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real values[], size_t n)
{
    CALL(UNIT_ANY);
    return (fmi2Status)unit_indicators(unit, values, n);
}

UNIT_SHOWN fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    CALL(UNIT_ANY);
    return (fmi2Status)unit_get_states(unit, x, n);
}

UNIT_SHOWN fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[],
                                                        size_t n)
{
    CALL(UNIT_ANY);
    if (n != unit->n_x || (n && !nominals))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++)
        nominals[i] = 1;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2SetRealInputDerivatives(fmi2Component c,
                                                  const fmi2ValueReference references[], size_t n,
                                                  const fmi2Integer orders[],
                                                  const fmi2Real values[])
{
    CALL(UNIT_BEFORE | UNIT_STEPPING);
    if (n && (!references || !orders || !values))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++) {
        const enum unit_status status = unit_slope(unit, references[i], orders[i], values[i]);
        if (status != UNIT_OK)
            return (fmi2Status)status;
    }
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c,
                                                   const fmi2ValueReference references[], size_t n,
                                                   const fmi2Integer orders[], fmi2Real values[])
{
    CALL(UNIT_ANY);
    (void)references, (void)n, (void)orders, (void)values;
    return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError",
                                "the unit has no derivatives of outputs");
}

UNIT_SHOWN fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real length,
                                 fmi2Boolean no_set_state)
{
    CALL(UNIT_STEPPING);
    struct importer *importer = (struct importer *)unit->environment;
    (void)no_set_state;
    const enum unit_status status = unit_step(unit, t, length, &importer->made);
    /* Derivatives of inputs are of one step. */
    for (size_t i = 0; i < UNIT_ORDERS * unit->n_inputs; i++) {
        if (unit->slopes[i] != 0)
            unit->ready = 0;
        unit->slopes[i] = 0;
    }
    if (status == UNIT_OK && importer->made.ends)
        return (fmi2Status)unit_early(unit); /* fmi2GetBooleanStatus(fmi2Terminated) says so */
    return (fmi2Status)status;
}

UNIT_SHOWN fmi2Status fmi2CancelStep(fmi2Component c)
{
    CALL(UNIT_ANY);
    return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError", "no step is pending");
}

UNIT_SHOWN fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    CALL(UNIT_STEPPING | UNIT_TERMINATED);
    if (!value || kind != fmi2LastSuccessfulTime)
        return null(unit, __func__);
    *value = *unit->time;
    return fmi2OK;
}

UNIT_SHOWN fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind,
                                           fmi2Boolean *value)
{
    CALL(UNIT_STEPPING | UNIT_TERMINATED);
    const struct importer *importer = (const struct importer *)unit->environment;
    if (!value || kind != fmi2Terminated)
        return null(unit, __func__);
    *value = importer->made.ends;
    return fmi2OK;
}

/* Steps are never pending. */
#define NO_STATUS(call, type)                                                                     \
    UNIT_SHOWN fmi2Status call(fmi2Component c, const fmi2StatusKind kind, type *value)           \
    {                                                                                             \
        CALL(UNIT_ANY);                                                                           \
        (void)kind, (void)value;                                                                  \
        return (fmi2Status)unit_say(unit, UNIT_ERROR, "logStatusError", "%s: no step is pending", \
                                    __func__);                                                    \
    }

NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)
