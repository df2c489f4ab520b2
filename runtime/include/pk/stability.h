/* Functions of a model for `pkgen stability`, besides a run: steps of any method from any state,
 * equilibria, and the methods. Python evaluates the numbers (analysis/stability). A state is 2 n
 * numbers, q and then v; q of first-order variables is 0. */
#ifndef PK_STABILITY_H
#define PK_STABILITY_H

#include <pk/run.h>

PK_BEGIN

/* An integration of the model of a run; the run must remain in memory. */
struct pk_stability;

/* Bits of `watch`: quantities that are computed at each step, for pk_stability_report(). */
enum {
    PK_WATCH_CONSTANTS = 1, /* drifts of cyclic momenta and of `conserve` quantities */
    PK_WATCH_CONDITION = 2  /* condition numbers; the start is then checked too */
};

/* Begins an integration at t = 0. h: the size of fixed steps; 0 for an adaptive method with
 * tolerances `rtol` (0: those of the run) and `atol` (< 0: derived from the motion). Returns NULL
 * with *status on failure; PK_BAD_ARGUMENT: there is no method of that name with fixed steps, or,
 * if h is 0, with adaptive steps. */
struct pk_stability *pk_stability_begin(struct pk_run *run, const char *method, double h,
                                        double rtol, double atol, unsigned watch,
                                        const double *state, int *status);
/* Makes up to `count` steps, none beyond `until`. Writes t and the state to `out` after each step,
 * or after the last step only (`every` 0). Returns the number of steps. */
size_t pk_stability_steps(struct pk_stability *of, double until, size_t count, int every,
                          double *out, int *status);
/* Restarts the integration from a state at t; h > 0: with that step size. Returns the status. */
int pk_stability_restart(struct pk_stability *of, double t, double h, const double *state);
/* Integrates each of `count` states from t = 0 and writes the states reached: by `steps` steps of
 * size h, or, with an adaptive method, over `steps` intervals of length h. If an integration fails,
 * the numbers of its state are NaN. */
void pk_stability_map(struct pk_stability *of, double h, size_t steps, size_t count,
                      const double *from, double *to);
/* Projects the state onto the constraints and normalises quaternions. Returns the status. */
int pk_stability_project(struct pk_stability *of, double *state);
/* Returns the quantities of `watch` in JSON, the condition number `cond` of the last step's
 * equations, and whether the method is `symmetric` or symplectic. Valid until the next call. */
const char *pk_stability_report(struct pk_stability *of);
void pk_stability_end(struct pk_stability *of);

/* Makes a step of size h on q'' = -stiffness q - damping q'; `map` is its 2 by 2 matrix for (q, v).
 * Returns the status; PK_BAD_ARGUMENT: there is no method of that name with fixed steps. */
int pk_stability_spring(const struct pk_run_model *model, const char *method, double stiffness,
                        double damping, double h, double *map);
/* Returns a list of methods in JSON: with `own` those that the model defines, otherwise those of
 * the runtime. It has their traits, the facts that they require, and their stability limits on
 * linear equations. The text is valid until the next call. */
const char *pk_stability_methods(const struct pk_run_model *model, int own);

PK_END

#endif
