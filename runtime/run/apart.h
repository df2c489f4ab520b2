/* A run of a model whose blocks of coordinates are integrated apart; see pk/apart.h. */
#ifndef RUN_APART_H
#define RUN_APART_H

#include "output.h"

/* `part INDEX ...` of the settings: 0, or the exit code. */
int apart_setting(struct settings *settings, size_t line, char *const word[]);
/* 0, or the exit code: what no parts can do, and the choices that they are integrated by. */
int apart_choose(struct run *run);
int apart_begin(struct run *run);
void apart_integrate(struct run *run);
/* A member of the report's object, and a comma. */
void apart_report(const struct run *run, FILE *file);
void apart_free(struct run *run);

#endif
