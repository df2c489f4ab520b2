/* State and functions shared by the files of --diagnose. */
#ifndef RUN_DIAGNOSE_PARTS_H
#define RUN_DIAGNOSE_PARTS_H

#include "../base/json.h"
#include "../observers/observers.h"
#include "diagnostics.h"
#include "motion.h"

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
extern const struct observer diagnose_observer, area_observer, tape_observer;

/* defined in area.c and area_find.c */
enum pk_run_code area_begin(struct pk_run *run, const pk_real *t, size_t count);
void area_note(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
enum pk_run_code area_find(struct pk_run *run, enum pk_run_code code, const char *gone);

struct diagnostics {
    pk_real *rows; /* t, q, v of each row kept during the run */
    size_t n_rows, room;
    char *text;       /* the JSON object of all diagnostics */
    struct json json; /* writer of `text` */
    struct pk_run *run;
    const char *name; /* name of the current diagnostic */
    enum pk_run_code code;
    int all;         /* whether `all` was requested */
    double exponent; /* largest Lyapunov exponent if PK_CHAOTIC, else 0 */
};

/* diagnose_open() opens the JSON object of all diagnostics; diagnose_close() closes it. */
struct diagnostics *diagnose_open(struct pk_run *run);
void diagnose_close(struct diagnostics *d);
/* Writes one member of the JSON object of all diagnostics by make(): status and reason first. */
void diagnose_one(struct diagnostics *d, const char *name, void (*make)(struct diagnostics *d));
/* Returns row k of `count` rows that are spread evenly over all kept rows. */
const pk_real *diagnose_row(const struct diagnostics *d, size_t k, size_t count);
/* Writes the status and its reason. If `reason` is NULL, the reason is that of the failed
 * integrator `it`; if `it` is NULL, it is the text of the status. Returns 1 if the diagnostic
 * succeeded, so that its numbers must follow. */
int diagnose_told(struct diagnostics *d, enum pk_status status, const char *reason,
                  const struct pk_integrator *it);
#define DIAGNOSE_NEEDS_GSL(name)                                                               \
    void diagnose_##name(struct diagnostics *d)                                                \
    {                                                                                          \
        diagnose_told(d, PK_REFUSED, "it needs the GNU Scientific Library, which is not here", \
                      NULL);                                                                   \
    }

/* Returns the motion of a run from its start to its end. */
struct motion motion_of(struct pk_run *run);
/* Returns why (q, p) are no independent canonical coordinates, or NULL if they are. */
const char *diagnose_not_free(const struct pk_system *system);
/* Returns why there are no variational equations, or NULL if there are. */
const char *diagnose_no_variation(const struct pk_run *run);
/* Returns whether the equations have a kink on the straight line between two positions, with all
 * rates 0. A kink is where a switch is 0 or changes sign. If the equations have kinks but no
 * switches, the kinks cannot be located, and the result is 1. */
int diagnose_kink(struct pk_run *run, const pk_real *from, const pk_real *to);
/* Each of these functions writes the diagnostic of its name. */
#define DIAGNOSE_DECLARE(name, of, kernels) void diagnose_##name(struct diagnostics *d);
DIAGNOSTICS(DIAGNOSE_DECLARE)

#endif
