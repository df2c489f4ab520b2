/* Functions common to FMI 2 and FMI 3. fmi2.c and fmi3.c include this file after they define:
 * FMI(name), which prefixes a name by fmi2 or fmi3; instance_type; whole_type, an integer type;
 * struct importer, the type of *unit.environment; say(), which logs to the importer. */
#if defined _WIN32
#define UNIT_SHOWN __declspec(dllexport)
#elif defined __GNUC__
#define UNIT_SHOWN __attribute__((visibility("default")))
#else
#define UNIT_SHOWN
#endif

/* Some functions ignore parameters that the standard prescribes. */
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef FMI(Status) status_type;
typedef FMI(ValueReference) reference_type;

/* Declares `unit`, the FMU instance. Returns an error from the function that contains the macro
 * unless `modes` contains the current mode of the unit. */
#define CALL(call, modes)                                             \
    struct unit *const unit = (struct unit *)instance;                \
    const enum unit_status refused = unit_allowed(unit, call, modes); \
    if (refused != UNIT_OK)                                           \
    return (status_type)refused

static status_type null(const struct unit *unit, const char *call)
{
    return (status_type)unit_say(unit, UNIT_ERROR, "logStatusError",
                                 "%s: a pointer is null, or counts differ", call);
}

/* Returns an error unless n = 0. For functions that get or set variables of a type that no variable
 * of an FMU of pkgen has. */
static status_type none(instance_type instance, const char *call, size_t n)
{
    CALL(call, UNIT_ANY | UNIT_WITHIN);
    return n ? (status_type)unit_say(unit, UNIT_ERROR, "logStatusError",
                                     "%s: no variable is of that type", call)
             : FMI(OK);
}

/* Calls one(unit, reference, value) for each of n variables, and returns from the function that
 * contains the macro at the first failure. */
#define EACH(call, one)                                                       \
    CALL(call, UNIT_ANY | UNIT_WITHIN);                                       \
    if ((n && (!references || !values)) || n != n_values)                     \
        return null(unit, call);                                              \
    for (size_t i = 0; i < n; i++) {                                          \
        const enum unit_status status = one(unit, references[i], values + i); \
        if (status != UNIT_OK)                                                \
            return (status_type)status;                                       \
    }                                                                         \
    return FMI(OK)

static status_type get_reals(instance_type instance, const char *call,
                             const reference_type references[], size_t n, double values[],
                             size_t n_values)
{
    EACH(call, unit_get);
}

static enum unit_status set_real(struct unit *unit, unsigned reference, const double *value)
{
    return unit_set(unit, reference, *value);
}

static status_type set_reals(instance_type instance, const char *call,
                             const reference_type references[], size_t n, const double values[],
                             size_t n_values)
{
    EACH(call, set_real);
}

/* Fails unless the variable is integrator.method, the only variable that is not a real number. */
static enum unit_status only_method(const struct unit *unit, unsigned reference)
{
    if (reference == (UNIT_SETTING << UNIT_SHIFT | UNIT_METHOD))
        return UNIT_OK;
    return unit_say(unit, UNIT_ERROR, "logStatusError", "variable %u is no enumeration", reference);
}

static enum unit_status get_whole(struct unit *unit, unsigned reference, whole_type *value)
{
    double found = 0;
    const enum unit_status status = only_method(unit, reference);
    if (status != UNIT_OK)
        return status;
    unit_get(unit, reference, &found);
    *value = (whole_type)found;
    return UNIT_OK;
}

static enum unit_status set_whole(struct unit *unit, unsigned reference, const whole_type *value)
{
    const enum unit_status status = only_method(unit, reference);
    return status == UNIT_OK ? unit_set(unit, reference, (double)*value) : status;
}

static status_type get_wholes(instance_type instance, const char *call,
                              const reference_type references[], size_t n, whole_type values[],
                              size_t n_values)
{
    EACH(call, get_whole);
}

static status_type set_wholes(instance_type instance, const char *call,
                              const reference_type references[], size_t n,
                              const whole_type values[], size_t n_values)
{
    EACH(call, set_whole);
}

static status_type derivative(instance_type instance, const char *call,
                              const reference_type unknowns[], size_t n_unknowns,
                              const reference_type knowns[], size_t n_knowns, const double seed[],
                              size_t n_seed, int transposed, double sensitivity[],
                              size_t n_sensitivity)
{
    CALL(call, UNIT_INITIALIZATION | UNIT_RUNNING | UNIT_TERMINATED);
    const size_t in = transposed ? n_unknowns : n_knowns, out = transposed ? n_knowns : n_unknowns;
    if (!unknowns || !knowns || !seed || !sensitivity || n_seed != in || n_sensitivity != out)
        return null(unit, call);
    return (status_type)unit_derivative(unit, unknowns, n_unknowns, knowns, n_knowns, seed,
                                        transposed, sensitivity);
}

static void log_message(const struct unit *unit, enum unit_status status, const char *category,
                        const char *text)
{
    say((const struct importer *)unit->environment, unit->name, (status_type)status, category,
        text);
}

