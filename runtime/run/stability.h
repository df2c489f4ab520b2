/* A row of a map of `pkgen stability`: one set of parameters, one start, many methods and steps.
 *
 * Settings come on standard input as for a run (their method counts for nothing, their `until` is
 * the duration); what is asked, a line each, stands in a file, and each line is answered by one of
 * JSON:
 *
 *     equilibria TRIES               where the system can rest, and its modes there
 *     motion                         the motion itself, by dop853 at rtol 1e-10
 *     point METHOD H                 what becomes of that motion (after `motion`)
 *     near METHOD H E K AMPLITUDE STEPS [OTHER SEED]
 *                                    from close to equilibrium E, along mode K or `all`
 *     leave E K AMPLITUDE            how fast mode K leaves equilibrium E, by dop853 at rtol 1e-13
 *     oscillator METHOD K D Y        its step's map of (q, v) for q'' = -K q - D q', h = Y
 *
 * E and K count from 0, as `equilibria` gave them.
 */
#ifndef RUN_STABILITY_H
#define RUN_STABILITY_H

#include "settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#endif

enum { MOST_EQUILIBRIA = 32 };

struct pk_mode;

struct stability {
    struct settings settings;
    struct pk_problem problem;
    size_t n;
    double *q, *v;          /* MOST_EQUILIBRIA n: equilibria, once they are asked for */
    size_t equilibria;
    size_t *counts;         /* of modes at each */
    struct pk_mode *modes;  /* 2 n an equilibrium */
    double *shapes;         /* 2 n 2 n an equilibrium: real parts, imaginary parts */
    double *work;           /* 4 n + 1: a start, p, pdot */
    /* Of the motion, once it is known. */
    int known;
    double first;        /* energy at the start */
    double scale;        /* range of v.p over it: twice the kinetic energy that comes and goes */
    double size;         /* largest |v.p| + |L|: what round-off of the energy is relative to */
    double low, high;    /* energies in its last quarter; the first one where energy is constant */
    double top;          /* largest energy */
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

/* What is asked; words[0] is its name. 0, or 2 with a message. */
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
