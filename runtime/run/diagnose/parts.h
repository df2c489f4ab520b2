/* What the files of --diagnose share. */
#ifndef RUN_DIAGNOSE_PARTS_H
#define RUN_DIAGNOSE_PARTS_H

#include "../base/json.h"
#include "../look/look.h"
#include "diagnose.h"

struct diagnostics {
    pk_real *rows; /* t, q, v of each */
    size_t n_rows, room;
    char *text;       /* the object of all, */
    struct json json; /* while it is made */
    struct pk_run *run;
    const char *name; /* of the one that is made */
    enum pk_run_code code;
    int all;
    double exponent; /* by Lyapunov, if that says chaotic or leaving */
};

/* What is there, ready for members; and the object closed. */
struct diagnostics *diagnose_open(struct pk_run *run);
void diagnose_close(struct diagnostics *d);
/* A member, made by make(): its keys, status and reason first. */
void diagnose_one(struct diagnostics *d, const char *name,
                  void (*make)(struct pk_run *run, struct diagnostics *d));
/* The k-th of so many kept rows, from the first to the last. */
const pk_real *diagnose_row(const struct diagnostics *d, size_t k, size_t count);
/* How it went, with the reason, NULL: that of an integrator which was to make it, or of the status.
 * 1 where its numbers are to follow, in d->json. */
int diagnose_told(struct diagnostics *d, enum pk_status status, const char *reason,
                  const struct pk_integrator *it);
#define DIAGNOSE_NEEDS_GSL(name)                                                               \
    void diagnose_##name(struct pk_run *run, struct diagnostics *d)                            \
    {                                                                                          \
        (void)run;                                                                             \
        diagnose_told(d, PK_REFUSED, "it needs the GNU Scientific Library, which is not here", \
                      NULL);                                                                   \
    }

/* Why (q, p) are not coordinates and their momenta, free of each other; or NULL. */
const char *diagnose_not_free(const struct pk_system *system);
/* Why there are no variational equations, or NULL. */
const char *diagnose_no_variation(const struct pk_run *run);
/* Whether the equations have a kink on the straight way from one place to another, at rest: a
 * switch that is 0 or changes its side. Of kinks without switches nobody knows where they are: 1.
 */
int diagnose_kink(struct pk_run *run, const pk_real *from, const pk_real *to);
/* Each writes its member. */
#define DIAGNOSE_DECLARE(name, of, kernels) \
    void diagnose_##name(struct pk_run *run, struct diagnostics *d);
DIAGNOSTICS(DIAGNOSE_DECLARE)

#endif
