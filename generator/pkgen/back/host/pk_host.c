/* Parameters, initial states, and values at given states: see pk_host.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pk_host.h"

OF_THREAD char pk_host_text[PK_HOST_TEXT];

const char *pk_host_why(void) { return pk_host_text; }

int pk_host_refuse(const char *text)
{
    snprintf(pk_host_text, PK_HOST_TEXT, "%s", text);
    return 0;
}

static const struct pk_system *system_of(void) { return pk_host_model.system; }

/* Returns the number of members of parameter k, 1 unless it is a family, and sets *first to the
 * address of the first member. */
static size_t members(const void *params, size_t k, double **first)
{
    const struct pk_system *s = system_of();
    const struct pk_range range = pk_system_range(s, params, PK_OF_PARAMETER, k);
    char *const place = (char *)params + s->parameters[k].offset;
    if (range.is_family)
        memcpy(first, place, sizeof *first);
    else
        *first = (double *)(void *)place;
    return range.count;
}

size_t pk_host_parameters(const void *params)
{
    size_t count = 0;
    double *first;
    for (size_t k = 0; k < system_of()->n_parameters; k++)
        count += members(params, k, &first);
    return count;
}

size_t pk_host_params_size(void) { return system_of()->params_size; }

size_t pk_host_n(const void *params) { return pk_system_count(system_of(), params); }

size_t pk_host_coordinates(const void *params)
{
    return pk_system_coordinates(system_of(), params);
}

void *pk_host_params(size_t count, int own)
{
    const struct pk_system *s = system_of();
    const size_t size = s->params_size;
    const size_t structs = (count * size + sizeof(double) - 1) & ~(sizeof(double) - 1);
    char *params = (char *)calloc(1, structs);
    if (!params || !s->families.block_size) {
        if (params)
            s->defaults(params);
        return params;
    }
    s->families.set_sizes(params);
    const size_t block = s->families.block_size(params);
    free(params);
    params = (char *)calloc(1, structs + (own ? count : 1) * block);
    if (!params)
        return NULL;
    for (size_t i = 0; i < count; i++) {
        char *one = params + i * size;
        s->families.set_sizes(one);
        if (block)
            s->families.attach(one, params + structs + (own ? i : 0) * block);
    }
    s->defaults(params);
    return params;
}

void pk_host_params_free(void *params) { free(params); }

void pk_host_given(double *values)
{
    const struct pk_host_model *m = &pk_host_model;
    for (size_t i = 0; i < m->n_parameters; i++)
        values[i] = m->follows[i] ? (double)NAN : m->parameters[i];
}

void pk_host_inputs(double *u)
{
    for (size_t i = 0; i < system_of()->n_inputs; i++)
        u[i] = pk_host_model.inputs[i];
}

int pk_host_set(void *params, double *values)
{
    const struct pk_system *s = system_of();
    unsigned char *given = (unsigned char *)calloc(s->n_parameters + 1, 1);
    size_t flat = 0;
    double *first;
    if (!given)
        return pk_host_refuse("there is no memory");
    s->defaults(params);
    for (size_t k = 0; k < s->n_parameters; k++) {
        const size_t count = members(params, k, &first);
        for (size_t i = 0; i < count; i++, flat++)
            if (!isnan(values[flat])) {
                first[i] = values[flat];
                given[k] = 1;
            }
    }
    if (s->derive)
        s->derive(params, given);
    free(given);
    flat = 0;
    for (size_t k = 0; k < s->n_parameters; k++) {
        const size_t count = members(params, k, &first);
        for (size_t i = 0; i < count; i++)
            values[flat++] = first[i];
    }
    const int failure = s->prepare(params);
    if (!failure)
        return 1;
    if (PK_FAILURE(failure) != PK_FAILURE_PARAMETER)
        return pk_host_refuse("what is computed from the parameters is not finite");
    snprintf(pk_host_text, PK_HOST_TEXT, "%s is outside its bounds",
             s->parameters[PK_FAILURE_AT(failure)].what.name);
    return 0;
}

