/* What the files of the stand-alone program share. */
#ifndef PROGRAM_H
#define PROGRAM_H

#include <stdio.h>

#include <pk/run.h>

/* Of the model; written by `pkgen build`: the settings of its scene, or defaults. */
extern const struct pk_run_model program_model;
extern const struct pk_run_settings program_settings;

struct program {
    const char *name;
    struct pk_run_settings settings;
    const char *output; /* NULL: standard output */
    int json, shows;
    const char *shard, *starts, *to; /* of a sweep: what is said of a shard, in JSON; its files */
    unsigned long first;             /* its first member, from 0 */
    void *lists[16];                 /* memory of keep() */
    size_t n_lists;
};

enum { OPTIONS_HELP = -1 };

/* 0, OPTIONS_HELP, or the exit code after a message. */
int options_read(struct program *p, int argc, char **argv);
void options_help(FILE *file);
void options_free(struct program *p);

/* Of shard.c: the members of a shard; the exit code. */
int shard_write(const struct program *p);
/* Of tables.c: an ensemble's CSV; 0, or the exit code after a message. */
int table_read(struct program *p, const char *path);
/* Of files.c: rows as an array with named columns; settings, columns and report in JSON; one line.
 */
int write_npy(const struct pk_run *run, const char *path);
void write_description(const struct program *p, struct pk_run *run, FILE *file);
void write_summary(struct pk_run *run, FILE *file);

/* Of names.c. A name of the model: `kind` p of a parameter, i of an input, q, v, o of an output, e
 * of an event, z, s of a size; its index and unit. 0: there is none. */
int find_name(const char *name, size_t length, char kind, size_t *index, const char **unit);
/* A number, in SI or with the unit that it is to have. 0: it is none. */
int read_number(const char *text, const char *unit, double *x);
/* Memory that options_free() gives back; ends the program where there is none. */
void *keep(struct program *p, void *old, size_t size);

#endif
