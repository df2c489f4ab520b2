/* A shard of a sweep, which is a part of its members. Reads the members' values from a file of
 * doubles and writes their results to another file: blocks of numbers, then a line of JSON with the
 * shapes of these blocks. Python writes the same format (pkgen_sweep/shards.py). The program that
 * calls this one appends a digest of the results and renames the file. */
#define _POSIX_C_SOURCE 200809L

#include "program.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Members per block: MEMBERS if only results are written, WITH_ROWS if rows are written, too. */
enum { MEMBERS = 1 << 14, WITH_ROWS = 1 << 8 };

static int wrong(const char *what, const char *path)
{
    fprintf(stderr, "run: cannot %s %s: %s\n", what, path, errno ? strerror(errno) : "it is short");
    return PK_RUN_USAGE;
}

/* Runs one block of members, and appends the shape and the report of its results to the texts. */
static int block(const struct program *p, size_t first, size_t count, const double *starts,
                 FILE *out, FILE *shapes, FILE *reports)
{
    struct pk_run_settings s = p->settings;
    const double *numbers = NULL, *rows = NULL, *low;
    size_t columns = 0, width = 0, n_rows = 0;
    s.members = count;
    s.member_values = starts;
    s.first_member = (long)first + 1;
    s.csv = -1;
    struct pk_run *run = pk_run_new(&program_model, &s);
    enum pk_run_code code = run ? pk_run_go(run) : PK_RUN_FAILED;
    const size_t n = run ? pk_run_members(run, &numbers, &columns) : 0;
    if (code == PK_RUN_DONE || (code == PK_RUN_FAILED && n == count)) {
        code = PK_RUN_DONE;
        if (!s.no_rows)
            n_rows = pk_run_rows(run, &rows, &low, &width);
        if (fwrite(numbers, columns * sizeof *numbers, n, out) != n ||
            (n_rows && fwrite(rows, width * sizeof *rows, n_rows, out) != n_rows))
            code = PK_RUN_USAGE;
        fprintf(shapes, "%s[%zu, %zu, %zu, %zu]", ftell(shapes) > 0 ? ", " : "", n, columns, n_rows,
                s.no_rows ? 0 : width);
        fprintf(reports, "%s%s", ftell(reports) > 0 ? ", " : "", pk_run_report(run));
    } else {
        fputs(run ? pk_run_messages(run) : "out of memory\n", stderr);
        code = code ? code : PK_RUN_FAILED;
    }
    pk_run_free(run);
    return code;
}

/* Runs all blocks of members, then writes a line of JSON. */
static int blocks(const struct program *p, FILE *in, FILE *out)
{
    const size_t n = p->settings.n_member_columns, most = p->settings.no_rows ? MEMBERS : WITH_ROWS;
    double *starts = (double *)malloc(most * n * sizeof *starts);
    char *texts[2] = {NULL, NULL};
    size_t sizes[2], count, first = (size_t)p->first;
    FILE *shapes = open_memstream(&texts[0], &sizes[0]);
    FILE *reports = open_memstream(&texts[1], &sizes[1]);
    int code = starts && shapes && reports ? PK_RUN_DONE : PK_RUN_FAILED;
    while (!code && (count = fread(starts, n * sizeof *starts, most, in)) > 0) {
        code = block(p, first, count, starts, out, shapes, reports);
        first += count;
    }
    if (shapes)
        fclose(shapes);
    if (reports)
        fclose(reports);
    if (!code)
        fprintf(out, "\n{%s, \"blocks\": [%s], \"reports\": [", p->shard, texts[0]);
    for (const char *c = code ? "" : texts[1]; *c; c++) /* line breaks in reports become blanks */
        fputc(*c == '\n' ? ' ' : *c, out);
    if (!code)
        fputs("]}\n", out);
    free(starts);
    free(texts[0]);
    free(texts[1]);
    return code;
}

int shard_write(const struct program *p)
{
    FILE *in = p->starts ? fopen(p->starts, "rb") : NULL;
    if (!p->starts || !p->to || !p->settings.n_member_columns) {
        fputs("run: --shard takes --starts and --to, of a program made for a sweep\n", stderr);
        return PK_RUN_USAGE;
    }
    if (!in)
        return wrong("read", p->starts);
    FILE *out = fopen(p->to, "wb");
    int code = out ? blocks(p, in, out) : wrong("write", p->to);
    fclose(in);
    errno = 0;
    if (out && (fflush(out) || ferror(out) || fsync(fileno(out))))
        code = wrong("write", p->to);
    if (out && fclose(out))
        code = wrong("write", p->to);
    if (out && code)
        remove(p->to);
    return code;
}