void pk_host_start(const void *params, double *y)
{
    const struct pk_host_model *m = &pk_host_model;
    const size_t n = pk_host_n(params), n_q = pk_host_coordinates(params);
    m->system->start(params, y, y + n);
    memmove(y + n_q, y + n, n * sizeof *y);
    for (size_t i = 0; m->start && i < n_q + n; i++)
        if (!m->start_follows[i] && !isnan(m->start[i]))
            y[i] = m->start[i];
}

/* Computes the accelerations of PK_LANES states at once, one state in each SIMD lane. Bit l of the
 * result is set if lane l failed. */
static unsigned long long block(const void *params, const double *t, const double *y,
                                const double *u, double *out, double *work)
{
    const size_t n = pk_host_n(params), n_q = pk_host_coordinates(params);
    const size_t n_u = system_of()->n_inputs, width = n_q + n;
    double *const q = work, *const v = q + n * PK_LANES, *const a = v + n * PK_LANES,
                  *const inputs = a + n * PK_LANES;
    for (size_t l = 0; l < PK_LANES; l++) {
        for (size_t i = 0; i < n; i++) {
            q[i * PK_LANES + l] = i < n_q ? y[l * width + i] : 0;
            v[i * PK_LANES + l] = y[l * width + n_q + i];
        }
        for (size_t i = 0; i < n_u; i++)
            inputs[i * PK_LANES + l] = u[l * n_u + i];
    }
    const unsigned long long failed = system_of()->lanes(params, t, q, v, inputs, a);
    for (size_t l = 0; l < PK_LANES; l++)
        for (size_t i = 0; i < n; i++)
            out[l * n + i] = a[i * PK_LANES + l];
    return failed;
}

/* Computes the values of one kind at one state. Returns 0 if the state has no such values. */
static int one(const void *params, int kind, double t, const double *y, const double *u,
               double *out, double *work)
{
    const struct pk_system *s = system_of();
    const double *const v = y + pk_host_coordinates(params);
    pk_kernel *const kernel = kind == PK_HOST_OUTPUTS ? s->observe : s->conserve;
    pk_kernel_2 *const momenta = s->unconstrained ? s->unconstrained : s->canonical;
    switch (kind) {
    case PK_HOST_ACCELERATIONS:
        return !s->acceleration(params, t, y, v, u, out);
    case PK_HOST_ENERGY:
        if (s->energy)
            *out = s->energy(params, t, y, v, u);
        return s->energy != NULL;
    case PK_HOST_MOMENTA:
        if (momenta)
            momenta(params, t, y, v, u, out, work);
        return momenta != NULL;
    default:
        if (kernel)
            kernel(params, t, y, v, u, out);
        return kernel != NULL;
    }
}

size_t pk_host_values(const void *params, int kind, size_t count, const double *t, const double *y,
                      const double *u, double *out)
{
    const struct pk_system *s = system_of();
    const size_t n = pk_host_n(params), n_u = s->n_inputs, n_y = pk_host_coordinates(params) + n;
    const size_t width = kind == PK_HOST_ENERGY    ? 1
                         : kind == PK_HOST_OUTPUTS ? pk_system_outputs(s, params)
                         : kind == PK_HOST_CLAIMS  ? s->n_conserved
                                                   : n;
    const int in_lanes = kind == PK_HOST_ACCELERATIONS && s->lanes && count >= PK_LANES;
    const size_t room = in_lanes ? PK_LANES * (3 * n + n_u) : kind == PK_HOST_MOMENTA ? n : 0;
    double *const work = room ? (double *)malloc(room * sizeof *work) : NULL;
    unsigned long long failed = 0;
    size_t good = 0;
    for (size_t k = 0; k < count; k++) {
        const size_t lane = k % PK_LANES;
        const int blocked = work && in_lanes && k - lane + PK_LANES <= count;
        double *const at = out + k * width;
        if (blocked && !lane)
            failed = block(params, t + k, y + k * n_y, u + k * n_u, at, work);
        if ((blocked && !(failed >> lane & 1)) ||
            ((work || kind != PK_HOST_MOMENTA) &&
             one(params, kind, t[k], y + k * n_y, u + k * n_u, at, work))) {
            good++;
            continue;
        }
        for (size_t i = 0; i < width; i++)
            at[i] = (double)NAN;
    }
    free(work);
    return good;
}
