/* Sizes and parameters of a run: sizes first, since they say how many numbers there are, then
 * defaults, then what was given, then the defaults that follow.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "numbers.h"
#include "output.h"
#include "words.h"

enum { MOST_TOLD = 12 }; /* parameters */

/* A member of a family of parameters, to be set again once defaults have followed. */
struct member {
    size_t index, position;
    pk_real x;
};

/* Sizes are known: memory for what depends on them, and the defaults. */
void settings_begin(struct settings *s, const struct pk_system *system)
{
    if (s->begun)
        return;
    s->begun = 1;
    if (system->attach) {
        const size_t bytes = system->block_size(s->params);
        s->params_block = words_allocate(bytes, 1);
        system->attach(s->params, s->params_block);
    }
    s->n = pk_system_count(system, s->params);
    s->q = (pk_real *)words_allocate(2 * s->n + system->n_quadratures, sizeof *s->q);
    s->v = s->q + s->n;
    s->z = s->v + s->n;
    s->start_given = (unsigned char *)words_allocate(2 * s->n + system->n_quadratures, 1);
    system->defaults(s->params);
}

int settings_size(struct settings *s, const struct pk_system *system, size_t line,
                  char *const word[])
{
    size_t index, value;
    if (s->begun || !words_index(word[1], system->n_sizes, &index))
        return words_usage(line, s->begun ? "sizes come first" : "no such size", word[1]);
    if (!words_index(word[2], PTRDIFF_MAX / 64, &value) || value == 0)
        return words_usage(line, "not a size", word[2]);
    const ptrdiff_t length = (ptrdiff_t)value;
    memcpy((char *)s->params + system->sizes[index].offset, &length, sizeof length);
    return 0;
}

static void set_member(struct settings *s, const struct pk_system *system,
                       const struct member *member)
{
    pk_real *values;
    memcpy(&values, (char *)s->params + system->parameters[member->index].offset, sizeof values);
    values[member->position] = member->x;
}

int settings_param(struct settings *s, const struct pk_system *system, size_t line,
                   char *const word[])
{
    struct pk_range range = {0, 1, 0};
    struct member member;
    if (!words_index(word[1], system->n_parameters, &member.index))
        return words_usage(line, "no such parameter", word[1]);
    if (!words_real(word[2], &member.x))
        return words_usage(line, "not a number", word[2]);
    if (system->range)
        system->range(s->params, 1, member.index, &range);
    s->given[member.index] = 1;
    if (!range.is_family) {
        memcpy((char *)s->params + system->parameters[member.index].offset, &member.x,
               sizeof member.x);
        return 0;
    }
    if (!words_index(word[3], range.count, &member.position))
        return words_usage(line, "no such member", word[3]);
    struct member *more =
        (struct member *)realloc(s->set, (s->n_set + 1) * sizeof *more);
    if (!more)
        return words_usage(line, "out of memory", NULL);
    s->set = more;
    more[s->n_set++] = member;
    return 0;
}

/* Defaults that follow. Of a family of which some members are given, the others follow first. */
void settings_follow(struct settings *s, const struct pk_system *system)
{
    if (s->n_set) {
        unsigned char *whole = (unsigned char *)words_allocate(system->n_parameters, 1);
        memcpy(whole, s->given, system->n_parameters);
        for (size_t k = 0; k < s->n_set; k++)
            whole[s->set[k].index] = 0;
        system->derive(s->params, whole);
        free(whole);
        for (size_t k = 0; k < s->n_set; k++)
            set_member(s, system, &s->set[k]);
    }
    system->derive(s->params, s->given);
}

static void tell(FILE *file, pk_real x)
{
    if (isinf((double)x))
        fputs(x > 0 ? "inf" : "-inf", file);
    else
        numbers_write(file, (double)x);
}

void parameters_refused(FILE *file, const struct pk_system *system, const void *params, int outside)
{
    const size_t n = system->n_parameters, index = (size_t)outside - 1;
    if (index > n) {
        fputs("a size is too small", file);
        return;
    }
    if (index == n)
        fputs("what is computed from the parameters is not finite", file);
    pk_real *lo = (pk_real *)words_allocate(2 * n, sizeof *lo), *hi = lo + n;
    system->bounds(params, lo, hi);
    for (size_t i = index < n ? index : 0, told = 0; i < n && told < MOST_TOLD; i++) {
        const struct pk_parameter *p = &system->parameters[i];
        struct pk_range range = {0, 1, 0};
        char unit[80] = "";
        pk_real x = 0;
        if (system->range)
            system->range(params, 1, i, &range);
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

void settings_tell(const struct settings *s, FILE *file)
{
    fputs("{\"parameters\": [", file);
    for (size_t i = 0; i < run_model->n_parameters; i++) {
        pk_real x;
        memcpy(&x, (const char *)s->params + run_model->parameters[i].offset, sizeof x);
        fputs(i ? ", " : "", file);
        output_real(file, x);
    }
    fputs("]", file);
    numbers_list(file, "q", s->q, pk_system_coordinates(run_model, s->params));
    numbers_list(file, "v", s->v, s->n);
    fputs("}\n", file);
}
