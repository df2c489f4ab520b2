/* Diagnostics of `pkgen run --diagnose`, computed after the run, with its initial state and method.
 * They implement the table struct pk_run_diagnose of observers/observers.h. */
#ifndef RUN_DIAGNOSE_H
#define RUN_DIAGNOSE_H

#include "diagnostics.h"
#include "../base/json.h"
#include "../base/state.h"
#include "../observers/observers.h"

/* One flag per diagnostic. */
#define DIAGNOSE_PLACE(name, of, kernels) DIAGNOSE_PLACE_##name,
enum {
    DIAGNOSTICS(DIAGNOSE_PLACE) DIAGNOSE_PLACES,
    /* all diagnostics; inapplicable ones are no errors */
    DIAGNOSE_ALL = (1u << (DIAGNOSE_PLACES + 1)) - 1,
    DIAGNOSE_AREA = 1u << (DIAGNOSE_PLACES + 1) /* `area`, the only diagnostic of an ensemble */
};

void diagnose_report(const struct pk_run *run, struct json *j);
void diagnose_free(struct pk_run *run);
pk_real diagnose_exponent(struct pk_run *of);
extern const struct observer diagnose_observer, area_observer;

/* defined in area.c and area_find.c */
enum pk_run_code area_begin(struct pk_run *run, const pk_real *t, size_t count);
void area_note(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
enum pk_run_code area_find(struct pk_run *run, enum pk_run_code code, const char *gone);

#endif
