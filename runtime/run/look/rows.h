/* Rows of a run. */
#ifndef RUN_ROWS_H
#define RUN_ROWS_H

#include "../base/state.h"

void rows_header(struct run *run);
/* The rows that a member has kept, behind those of the run. */
void rows_take(struct run *run, const struct run *from);
/* A column's value; `out` are the outputs there, where the system has any. */
pk_real rows_value(const struct run *run, const struct pk_run_column *column,
                   const struct moment *at, const pk_real *out);
/* All are written; the code with what there is to say. */
enum pk_run_code rows_end(struct run *run, enum pk_run_code code);
/* Whether all are. */
int rows_whole(const struct run *run);

#endif
