/* What `pkgen run --diagnose` asks for: made after the run, from its start, by its method. */
#ifndef RUN_DIAGNOSE_H
#define RUN_DIAGNOSE_H

#include "output.h"

enum {
    DIAGNOSE_LYAPUNOV = 1u << 0,
    DIAGNOSE_REVERSAL = 1u << 1,
    DIAGNOSE_SPECTRUM = 1u << 2,
    DIAGNOSE_SYMPLECTIC = 1u << 3,
    DIAGNOSE_LEAST_ACTION = 1u << 4,
    DIAGNOSE_ACTION = 1u << 5,
    DIAGNOSE_ANGULAR_MOMENTUM = 1u << 6,
    DIAGNOSE_LRL = 1u << 7,
    DIAGNOSE_MODES = 1u << 8,
    DIAGNOSE_ALL = (1u << 10) - 1, /* these, and that it is no error if one does not apply */
    DIAGNOSE_AREA = 1u << 10       /* of an ensemble, which has no other */
};

/* The flags of a name; 0: there is no such diagnostic. */
unsigned diagnose_flag(const char *name);
/* Keeps a row of the run: spectra are of rows, and steps, actions and modes are looked at there. */
void diagnose_row(struct run *run, pk_real t, const pk_real *q, const pk_real *v);
/* Makes what the settings ask for and keeps it as JSON for the report; messages on standard error.
 * Returns the exit code, `code` unless a diagnostic failed. */
int diagnose_run(struct run *run, int code);
/* `, "diagnostics": {...}`, or nothing. */
void diagnose_report(const struct run *run, FILE *file);
void diagnose_free(struct run *run);

#endif
