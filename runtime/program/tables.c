/* Reads the CSV file of an ensemble: a header of names, then a row of numbers for each member. */
#include "program.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static int wrong(const char *path, size_t line, const char *why)
{
    fprintf(stderr, "run: %s:%zu: %s\n", path, line, why);
    return PK_RUN_USAGE;
}

static char *cell(char **rest)
{
    char *from = *rest, *end = from + strcspn(from, ",\r\n");
    *rest = *end == ',' ? end + 1 : NULL;
    *end = '\0';
    while (*from == ' ')
        from++;
    return from;
}

int table_read(struct program *p, const char *path)
{
    enum { LINE = 1 << 20 };
    struct pk_run_settings *s = &p->settings;
    struct pk_run_column *columns = NULL;
    const char *unit;
    double *values = NULL;
    size_t n = 0, room = 0, line = 1;
    FILE *file = fopen(path, "r");
    char *text = keep(p, NULL, LINE);
    int code = 0;
    if (!file || !fgets(text, LINE, file)) {
        fprintf(stderr, "run: cannot read %s: %s\n", path, file ? "it is empty" : strerror(errno));
        return PK_RUN_USAGE;
    }
    for (char *rest = text; rest && !code;) {
        const char *name = cell(&rest), *kind = "piqv";
        columns = keep(p, columns, (n + 1) * sizeof *columns);
        while (*kind && !find_name(name, strlen(name), *kind, &columns[n].index, &unit))
            kind++;
        columns[n].member = 0;
        columns[n++].kind = *kind;
        code = *kind ? 0 : wrong(path, 1, "a column of no parameter, input, coordinate or rate");
    }
    while (!code && fgets(text, LINE, file)) {
        char *rest = text;
        line++;
        if (text[strspn(text, " ,\r\n")] == '\0')
            continue;
        if (s->members == room) {
            room = room ? 2 * room : 64;
            values = keep(p, values, room * n * sizeof *values);
        }
        for (size_t i = 0; i < n && !code; i++)
            if (!rest || !read_number(cell(&rest), "", &values[s->members * n + i]))
                code = wrong(path, line, "not a number in SI for each column");
        code = code || !rest ? code : wrong(path, line, "more numbers than columns");
        s->members++;
    }
    fclose(file);
    if (!code && !s->members)
        code = wrong(path, line, "no rows below the header");
    s->n_member_columns = n;
    s->member_columns = columns;
    s->member_values = values;
    return code;
}
