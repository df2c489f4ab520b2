/* An ensemble in place of one trajectory: `member,t,...` rows, a report of who arrived. */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "output.h"

/* Reads the lines members, column, threads into the settings. 1 if it was one of them. */
int ensemble_setting(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[], int *code);
/* The number under which a member, from 0 on, is spoken of. */
long ensemble_number(const struct settings *s, size_t member);
/* Whether the members take fixed steps. */
int ensemble_fixed(const struct settings *s);
/* All of it, rows at `count` intervals of settings.every; the process's exit code. */
int ensemble_run(struct run *run, pk_real count);

/* Of main.c. */
int run_interrupted(void);
void run_interrupt(int whether);
/* A run of settings that were read: those that depend on one another, its memory and integrator; an
 * exit code. run_free() gives all back but the settings. */
int run_settle(struct run *run);
int run_start(struct run *run);
void run_free(struct run *run);
double run_now(void);
void run_progress(const struct run *run, double part, int force);
/* Of integrate.c. */
pk_real run_intervals(pk_real whole, pk_real part);

#endif
