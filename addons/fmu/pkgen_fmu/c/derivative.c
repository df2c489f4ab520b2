/* Directional derivatives of a unit's variables by states, time and inputs. Derivatives of state
 * rates by states and time are exact, from the model's kernel `linear`; all other derivatives are
 * finite differences of sixth order, with errors of about 1e-11. */
#include "unit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <pk/linear.h>

enum { LEVELS = 3, TRIES = 6 };

/* Returns the address of the variable with value reference `known`; NULL if the variable is no
 * state, time or input. */
static double *moved(struct unit *unit, unsigned known)
{
    const size_t i = unit_index_of(known);
    const enum unit_kind kind = unit_kind_of(known);
    if (kind == UNIT_TIME && i == 0)
        return unit->time;
    if (kind == UNIT_INPUT && i < unit->n_inputs)
        return unit->inputs + i;
    if (kind == UNIT_STATE && i < unit->n_x)
        return unit->y + i;
    return NULL;
}

static enum unit_status values(struct unit *unit, const unsigned *unknowns, size_t n, double *out)
{
    enum unit_status status = UNIT_OK;
    unit_forget(unit);
    for (size_t i = 0; i < n && status == UNIT_OK; i++) {
        status = unit_get(unit, unknowns[i], out + i);
        if (status == UNIT_OK && !isfinite(out[i]))
            status = UNIT_DISCARD;
    }
    return status;
}

/* Sets the variables `knowns` to the values `at` + e `seed`, and computes the variables
 * `unknowns`. */
static enum unit_status beside(struct unit *unit, const unsigned *unknowns, size_t n,
                               const unsigned *knowns, size_t n_knowns, const double *seed,
                               const double *at, double e, double *out)
{
    for (size_t k = 0; k < n_knowns; k++)
        *moved(unit, knowns[k]) = at[k];
    for (size_t k = 0; k < n_knowns; k++)
        *moved(unit, knowns[k]) += e * seed[k];
    return values(unit, unknowns, n, out);
}

/* Computes J `seed`, where J is the Jacobian of the unknowns by the knowns, from central
 * differences with steps e, e/2, e/4 and Richardson extrapolation. */
static enum unit_status differences(struct unit *unit, const unsigned *unknowns, size_t n,
                                    const unsigned *knowns, size_t n_knowns, const double *seed,
                                    double *out)
{
    double *const at = (double *)malloc((n_knowns + (LEVELS + 1) * n + 1) * sizeof *at);
    if (!at)
        return unit_say(unit, UNIT_ERROR, "logStatusError", "there is no memory");
    double *const table = at + n_knowns, *const back = table + LEVELS * n, size = 0;
    for (size_t k = 0; k < n_knowns; k++) {
        at[k] = *moved(unit, knowns[k]);
        size = fmax(size, fabs(seed[k]) / (1 + fabs(at[k])));
    }
    memset(out, 0, n * sizeof *out);
    enum unit_status status = UNIT_OK;
    double e = 0.02 / size;
    void (*const log)(const struct unit *, enum unit_status, const char *, const char *) =
        unit->log;
    unit->log = NULL; /* no log: the model may fail at a displaced state */
    for (int tries = 0; size > 0 && tries < TRIES; tries++, e /= 16) {
        double h = e;
        for (size_t level = 0; level < LEVELS; level++, h /= 2) {
            double *const row = table + level * n;
            status = beside(unit, unknowns, n, knowns, n_knowns, seed, at, h, row);
            if (status == UNIT_OK)
                status = beside(unit, unknowns, n, knowns, n_knowns, seed, at, -h, back);
            if (status != UNIT_OK)
                break;
            for (size_t i = 0; i < n; i++)
                row[i] = (row[i] - back[i]) / (2 * h);
        }
        if (status == UNIT_OK)
            break;
    }
    for (size_t i = 0; i < n && size > 0; i++) {
        const double a = table[i], b = table[n + i], c = table[2 * n + i];
        const double ab = b + (b - a) / 3, bc = c + (c - b) / 3;
        out[i] = bc + (bc - ab) / 15;
    }
    for (size_t k = 0; k < n_knowns; k++)
        *moved(unit, knowns[k]) = at[k];
    unit_forget(unit);
    unit->log = log;
    free(at);
    if (status != UNIT_OK)
        unit_say(unit, UNIT_DISCARD, "logStatusDiscard", "there are no derivatives at t = %g",
                 *unit->time);
    return status;
}

/* Computes the directional derivatives of the n accelerations along `seed` by the kernel `linear`.
 * Returns UNIT_DISCARD if the model has no such kernel, or if one of the knowns is an input. */