static struct unit *instantiate(const char *name, const char *token, int co_simulation, int logging,
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
    say(importer, name, FMI(Error), "logStatusError", "the token is not that of this model");
    unit_free(unit);
    free(kept);
    return NULL;
}

UNIT_SHOWN void FMI(FreeInstance)(instance_type instance)
{
    struct unit *unit = (struct unit *)instance;
    if (!unit || unit->busy)
        return;
    free(unit->environment);
    unit_free(unit);
}

UNIT_SHOWN status_type FMI(SetDebugLogging)(instance_type instance, FMI(Boolean) on, size_t n,
                                            const FMI(String) categories[])
{
    CALL(__func__, UNIT_ANY);
    if (n && !categories)
        return null(unit, __func__);
    unit->logging = on != 0;
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(ExitInitializationMode)(instance_type instance)
{
    CALL(__func__, UNIT_INITIALIZATION);
    return (status_type)unit_exit_initialization(unit);
}

UNIT_SHOWN status_type FMI(EnterContinuousTimeMode)(instance_type instance)
{
    CALL(__func__, UNIT_EVENT);
    *unit->mode = UNIT_CONTINUOUS;
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(Terminate)(instance_type instance)
{
    CALL(__func__, UNIT_RUNNING);
    *unit->mode = UNIT_TERMINATED;
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(Reset)(instance_type instance)
{
    CALL(__func__, UNIT_ANY);
    return (status_type)unit_reset(unit);
}

UNIT_SHOWN status_type FMI(GetFMUState)(instance_type instance, FMI(FMUState) * state)
{
    CALL(__func__, UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    if (*state) { /* the importer passes an earlier state, to be overwritten */
        memcpy(*state, unit->all, unit->n_all * sizeof *unit->all);
        return FMI(OK);
    }
    *state = unit_state(unit);
    return *state ? FMI(OK) : null(unit, __func__);
}

UNIT_SHOWN status_type FMI(SetFMUState)(instance_type instance, FMI(FMUState) state)
{
    CALL(__func__, UNIT_ANY);
    if (!state)
        return null(unit, __func__);
    return (status_type)unit_restore(unit, (const double *)state);
}

UNIT_SHOWN status_type FMI(FreeFMUState)(instance_type instance, FMI(FMUState) * state)
{
    CALL(__func__, UNIT_ANY | UNIT_WITHIN);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(SerializedFMUStateSize)(instance_type instance, FMI(FMUState) state,
                                                   size_t *size)
{
    CALL(__func__, UNIT_ANY);
    if (!state || !size)
        return null(unit, __func__);
    *size = unit_serial_size(unit);
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(SerializeFMUState)(instance_type instance, FMI(FMUState) state,
                                              FMI(Byte) bytes[], size_t size)
{
    CALL(__func__, UNIT_ANY);
    if (!state || !bytes || size != unit_serial_size(unit))
        return null(unit, __func__);
    unit_serialise(unit, (const double *)state, (unsigned char *)bytes);
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(DeserializeFMUState)(instance_type instance, const FMI(Byte) bytes[],
                                                size_t size, FMI(FMUState) * state)
{
    CALL(__func__, UNIT_ANY);
    double *found = bytes && state ? unit_deserialise(unit, (const unsigned char *)bytes, size)
                                   : NULL;
    if (!found)
        return (status_type)unit_say(unit, UNIT_ERROR, "logStatusError",
                                     "these bytes are no state of this model");
    free(*state);
    *state = found;
    return FMI(OK);
}

UNIT_SHOWN status_type FMI(CompletedIntegratorStep)(instance_type instance,
                                                    FMI(Boolean) no_set_state,
                                                    FMI(Boolean) * event_mode, FMI(Boolean) * ends)
{
    CALL(__func__, UNIT_CONTINUOUS);
    if (!event_mode || !ends)
        return null(unit, __func__);
    int event;
    const enum unit_status status = unit_completed(unit, &event);
    *event_mode = event != 0;
    *ends = 0;
    return (status_type)status;
}

UNIT_SHOWN status_type FMI(SetTime)(instance_type instance, double t)
{
    CALL(__func__, UNIT_EVENT | UNIT_CONTINUOUS);
    return (status_type)unit_set_time(unit, t);
}

#define NUMBERS(call, how)                                                         \
    UNIT_SHOWN status_type call(instance_type instance, double values[], size_t n) \
    {                                                                              \
        CALL(__func__, UNIT_ANY);                                                  \
        return (status_type)how(unit, values, n);                                  \
    }

NUMBERS(FMI(GetContinuousStates), unit_get_states)
NUMBERS(FMI(GetContinuousStateDerivatives), unit_derivatives)
NUMBERS(FMI(GetEventIndicators), unit_indicators)

UNIT_SHOWN status_type FMI(GetNominalsOfContinuousStates)(instance_type instance, double nominals[],
                                                          size_t n)
{
    CALL(__func__, UNIT_ANY);
    if (n != unit->n_x || (n && !nominals))
        return null(unit, __func__);
    for (size_t i = 0; i < n; i++)
        nominals[i] = 1;
    return FMI(OK);
}
