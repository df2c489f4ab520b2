/* What `pkgen stability` needs of a model besides a run: steps of any method from any state,
 * equilibria, and the methods. Python judges the numbers (analysis/stability). A state is q, then v:
 * 2 n numbers; places in q of first-order variables are 0.
 */
#ifndef PK_STABILITY_H
#define PK_STABILITY_H

#include <pk/run.h>

PK_BEGIN

/* An integration of the model of a run; the run must outlive it. */
struct pk_stability;

/* What to watch along the steps, for pk_stability_report(). */
enum {
    PK_WATCH_CONSTANTS = 1, /* drifts of cyclic momenta and of `conserve` */
    PK_WATCH_CONDITION = 2  /* condition numbers, and the constants at the start too */
};

/* Begins at t = 0. `h`: the fixed step; 0 for an adaptive method, with `rtol` and `atol` (< 0: from
 * the motion). rtol 0: the tolerances of the run. Returns NULL with *status on failure;
 * PK_BAD_ARGUMENT: there is no such method with fixed steps, or without. */
struct pk_stability *pk_stability_begin(struct pk_run *run, const char *method, double h,
                                        double rtol, double atol, unsigned watch,
                                        const double *state, int *status);
/* Makes up to `count` steps, none beyond `until`. Writes t and the state after each of them to
 * `out`, or after the last alone (`every` 0). Returns their number. */
size_t pk_stability_steps(struct pk_stability *of, double until, size_t count, int every,
                          double *out, int *status);
/* Begins again from a state at t; `h` > 0: with this step. Returns the status. */
int pk_stability_restart(struct pk_stability *of, double t, double h, const double *state);
/* Maps `count` states by `steps` steps of h from t = 0, by an adaptive method over steps h. The
 * numbers of a state that fails are NaN. */
void pk_stability_map(struct pk_stability *of, double h, size_t steps, size_t count,
                      const double *from, double *to);
/* Projects the state onto the constraints and normalises quaternions. Returns the status. */
int pk_stability_project(struct pk_stability *of, double *state);
/* Returns what was watched, in JSON, the condition number `cond` of the last step's equations, and
 * whether the method is `symmetric` or symplectic; valid until the next call. */
const char *pk_stability_report(struct pk_stability *of);
void pk_stability_end(struct pk_stability *of);

/* Returns the equilibria found from `tries` starts in JSON, each with Newton's last correction
 * `doubt`; valid until the next call for this run. Without GSL the function is missing. */
const char *pk_stability_equilibria(struct pk_run *run, size_t tries);
/* Makes a step of h on q'' = -stiffness q - damping q'; `map` is its matrix of (q, v), 2 by 2.
 * Returns the status; PK_BAD_ARGUMENT: there is no such method of fixed steps. */
int pk_stability_spring(const struct pk_run_model *model, const char *method, double stiffness,
                        double damping, double h, double *map);
/* Returns the methods of a model (`own`: only its own), or of the runtime, in JSON: traits, needs,
 * and where their steps grow on linear equations. Valid until the next call. */
const char *pk_stability_methods(const struct pk_run_model *model, int own);

PK_END

#endif