static enum unit_status exactly(struct unit *unit, const unsigned *knowns, size_t n_knowns,
                                const double *seed, double *out)
{
    const size_t n = unit->n;
    const struct pk_problem problem = unit_problem(unit);
    for (size_t k = 0; k < n_knowns; k++)
        if (unit_kind_of(knowns[k]) == UNIT_INPUT)
            return UNIT_DISCARD;
    if (!unit->system->linear)
        return UNIT_DISCARD;
    const size_t work = pk_system_linear_size(&problem);
    double *const a = (double *)malloc((2 * n + 2 * n * n + work + 1) * sizeof *a);
    if (!a)
        return UNIT_DISCARD;
    double *const a_q = a + n, *const a_v = a_q + n * n, *const a_t = a_v + n * n;
    const enum pk_status found =
        pk_system_linear(&problem, *unit->time, unit->y, unit_v(unit), a, a_q, a_v, a_t, a_t + n);
    memset(out, 0, n * sizeof *out);
    for (size_t k = 0; k < n_knowns && found == PK_DONE; k++) {
        const size_t j = unit_index_of(knowns[k]);
        for (size_t i = 0; i < n; i++)
            out[i] += seed[k] * (unit_kind_of(knowns[k]) == UNIT_TIME ? a_t[i]
                                 : j < unit->n_q ? a_q[i * n + j]
                                                 : a_v[i * n + (j - unit->n_q)]);
    }
    free(a);
    return found == PK_DONE ? UNIT_OK : UNIT_DISCARD;
}

/* Computes J `seed`, where J is the Jacobian of the unknowns by the knowns: exactly by the kernel
 * `linear` if possible, or else by finite differences. */
static enum unit_status along(struct unit *unit, const unsigned *unknowns, size_t n,
                              const unsigned *knowns, size_t n_knowns, const double *seed,
                              double *out)
{
    int rates_alone = 1;
    for (size_t i = 0; i < n; i++)
        rates_alone &= unit_kind_of(unknowns[i]) == UNIT_RATE;
    double *const rates = (double *)malloc((unit->n + 1) * sizeof *rates);
    if (rates_alone && rates && exactly(unit, knowns, n_knowns, seed, rates) == UNIT_OK) {
        for (size_t i = 0; i < n; i++) {
            const size_t j = unit_index_of(unknowns[i]);
            out[i] = j < unit->n_q ? 0 : rates[j - unit->n_q];
            for (size_t k = 0; k < n_knowns && j < unit->n_q; k++)
                if (unit_kind_of(knowns[k]) == UNIT_STATE &&
                    unit_index_of(knowns[k]) == unit->n_q + j)
                    out[i] += seed[k];
        }
        free(rates);
        return UNIT_OK;
    }
    free(rates);
    return differences(unit, unknowns, n, knowns, n_knowns, seed, out);
}

enum unit_status unit_derivative(struct unit *unit, const unsigned *unknowns, size_t n_unknowns,
                                 const unsigned *knowns, size_t n_knowns, const double *seed,
                                 int transposed, double *sensitivity)
{
    enum unit_status status = unit_refresh(unit);
    if (status != UNIT_OK)
        return status;
    for (size_t k = 0; k < n_knowns; k++)
        if (!moved(unit, knowns[k]))
            return unit_say(unit, UNIT_ERROR, "logStatusError",
                            "there are no derivatives by variable %u", knowns[k]);
    for (size_t i = 0; i < n_unknowns; i++) {
        double ignored;
        const enum unit_kind kind = unit_kind_of(unknowns[i]);
        if (kind != UNIT_RATE && kind != UNIT_OUTPUT && kind != UNIT_ENERGY && kind != UNIT_CLAIM &&
            kind != UNIT_INDICATOR && kind != UNIT_STATE)
            return unit_say(unit, UNIT_ERROR, "logStatusError",
                            "there are no derivatives of variable %u", unknowns[i]);
        status = unit_get(unit, unknowns[i], &ignored);
        if (status != UNIT_OK)
            return status;
    }
    if (!transposed)
        return along(unit, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
    double *const column = (double *)malloc((n_unknowns + 1) * sizeof *column);
    const double one = 1;
    if (!column)
        return unit_say(unit, UNIT_ERROR, "logStatusError", "there is no memory");
    for (size_t k = 0; k < n_knowns && status == UNIT_OK; k++) {
        status = along(unit, unknowns, n_unknowns, knowns + k, 1, &one, column);
        sensitivity[k] = 0;
        for (size_t i = 0; i < n_unknowns; i++)
            sensitivity[k] += seed[i] * column[i];
    }
    free(column);
    return status;
}
