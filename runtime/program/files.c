/* What is written beside CSV: rows as a NumPy array, and the description of a run in JSON. */
#include "program.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static void text(FILE *file, const char *from, char quote)
{
    fputc(quote, file);
    for (; *from; from++) {
        if (*from == quote || *from == '\\')
            fputc('\\', file);
        fputc(*from, file);
    }
    fputc(quote, file);
}

/* Name and unit of column i of the rows; 0 behind the last. */
static int column(const struct pk_run *run, size_t i, char *name, size_t size, const char **unit)
{
    return pk_run_column_name(run, i, name, size, unit);
}

int write_npy(const struct program *p, const struct pk_run *run, const char *path)
{
    const double *rows, *low;
    const char *unit;
    char name[256], *header = NULL;
    size_t size, columns, length;
    const size_t count = pk_run_rows(run, &rows, &low, &columns);
    FILE *file = fopen(path, "wb"), *head = NULL;
    (void)p;
    if (!file || !(head = tmpfile()))
        return 1;
    fputs("{'descr': [", head);
    for (size_t i = 0; column(run, i, name, sizeof name, &unit); i++) {
        fputs(i ? ", (" : "(", head);
        text(head, name, '\'');
        fputs(", '<f8')", head);
    }
    fprintf(head, "], 'fortran_order': False, 'shape': (%zu,), }", count);
    /* The magic string, version 1.0 and the length; all of it a multiple of 64. */
    size = (size_t)ftell(head);
    length = (size + 11 + 63) / 64 * 64 - 10;
    header = (char *)malloc(size + 1);
    rewind(head);
    int failed = !header || fread(header, 1, size, head) != size || length > UINT16_MAX;
    /* clang-format off */
    const unsigned char begin[] = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0,
                                   (unsigned char)(length & 255), (unsigned char)(length >> 8)};
    /* clang-format on */
    if (!failed) {
        fwrite(begin, 1, sizeof begin, file);
        fwrite(header, 1, size, file);
        for (size_t i = size; i + 1 < length; i++)
            fputc(' ', file);
        fputc('\n', file);
        failed = count && fwrite(rows, columns * sizeof *rows, count, file) != count;
    }
    free(header);
    fclose(head);
    return fclose(file) || failed;
}

void write_description(const struct program *p, struct pk_run *run, FILE *file)
{
    const double *rows, *low;
    const char *unit;
    char name[256];
    size_t columns;
    fputs("{\"model\": ", file);
    text(file, program_model.system->name, '"');
    fputs(", \"data\": ", file);
    text(file, p->output ? p->output : "rows", '"');
    fputs(", \"columns\": [", file);
    for (size_t i = 0; column(run, i, name, sizeof name, &unit); i++) {
        fputs(i ? ", {\"name\": " : "{\"name\": ", file);
        text(file, name, '"');
        fputs(", \"unit\": ", file);
        text(file, unit, '"');
        fputs("}", file);
    }
    fprintf(file, "], \"report\": %s", pk_run_report(run));
    const size_t count = p->output ? 0 : pk_run_rows(run, &rows, &low, &columns);
    fputs(count ? ", \"rows\": [" : "", file);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < columns; k++)
            fprintf(file, "%s%.17g%s",
                    k   ? ", "
                    : i ? ", ["
                        : "[",
                    rows[i * columns + k], k + 1 < columns ? "" : "]");
    fputs(count ? "]}\n" : "}\n", file);
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
