/* Parameters in words: which one was refused, all that there are. */
#include "settings.h"

#include "../base/numbers.h"

enum { MOST_TOLD = 12 }; /* parameters */

static void tell(FILE *file, pk_real x)
{
    if (isinf((double)x))
        fputs(x > 0 ? "inf" : "-inf", file);
    else
        numbers_write(file, (double)x);
}

static void refused(FILE *file, const struct pk_system *system, const void *params, int outside)
{
    const enum pk_failure failure = PK_FAILURE(outside);
    const size_t n = system->n_parameters;
    const size_t index = failure == PK_FAILURE_PARAMETER ? (size_t)PK_FAILURE_AT(outside) : n;
    if (failure == PK_FAILURE_SIZE) {
        fputs("a size is too small", file);
        return;
    }
    if (index == n)
        fputs("what is computed from the parameters is not finite", file);
    pk_real *lo = (pk_real *)calloc(2 * n + 1, sizeof *lo), *hi = lo + n;
    if (!lo)
        return;
    system->bounds(params, lo, hi);
    for (size_t i = index < n ? index : 0, told = 0; i < n && told < MOST_TOLD; i++) {
        const struct pk_parameter *p = &system->parameters[i];
        struct pk_range range = {0, 1, 0};
        char unit[80] = "";
        pk_real x = 0;
        if (system->families.range)
            system->families.range(params, 1, i, &range);
        if (!range.is_family)
            memcpy(&x, (const char *)params + p->offset, sizeof x);
        if (*p->what.unit)
            snprintf(unit, sizeof unit, " [%s]", p->what.unit);
        if (index == n && range.is_family)
            continue;
        fprintf(file, index < n ? "%s" : told++ ? ", %s = " : ": %s = ", p->what.name);
        if (index == n) {
            tell(file, x);
            fputs(unit, file);
            continue;
        }
        if (!(x - x == 0)) {
            fputs(" is not finite", file);
            break;
        }
        fputs(" is outside its bounds: ", file);
        if (range.is_family)
            fputs("a member", file);
        else
            tell(file, x);
        fprintf(file, "%s is not in %c", unit, p->lo_open ? '(' : '[');
        tell(file, lo[i]);
        fputs(", ", file);
        tell(file, hi[i]);
        fputc(p->hi_open ? ')' : ']', file);
        break;
    }
    free(lo);
}

void settings_refused(struct pk_run *run, const void *params, int outside, const char *whose)
{
    char *text = NULL;
    refused(run_text(run, &text), run->settings.system, params, outside);
    run_text_end(run);
    run_say(run, "%s%s", whose, text);
    free(text);
}

void json_parameters(struct json *j, const struct pk_system *system, const void *params)
{
    json_open(j, "parameters", '[');
    for (size_t i = 0; i < system->n_parameters; i++) {
        pk_real x;
        memcpy(&x, (const char *)params + system->parameters[i].offset, sizeof x);
        json_real(j, NULL, x);
    }
    json_close(j, ']');
}

void settings_tell(const struct settings *s, FILE *file)
{
    struct json j = {.file = file};
    json_open(&j, NULL, '{');
    json_parameters(&j, s->system, s->params);
    json_numbers(&j, "q", s->q, pk_system_coordinates(s->system, s->params));
    json_numbers(&j, "v", s->v, s->n);
    json_close(&j, '}');
}
