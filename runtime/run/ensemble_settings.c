/* What the settings of a run say of its members; see ensemble.c. */
#include <stdlib.h>
#include <string.h>

#include "ensemble.h"
#include "words.h"

int ensemble_setting(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[], int *code)
{
    const struct {
        const char *name;
        size_t count;
    } kinds[] = {{"param", system->n_parameters},
                 {"input", system->n_inputs},
                 {"q", pk_system_count(system, s->params)},
                 {"v", pk_system_count(system, s->params)},
                 {"z", system->n_quadratures}};
    char *end;
    const int members = strcmp(word[0], "members") == 0;
    size_t index;
    *code = 0;
    if (members || strcmp(word[0], "threads") == 0) {
        if (!words_index(word[1], (size_t)-1, members ? &s->members : &s->threads))
            *code = words_usage(line, "not a count", word[1]);
        return 1;
    }
    if (strcmp(word[0], "count") == 0) {
        s->first_member = word[1] && word[2] ? strtol(word[2], &end, 10) : 0;
        if (!word[1] || !word[2] || *end)
            *code = words_usage(line, "a count has a name and a first number", word[1]);
        else
            words_keep(&s->member_name, word[1]);
        return 1;
    }
    if (strcmp(word[0], "column") != 0)
        return 0;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strcmp(word[1], kinds[i].name) != 0)
            continue;
        if (!words_index(word[2], kinds[i].count, &index)) {
            *code = words_usage(line, "no such quantity", word[2]);
            return 1;
        }
        struct column *columns =
            (struct column *)realloc(s->columns, (s->n_columns + 1) * sizeof *columns);
        if (!columns) {
            *code = words_usage(line, "out of memory", NULL);
            return 1;
        }
        s->columns = columns;
        columns[s->n_columns++] = (struct column){kinds[i].name[0], index};
        return 1;
    }
    *code = words_usage(line, "a column is of param, input, q, v or z", word[1]);
    return 1;
}
