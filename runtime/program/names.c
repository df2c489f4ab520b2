/* Names of the model, numbers and memory of what is read. */
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

static int among(const struct pk_quantity *list, size_t count, size_t stride, const char *name,
                 size_t length, size_t *index, const char **unit)
{
    for (size_t i = 0; list && i < count; i++) {
        const struct pk_quantity *q =
            (const struct pk_quantity *)(const void *)((const char *)list + i * stride);
        if (strlen(q->name) == length && strncmp(q->name, name, length) == 0) {
            *index = i;
            *unit = q->unit;
            return 1;
        }
    }
    return 0;
}

int find_name(const char *name, size_t length, char kind, size_t *index, size_t *member,
              const char **unit)
{
    const struct pk_system *s = program_model.system;
    const size_t one = sizeof(struct pk_quantity),
                 n = s->families.count ? s->families.n_coordinates : s->n;
    const size_t rates = s->families.count ? 2 * s->families.n_coordinates : s->n;
    *member = 0;
    switch (kind) {
    case 'p':
        return s->n_parameters && among(&s->parameters->what, s->n_parameters,
                                        sizeof *s->parameters, name, length, index, unit);
    case 'i':
        return among(s->inputs, s->n_inputs, one, name, length, index, unit);
    case 'q':
        return among(s->coordinates, n - (s->families.count ? 0 : s->n_first_order), one, name,
                     length, index, unit);
    case 'v':
        return among(s->rates, s->families.count ? n : rates, one, name, length, index, unit);
    case 'o':
        return among(s->observed, s->n_observed, one, name, length, index, unit);
    case 'z':
        return among(s->quadratures.names, s->quadratures.n, one, name, length, index, unit);
    case 's':
        return s->families.n_sizes && among(&s->families.sizes->what, s->families.n_sizes,
                                            sizeof *s->families.sizes, name, length, index, unit);
    default:
        return s->events.n && among(&s->events.table->what, s->events.n, sizeof *s->events.table,
                                    name, length, index, unit);
    }
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
