/* What the files of pk/stability.h share. */
#ifndef RUN_STABILITY_H
#define RUN_STABILITY_H

#include <pk/diagnostics.h>
#include <pk/stability.h>

#include "../look/condition.h"
#include "../base/state.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#include <pk/gsl_orbits.h>
#endif

struct pk_mode;

/* What is kept of a state of the motion. */
struct record {
    double t, energy, vp, size;
};

/* Numbers of those of q and v that a closed orbit is sought in; an angle goes the shorter way. */
struct unknowns {
    size_t count, *of;
    unsigned char *turns;
};

/* What is watched of a motion besides its energy. */
struct watched {
    double *share;             /* n: of each coordinate the largest |v_i p_i|, its part of v.p */
    double most;               /* the largest of these */
    double *swift;             /* n: the largest |v_i| */
    struct pk_monitor monitor; /* of its constants; in block */
    void *block;
    size_t at;   /* record of the motion before it */
    double lost; /* when it was first apart from the motion; infinite: never */
    /* Of a method's, once judged (watch.c). */
    double exchange, moved, follows;
    const char *constant; /* which moved; or NULL */
};

struct pk_stability {
    struct pk_run *run; /* not integrated: its settings, problem, memory and messages */
    const struct settings *settings;
    struct pk_problem problem;
    size_t n, coordinates; /* of the n, before the integrals of first-order variables */
    struct json out;       /* of the answer, which is in */
    char *answer;          /* of malloc() */
    const char *what;      /* is asked */
    const struct pk_stability_question *question;
    double until; /* seconds of the processor's at which integrations end */
    int good;     /* whether there is an answer */
    double *work; /* 4 n + 1: a start, p, pdot */
    /* Of the start as an equilibrium, once they are asked for. */
    int has_modes;
    size_t n_modes;
    struct pk_mode *modes; /* 2 n */
    double *shapes;        /* 2 n 2 n: real parts, imaginary parts */
    /* Of the motion, once it is known. */
    int known, leaves;
    struct pk_integrator *exact; /* follows it */
    enum pk_status motion;       /* of that */
    struct looking *looking;     /* at how singular its equations are */
    struct record *records;      /* of its steps */
    size_t n_records, room;
    unsigned char *idle; /* n: cyclic, or a first-order variable that no rate depends on */
    int by_norm;         /* there are first-order variables that count: the energy does not tell */
    /* What the motion covers, of q and v; NULL: not known yet (stability_cover()). */
    double *middle, *box; /* 2 n each; the box of what does not move is as far as that is from 0 */
    double *reach;        /* n: how far each of stability_apart() goes */
    struct unknowns unknowns; /* of closed orbits, once they are asked for */
    /* The states at the first records, n_states of q, v; how far a looser tolerance agrees. */
    double *states, horizon;
    size_t n_states, states_room;
    struct watched watched; /* of the motion itself */
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

/* Nothing depends on it. */
static inline int stability_idle(const struct pk_stability *s, size_t i) { return s->idle[i]; }

/* How far q_i, or the first-order variable i, is from the start. */
static inline double stability_apart(const struct pk_stability *s, const double *q, const double *v,
                                     size_t i)
{
    return i < s->coordinates ? q[i] - s->settings->q[i] : v[i] - s->settings->v[i];
}

/* What a motion is judged by, its range and the size that round-off of it is relative to: energy,
 * v.p and |v.p| + |L|; by_norm the half square of the distance from the start, in reaches (before
 * stability_cover() 0). */
void stability_energies(struct pk_stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size);
/* An integrator with memory of its own, or NULL with the status of what refused. */
struct pk_integrator *stability_begin(struct pk_stability *s, const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status);
void stability_end(struct pk_stability *s, struct pk_integrator *it);
/* That of the motion itself; by a tolerance that is so many times looser. */
struct pk_integrator *stability_motion_begun(struct pk_stability *s, double looser,
                                             enum pk_status *status);

/* Follows the motion to `until`, the first time it is called: middle, box, reach. */
void stability_cover(struct pk_stability *s);

/* Of a method's motion, or of the motion itself. A state's energies are asked for before. */
void stability_watch_begin(struct pk_stability *s, struct watched *w);
void stability_watch_end(struct pk_stability *s, struct watched *w);
void stability_watch(struct pk_stability *s, struct watched *w, double t, const double *q,
                     const double *v);
/* Beside the motion, which is known. */
void stability_compare(const struct pk_stability *s, struct watched *w, double t, const double *q,
                       const double *v);
/* The state of the last record. */
void stability_keep(struct pk_stability *s, const double *q, const double *v);
/* What a method's came to, beside the motion over as long. */
void stability_judge(struct pk_stability *s, struct watched *w);

/* After the motion is known: follows it to `until`, if it has not been yet. */
struct reference stability_reference(struct pk_stability *s, double until);

/* 1, or 0 with a message. */
typedef int stability_answer(struct pk_stability *s, const struct pk_stability_question *q);
stability_answer stability_ready, stability_motion, stability_point, stability_oscillator,
    stability_equilibria, stability_near, stability_leave, stability_fastest, stability_orbits,
    stability_returns, stability_beside, stability_place, stability_resolved;
/* A message; 0. */
int stability_wrong(struct pk_stability *s, const char *message);
/* Of that name, and of a fixed step; NULL with a message. */
const struct pk_method *stability_method(struct pk_stability *s, const char *name);

#endif
