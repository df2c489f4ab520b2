/* Finds names of the model, reads numbers, and allocates memory for the options. */
#include "program.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

void *keep(struct program *p, void *old, size_t size)
{
    size_t k = 0;
    while (k < p->n_lists && p->lists[k] != old)
        k++;
    void *memory = k < 16 ? realloc(old, size ? size : 1) : NULL;
    if (!memory) {
        fputs("run: out of memory\n", stderr);
        exit(PK_RUN_FAILED);
    }
    p->lists[k] = memory;
    p->n_lists += k == p->n_lists;
    return memory;
}

int find_name(const char *name, size_t length, char kind, size_t *index, const char **unit)
{
    const struct pk_system *s = program_model.system;
    const int families = s->families.count != NULL;
    const size_t one = sizeof(struct pk_quantity), n = families ? s->families.n_coordinates : s->n;
    const struct {
        char kind;
        const void *first; /* array of struct pk_quantity or of a struct that begins with one */
        size_t count, stride;
    } lists[] = {
        {'p', s->parameters, s->n_parameters, sizeof *s->parameters},
        {'i', s->inputs, s->n_inputs, one},
        {'q', s->coordinates, n - (families ? s->families.n_states : s->n_first_order), one},
        {'v', s->rates, n, one},
        {'o', s->observed, s->families.n_outputs ? s->families.n_outputs : s->n_observed, one},
        {'s', s->families.sizes, s->families.n_sizes, sizeof *s->families.sizes},
        {'e', s->events.table, s->events.n, sizeof *s->events.table},
    };
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
        for (size_t i = 0; lists[k].kind == kind && lists[k].first && i < lists[k].count; i++) {
            const void *place = (const char *)lists[k].first + i * lists[k].stride;
            const struct pk_quantity *q = place;
            if (strlen(q->name) != length || strncmp(q->name, name, length) != 0)
                continue;
            *index = i;
            *unit = q->unit;
            return 1;
        }
    return 0;
}

int read_number(const char *text, const char *unit, double *x)
{
    char *end;
    *x = strtod(text, &end);
    if (end == text || !(*x - *x == 0))
        return 0;
    while (isspace((unsigned char)*end))
        end++;
    if (*end == '\0')
        return 1;
    const size_t length = strlen(unit);
    return *unit && *end == '[' && strncmp(end + 1, unit, length) == 0 &&
           strcmp(end + 1 + length, "]") == 0;
}
