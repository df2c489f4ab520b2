/* Parameters as text: which parameter was refused and why; all parameters as JSON. */
#include "settings.h"

#include "../base/numbers.h"

enum { MOST_TOLD = 12 }; /* limit of parameters listed in a message */

static void tell(FILE *file, const char *before, pk_real x)
{
    fputs(before, file);
    numbers_write(file, (double)x);
}

/* Returns the address of parameter i. If parameter i is a family of variable size, returns the
 * address of its first member. Sets *range to the size of the family. */
static const void *place(const struct pk_system *system, const void *params, size_t i,
                         struct pk_range *range)
{
    const void *at = (const char *)params + system->parameters[i].offset;
    *range = (struct pk_range){0, 1, 0};
    if (system->families.range)
        system->families.range(params, PK_OF_PARAMETER, i, range);
    if (range->is_family)
        memcpy(&at, at, sizeof at);
    return at;
}

/* Writes why the value x of parameter i is refused: it is not finite, or outside its bounds. All
 * members of a family have the same bounds. */
static void refused_one(FILE *file, const struct pk_system *system, const void *params, size_t i,
                        const struct pk_range *range, pk_real x)
{
    const struct pk_parameter *p = &system->parameters[i];
    pk_real *lo = calloc(2 * system->n_parameters, sizeof *lo), *hi = lo + system->n_parameters;
    fputs(p->what.name, file);
    if (!(x - x == 0)) {
        fputs(" is not finite", file);
    } else if (lo) {
        system->bounds(params, lo, hi);
        fputs(" is outside its bounds: ", file);
        if (range->is_family)
            fputs("a member", file);
        else
            tell(file, "", x);
        if (*p->what.unit)
            fprintf(file, " [%s]", p->what.unit);
        tell(file, p->lo_open ? " is not in (" : " is not in [", lo[i]);
        tell(file, ", ", hi[i]);
        fputc(p->hi_open ? ')' : ']', file);
    }
    free(lo);
}

static void refused(FILE *file, const struct pk_system *system, const void *params, int outside)
{
    const enum pk_failure failure = PK_FAILURE(outside);
    const int one = failure == PK_FAILURE_PARAMETER;
    if (failure == PK_FAILURE_SIZE) {
        fputs("a size is too small", file);
        return;
    }
    if (!one)
        fputs("what is computed from the parameters is not finite", file);
    for (size_t i = one ? (size_t)PK_FAILURE_AT(outside) : 0, told = 0;
         i < system->n_parameters && told < (one ? 1 : MOST_TOLD); i++) {
        const struct pk_quantity *what = &system->parameters[i].what;
        struct pk_range range;
        pk_real x = 0;
        const void *at = place(system, params, i, &range);
        if (!range.is_family)
            memcpy(&x, at, sizeof x);
        else if (!one)
            continue;
        if (one) {
            refused_one(file, system, params, i, &range, x);
        } else {
            fprintf(file, "%s%s", told ? ", " : ": ", what->name);
            tell(file, " = ", x);
            if (*what->unit)
                fprintf(file, " [%s]", what->unit);
        }
        told++;
    }
}

void settings_refused(struct pk_run *run, const void *params, int outside, const char *whose)
{
    char *text = NULL;
    refused(run_text(run, &text), run->settings.system, params, outside);
    run_text_end(run);
    run_say(run, "%s%s", whose, text);
    free(text);
}

void json_parameters_known(struct json *j, const struct pk_system *system, const void *params)
{
    json_open(j, "parameters", '[');
    for (size_t i = 0; i < system->n_parameters; i++) {
        struct pk_range range;
        const char *at = place(system, params, i, &range);
        for (size_t k = 0; k < range.count; k++) {
            pk_real x;
            memcpy(&x, at + k * sizeof x, sizeof x);
            json_real(j, NULL, x);
        }
    }
    json_close(j, ']');
}

void settings_tell(struct pk_run *run, FILE *file)
{
    const struct settings *s = &run->settings;
    struct json j = {.file = file};
    json_open(&j, NULL, '{');
    json_parameters_known(&j, s->system, s->params);
    json_open(&j, "families", '['); /* per parameter: length of the family, or 0 */
    for (size_t i = 0; i < s->system->n_parameters; i++) {
        const struct pk_range range = pk_system_range(s->system, s->params, PK_OF_PARAMETER, i);
        json_real(&j, NULL, range.is_family ? (pk_real)range.count : 0);
    }
    json_close(&j, ']');
    json_numbers(&j, "q", s->q, settings_coordinates(s));
    json_numbers(&j, "v", s->v, s->n);
    json_numbers(&j, "inputs", s->u, s->system->n_inputs);
    json_counts(&j, {"rotations", s->system->n_rotations},
                {"constraints", s->system->constraints.n},
                {"holonomic", s->system->constraints.n_holonomic});
    json_flag(&j, "conservative", (s->system->facts & PK_CONSERVATIVE) != 0);
    json_flag(&j, "autonomous", (s->system->facts & PK_AUTONOMOUS) != 0);
    json_open(&j, "cyclic", '[');
    for (size_t i = 0; s->system->cyclic && i < settings_coordinates(s); i++)
        if (s->system->cyclic[i])
            json_integer(&j, NULL, i);
    json_close(&j, ']');
    json_close(&j, '}');
}
