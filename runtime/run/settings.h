/* Settings of a run as `pkgen run` writes them to standard input: one a line, words apart by
 * blanks, numbers in decimal or in C's hexadecimal.
 *
 *     method NAME | until X | every X | step X | rtol X | atol X | iteration newton|fixed
 *     max_steps N | param INDEX X [MEMBER] | start q|v|z INDEX X | input INDEX X | report PATH
 *     progress 0|1 | rows land|dense | size INDEX N
 *     show q|v|z|observed INDEX | show energy | at INDEX | hidden INDEX | watch events|times
 *     expect =|<|> A B WITHIN|- rows | expect ... t X | expect ... event INDEX
 *     drift INDEX | drift energy
 *     part INDEX method NAME | part INDEX step|rtol|h_max X
 *     diagnose NAME (of diagnose.c)
 *     ensemble PATH | members N | count NAME FIRST | column param|input|q|v|z INDEX | threads N
 *
 * Sizes come before parameters and starts. MEMBER counts from 0 in a family kept as a loop.
 *
 * Each `show` is a column of the rows, behind t; without any they have all columns. `at` is an event:
 * a row at each of its crossings, and others only if there is an `every`.
 * Of an ensemble events are looked for where there is a `watch`; `times` reports when each member
 * first met them.
 * What is `expect`ed are relations between outputs A and B, `=` up to a third one; what `drift`s is
 * measured over all steps. Outputs that are `hidden` are no columns.
 *
 * A `count` is the column in front that counts the members, from FIRST on; "member", from 1 on,
 * without. The file of an ensemble says what differs from member to member: a row of doubles, as they are
 * in memory, for each; in a row a number for each `column`, in their order.
 */
#ifndef RUN_SETTINGS_H
#define RUN_SETTINGS_H

#include <stdio.h>

#include <pk/pk.h>

/* The model that the program runs; and the blocks of coordinates that it is integrated in, each by
 * itself, or NULL. */
extern const struct pk_system *const run_model;
extern const struct pk_part *const run_parts;
extern const size_t run_n_parts;

/* A column of an ensemble's file. */
struct column {
    char kind; /* p of a parameter, i of an input, q, v, z */
    size_t index;
};

/* A column of the rows. */
struct shown {
    char kind; /* q, v, z, o of an observed value, e of the energy */
    size_t index;
};

/* A relation between columns, and by how much it was missed at the worst. */
struct expected {
    char relation; /* =, <, > */
    char when;     /* r in all rows, t at a time, e at an event */
    struct shown a, b, within;
    size_t event;
    int has_within;
    pk_real at;
    unsigned long count, missed;
    pk_real off, value, bound, allowed, t;
    size_t member;
};

/* An output whose drift is wanted, or the energy; of an ensemble the worst member's. */
struct drifting {
    int energy;
    size_t output, member, members;
    struct pk_drift drift;
    pk_real max;
};

/* What was said of one of the parts; 0: as for the whole. */
struct part_given {
    const struct pk_method *method;
    pk_real h, rtol, h_max;
};

struct settings {
    const struct pk_method *method;
    pk_real until, every; /* every: < 0 until / 1000, 0 each step */
    struct pk_options options;
    int has_rtol, has_every, has_step;
    int progress;
    int headless; /* rows without names above them */
    int land; /* rows: 1 by a step that ends there, 0 by dense output, -1 as the method is best */
    char *report;
    unsigned diagnose; /* flags of diagnose.h */
    size_t n; /* degrees of freedom */
    void *params, *params_block;
    struct member *set; /* members of families of parameters */
    size_t n_set;
    int begun; /* sizes are settled, memory is there */
    unsigned char *given; /* which parameters were set */
    pk_real *q, *v, *z, *u; /* z: of those that were given */
    unsigned char *start_given; /* 2 n flags, and of each quadrature */
    struct shown *show; /* NULL: all columns */
    size_t n_show;
    unsigned char *hidden; /* flags of outputs, or NULL */
    struct expected *expected;
    struct drifting *drifting;
    size_t n_expected, n_drifting;
    int watch; /* events of an ensemble's members; 2: and their first times are reported */
    size_t at; /* 1 + which event has rows; 0: none */
    char *ensemble; /* a path, or NULL: one trajectory */
    struct part_given *parts; /* NULL: nothing */
    size_t members, threads, n_columns;
    char *member_name; /* the column that counts members, or NULL: "member" */
    long first_member; /* and the number of the first */
    struct column *columns;
};

/* 0, or the process's exit code, with a message on standard error. */
int settings_read(struct settings *settings, const struct pk_system *system, FILE *file);
int settings_file(struct settings *settings, const struct pk_system *system, const char *path);
/* Of the model with these parameters, its inputs constant; the settings must stay where they are.
 * settings_motion(): without its quadratures, which no measure of methods is of, nor a run that
 * neither shows nor expects them. */
struct pk_problem settings_problem(struct settings *settings);
struct pk_problem settings_motion(struct settings *settings);
/* Whether a word, as "q0", "o2" or "e0", is a column. */
int settings_column(const struct settings *settings, const struct pk_system *system,
                    const char *word, struct shown *column);
int settings_shows_z(const struct settings *settings);
/* Quadratures at the start: those given, the others as the parameters say; and into an integrator. */
void settings_z(const struct settings *settings, const struct pk_system *system,
                const void *params, pk_real *z);
enum pk_status settings_quadratures(const struct settings *settings, struct pk_integrator *it);
/* Of parameters.c: memory and defaults once sizes are known; one size; one parameter; the defaults
 * that follow what was given. */
void settings_begin(struct settings *settings, const struct pk_system *system);
int settings_size(struct settings *settings, const struct pk_system *system, size_t line,
                  char *const word[]);
int settings_param(struct settings *settings, const struct pk_system *system, size_t line,
                   char *const word[]);
void settings_follow(struct settings *settings, const struct pk_system *system);
/* Which parameter prepare() refused, its value and bounds; of what follows from all, their values. */
void parameters_refused(FILE *file, const struct pk_system *system, const void *params, int outside);
/* Parameters and start as they are in memory, one JSON object, so that the same model in another
 * precision can have the same ones. */
void settings_tell(const struct settings *settings, FILE *file);
void settings_free(struct settings *settings);

/* The core's methods, then GSL's. */
const struct pk_method *run_method_find(const char *name);
const struct pk_method *run_method_at(size_t index);

#endif
