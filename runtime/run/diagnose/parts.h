/* What the files of --diagnose share. */
#ifndef RUN_DIAGNOSE_PARTS_H
#define RUN_DIAGNOSE_PARTS_H

#include "../base/json.h"
#include "../look/drifts.h"
#include "diagnose.h"

struct diagnostics {
    pk_real *rows; /* t, q, v of each */
    size_t n_rows, capacity;
    char *json;
    FILE *file; /* of json while it is made */
    struct run *run;
    enum pk_run_code code;
    int first, all;
    double exponent; /* by Lyapunov, if that says chaotic or leaving */
};

/* What is there, ready for members. */
struct diagnostics *diagnose_open(struct run *run);
/* Opens a member, with how it went. 1 where its numbers are to follow; then it is still open. */
int diagnose_member(struct diagnostics *d, const char *name, enum pk_status status,
                    const char *reason);
void diagnose_real(struct diagnostics *d, const char *key, pk_real x);

/* Why (q, p) are not coordinates and their momenta, free of each other; or NULL. */
const char *diagnose_not_free(const struct pk_system *system);
/* Why there are no variational equations, or NULL. */
const char *diagnose_no_variation(const struct pk_system *system);
/* Whether the equations have a kink on the straight way from one place to another, at rest: a
 * switch that is 0 or changes its side. Of kinks without switches nobody knows where they are: 1.
 */
int diagnose_kink(struct run *run, const pk_real *from, const pk_real *to);
/* Each writes its member. */
#define DIAGNOSE_DECLARE(name, of, kernels) \
    void diagnose_##name(struct run *run, struct diagnostics *d);
DIAGNOSTICS(DIAGNOSE_DECLARE)

#endif
