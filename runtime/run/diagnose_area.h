/* Poincare's integral invariant of an ensemble whose members are a closed loop of starts. */
#ifndef RUN_DIAGNOSE_AREA_H
#define RUN_DIAGNOSE_AREA_H

#include "output.h"

/* Room for q and p of all members at all rows, the start among them; else the exit code. */
int area_begin(struct run *run, size_t rows);
/* A member's state at row number `row`, its parameters in the settings. */
void area_note(struct run *run, size_t row, pk_real t, const pk_real *q, const pk_real *v);
/* What came of it, as JSON for the report; returns the exit code, `code` unless it failed. */
int area_find(struct run *run, int code);

#endif
