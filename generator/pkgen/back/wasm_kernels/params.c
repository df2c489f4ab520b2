/* The structs of parameters, with memory for the arrays (families) that they point to. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "live.h"

OF_THREAD char live_reason_text[LONGEST_TEXT];

int refuse(const char *text)
{
    snprintf(live_reason_text, LONGEST_TEXT, "%s", text);
    return 0;
}

const char *EXPORT(live_why)(void) { return live_reason_text; }

static size_t members(const void *params, size_t k, pk_real **first)
{
    const struct pk_system *s = live_system;
    struct pk_range range = {0, 1, 0};
    if (s->families.range)
        s->families.range(params, 1, k, &range);
    char *place = (char *)params + s->parameters[k].offset;
    if (range.is_family)
        memcpy(first, place, sizeof *first);
    else
        *first = (pk_real *)(void *)place;
    return range.count;
}

size_t EXPORT(live_parameters)(void *params)
{
    size_t count = 0;
    pk_real *first;
    for (size_t k = 0; k < live_system->n_parameters; k++)
        count += members(params, k, &first);
    return count;
}

size_t EXPORT(live_params_size)(void) { return live_system->params_size; }

/* Allocates `count` structs in a row, each with its own memory for families if `own`, otherwise all
 * sharing one. Only the first has its defaults set. Returns NULL without memory. */
void *EXPORT(live_params)(size_t count, int own)
{
    const struct pk_system *s = live_system;
    const size_t size = s->params_size;
    const size_t structs = (count * size + sizeof(pk_real) - 1) & ~(sizeof(pk_real) - 1);
    char *params = (char *)calloc(1, structs);
    if (!params || !s->families.block_size) {
        if (params)
            s->defaults(params);
        return params;
    }
    s->families.set_sizes(params);
    const size_t block = s->families.block_size(params);
    const size_t all = structs + (own ? count : 1) * block;
    free(params);
    params = (char *)calloc(1, all);
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

void EXPORT(live_params_free)(void *params) { free(params); }

/* Sets the parameters from `values` (NaN: the default) and writes all resulting values back.
 * Returns 1, or 0 with a reason, like a parameter out of bounds. */
int EXPORT(live_set)(void *params, double *values)
{
    const struct pk_system *s = live_system;
    unsigned char *given = (unsigned char *)calloc(s->n_parameters + 1, 1);
    size_t flat = 0;
    pk_real *first;
    if (!given)
        return refuse("there is no memory");
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
    if (PK_FAILURE(failure) == PK_FAILURE_PARAMETER) {
        const size_t k = (size_t)PK_FAILURE_AT(failure);
        snprintf(live_reason_text, LONGEST_TEXT, "%s is outside its bounds",
                 s->parameters[k].what.name);
        return 0;
    }
    return refuse("what is computed from the parameters is not finite");
}

size_t EXPORT(live_n)(const void *params) { return pk_system_count(live_system, params); }

size_t EXPORT(live_n_q)(const void *params) { return pk_system_coordinates(live_system, params); }

void EXPORT(live_start)(const void *params, double *q, double *v)
{
    live_system->start(params, q, v);
}
