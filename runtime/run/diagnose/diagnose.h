/* What `pkgen run --diagnose` asks for: made after the run, from its start, by its method. */
#ifndef RUN_DIAGNOSE_H
#define RUN_DIAGNOSE_H

#include "diagnostics.h"
#include "../base/json.h"
#include "../base/state.h"

/* Flags, one a diagnostic. */
#define DIAGNOSE_PLACE(name, of, kernels) DIAGNOSE_PLACE_##name,
enum {
    DIAGNOSTICS(DIAGNOSE_PLACE) DIAGNOSE_PLACES,
    DIAGNOSE_ALL = (1u << (DIAGNOSE_PLACES + 1)) - 1, /* these, and that it is no error if one does
                                                         not apply */
    DIAGNOSE_AREA = 1u << (DIAGNOSE_PLACES + 1)       /* of an ensemble, which has no other */
};

/* Makes what the settings ask for and keeps it as JSON for the report; messages too.
 * The code, `code` unless a diagnostic failed. */
enum pk_run_code diagnose_run(struct pk_run *run, enum pk_run_code code);
/* The member "diagnostics", or nothing. */
void diagnose_report(const struct pk_run *run, struct json *j);
void diagnose_free(struct pk_run *run);

/* Of an ensemble whose members are a closed loop of starts: area.c.
 * Room for them at the start and `count` times; else the exit code. */
enum pk_run_code area_begin(struct pk_run *run, const pk_real *t, size_t count);
/* A member's state, its parameters in the settings; kept where it is at the next of its rows. */
void area_note(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
/* What came of it, as JSON for the report; returns the exit code, `code` unless it failed. */
enum pk_run_code area_find(struct pk_run *run, enum pk_run_code code, const char *gone);

#endif
