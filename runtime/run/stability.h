/* A row of a map of `pkgen stability`: one set of parameters, one start, many methods and steps.
 *
 * Settings come on standard input as for a run (their method counts for nothing, their `until` is
 * the duration); what is asked, a line each, stands in a file, and each line is answered by one of
 * JSON:
 *
 *     equilibria TRIES               where the system can rest, and its modes there
 *     start                          where and with which parameters the motion begins
 *     motion                         the motion itself, by dop853 at rtol 1e-10
 *     point METHOD H                 what becomes of that motion (after `motion`)
 *     near METHOD H K AMPLITUDE STEPS [OTHER SEED]
 *                                    from close to the start along mode K or `all`
 *     leave K AMPLITUDE              how fast mode K leaves the start, by dop853 at rtol 1e-13
 *     oscillator METHOD K D Y        what its step makes of q'' = -K q - D q', h = Y
 *
 * Of `near` and `leave` the start is an equilibrium; K counts its modes from 0, as `equilibria` gave
 * them.
 */
#ifndef RUN_STABILITY_H
#define RUN_STABILITY_H

#include "settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#endif

struct pk_mode;
struct record;

struct stability {
    struct settings settings;
    struct pk_problem problem;
    size_t n;
    double *work;          /* 4 n + 1: a start, p, pdot */
    /* Of the start as an equilibrium, once they are asked for. */
    int has_modes;
    size_t n_modes;
    struct pk_mode *modes; /* 2 n */
    double *shapes;        /* 2 n 2 n: real parts, imaginary parts */
    /* Of the motion, once it is known. */
    int known, leaves;
    struct pk_integrator *exact; /* follows it */
    enum pk_status motion;       /* of that */
    struct record *records;      /* of its steps */
    size_t n_records, room;
    double *far; /* 3 n: largest |q - q0| up to a half, three quarters and the end of `until` */
};

/* The motion over as long as a point's. */
struct reference {
    double scale;     /* range of v.p: twice the kinetic energy that comes and goes */
    double size;      /* largest |v.p| + |L|: what round-off of the energy is relative to */
    double low, high; /* energies in its last quarter; the first one where energy is constant */
    double top;       /* largest energy; the same */
    int judges;       /* it lasts, and does not leave */
};

/* Energy, v.p and |v.p| + |L| of a state. */
void stability_energies(struct stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size);
/* An integrator with memory of its own, or NULL with the status of what refused. */
struct pk_integrator *stability_begin(const struct pk_problem *problem,
                                      const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status);
void stability_end(struct pk_integrator *it);

/* After the motion is known: follows it to `until`, if it has not been yet. */
struct reference stability_reference(struct stability *s, double until);

/* What is asked; words[0] is its name. 0, or 2 with a message. */
int stability_ready(struct stability *s);
int stability_motion(struct stability *s);
int stability_point(struct stability *s, size_t line, char *const words[]);
int stability_oscillator(size_t line, char *const words[]);
#ifdef PK_WITH_GSL
int stability_equilibria(struct stability *s, size_t line, char *const words[]);
int stability_near(struct stability *s, size_t line, char *const words[]);
int stability_leave(struct stability *s, size_t line, char *const words[]);
#endif

/* The whole program in this mode; the process's exit code. */
int stability_run(const char *path);

#endif
