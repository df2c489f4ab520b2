/* Settings of a run as `pkgen run` writes them to standard input: one a line, words apart by
 * blanks, numbers in decimal or in C's hexadecimal.
 *
 *     method NAME | until X | every X | step X | rtol X | atol X | iteration newton|fixed
 *     max_steps N | param INDEX X | start q|v INDEX X | input INDEX X | report PATH
 *     progress 0|1 | rows land|dense
 */
#ifndef RUN_SETTINGS_H
#define RUN_SETTINGS_H

#include <stdio.h>

#include <pk/pk.h>

/* The model that the program runs. */
extern const struct pk_system *const run_system;

struct settings {
    const struct pk_method *method;
    pk_real until, every; /* every: < 0 until / 1000, 0 each step */
    struct pk_options options;
    int has_rtol, has_atol;
    int progress;
    int land; /* rows: 1 by a step that ends there, 0 by dense output, -1 as the method is best */
    char *report;
    void *params;
    unsigned char *given; /* which parameters were set */
    pk_real *q, *v, *u;
    unsigned char *start_given; /* 2 n flags */
};

/* 0, or the process's exit code, with a message on standard error. */
int settings_read(struct settings *settings, const struct pk_system *system, FILE *file);
void settings_free(struct settings *settings);

/* The core's methods, then GSL's. */
const struct pk_method *run_method_find(const char *name);
const struct pk_method *run_method_at(size_t index);

#endif
