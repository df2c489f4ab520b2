/* Output besides CSV: rows as a NumPy array, and the description of a run in JSON. */
#define _POSIX_C_SOURCE 200809L

#include "../run/base/json.h"
#include "program.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int write_npy(const struct pk_run *run, const char *path)
{
    const double *rows, *low;
    const char *unit;
    char name[256], *header = NULL;
    size_t size = 0, columns;
    const size_t count = pk_run_rows(run, &rows, &low, &columns);
    FILE *file = fopen(path, "wb"), *head = open_memstream(&header, &size);
    if (!file || !head)
        return 1;
    fputs("{'descr': [", head);
    for (size_t i = 0; pk_run_column_name(run, i, name, sizeof name, &unit); i++) {
        fputs(i ? ", ('" : "('", head);
        for (const char *c = name; *c; c++)
            fprintf(head, *c == '\'' || *c == '\\' ? "\\%c" : "%c", *c);
        fputs("', '<f8')", head);
    }
    fprintf(head, "], 'fortran_order': False, 'shape': (%zu,), }", count);
    int failed = fclose(head) != 0;
    /* The file begins with a magic string, the version 1.0 and the header's length (10 bytes in
     * all). Blanks after the header make the whole a multiple of 64 bytes. */
    const size_t length = (size + 11 + 63) / 64 * 64 - 10;
    failed |= length > UINT16_MAX;
    if (!failed) {
        fprintf(file, "\x93NUMPY%c%c%c%c%s%*s\n", 1, 0, (int)(length & 255), (int)(length >> 8),
                header, (int)(length - size - 1), "");
        failed = count && fwrite(rows, columns * sizeof *rows, count, file) != count;
    }
    free(header);
    return fclose(file) || failed;
}

void write_description(const struct program *p, struct pk_run *run, FILE *file)
{
    struct json json = {.file = file}, *j = &json;
    const double *rows, *low;
    const char *unit;
    char name[256];
    size_t columns;
    json_open(j, NULL, '{');
    json_text(j, "model", program_model.system->name);
    json_text(j, "data", p->output ? p->output : "rows");
    json_open(j, "columns", '[');
    for (size_t i = 0; pk_run_column_name(run, i, name, sizeof name, &unit); i++) {
        json_open(j, NULL, '{');
        json_text(j, "name", name);
        json_text(j, "unit", unit);
        json_close(j, '}');
    }
    json_close(j, ']');
    json_raw(j, "report", pk_run_report(run));
    const size_t count = p->output ? 0 : pk_run_rows(run, &rows, &low, &columns);
    if (count)
        json_open(j, "rows", '[');
    for (size_t i = 0; i < count; i++)
        json_numbers(j, NULL, rows + i * columns, columns);
    if (count)
        json_close(j, ']');
    json_close(j, '}');
}

void write_summary(struct pk_run *run, FILE *file)
{
    const char *report = pk_run_report(run),
               *keys[] = {"\"t\": ", "\"steps\": ", "\"evaluations\": "};
    const char *const words[] = {"run: t = ", " after steps: ", ", evaluations: "};
    for (size_t k = 0; k < 3; k++) {
        const char *at = strstr(report, keys[k]);
        if (!at)
            return;
        at += strlen(keys[k]);
        fprintf(file, "%s%.*s", words[k], (int)strcspn(at, ",\n"), at);
    }
    fputc('\n', file);
}
