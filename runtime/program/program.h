/* State and functions shared by the files of the stand-alone program. */
#ifndef PROGRAM_H
#define PROGRAM_H

#include <stdio.h>

#include <pk/run.h>

/* The model, and the settings of its scene or defaults; `pkgen build` writes both. */
extern const struct pk_run_model program_model;
extern const struct pk_run_settings program_settings;

struct program {
    const char *name;
    struct pk_run_settings settings;
    const char *output; /* file to which rows are written; NULL: standard output */
    /* flags: write the report on standard output; show the progress on the terminal */
    int json, shows;
    /* For a shard (some members of a sweep): text in JSON that describes it, file of the members'
     * initial values, and file for their results. */
    const char *shard, *starts, *to;
    unsigned long first; /* index in the sweep of the shard's first member */
    void *lists[16];     /* memory allocated by keep() */
    size_t n_lists;
};

enum { OPTIONS_HELP = -1 };

/* Reads the options. Returns 0, OPTIONS_HELP, or the exit code after a message. */
int options_read(struct program *p, int argc, char **argv);
void options_help(FILE *file);
void options_free(struct program *p);

/* In shard.c: runs the members of a shard; returns the exit code. */
int shard_write(const struct program *p);
/* In tables.c: reads an ensemble's CSV; returns 0, or the exit code after a message. */
int table_read(struct program *p, const char *path);
/* In files.c: write_npy() writes rows as a NumPy array; write_description() writes columns, report
 * and rows in JSON; write_summary() writes one line. */
int write_npy(const struct pk_run *run, const char *path);
void write_description(const struct program *p, struct pk_run *run, FILE *file);
void write_summary(struct pk_run *run, FILE *file);

/* In names.c: finds a name of the model and sets its index and unit; returns 0 if there is none.
 * `kind`: p parameter, i input, q coordinate, v rate, o output, e event, s size. */
int find_name(const char *name, size_t length, char kind, size_t *index, const char **unit);
/* Reads a number in SI, which may be followed by [unit]. Returns 0 if it is not a finite number. */
int read_number(const char *text, const char *unit, double *x);
/* Resizes `old`, or allocates if it is NULL; options_free() frees it. Exits if memory runs out. */
void *keep(struct program *p, void *old, size_t size);

#endif
