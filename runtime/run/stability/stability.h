/* State and functions shared by the files that answer the questions of pk/stability.h. */
#ifndef RUN_STABILITY_H
#define RUN_STABILITY_H

#include <pk/diagnostics.h>
#include <pk/stability.h>

#include "../observers/condition.h"
#include "../base/state.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#include <pk/gsl_orbits.h>
#endif

struct pk_mode;

/* Numbers kept of each state of the motion; see stability_energies(). */
struct record {
    double t, energy, vp, size;
};

/* Unknowns of closed orbits: indices in (q, v); `turns`: it is an angle, compared modulo 2 pi. */
struct unknowns {
    size_t count, *of;
    unsigned char *turns;
};

/* Measurements along a motion besides its energy. */
struct watched {
    double *share;             /* n: largest |v_i p_i| of each coordinate, its part of v.p */
    double most;               /* the largest share */
    double *swift;             /* n: largest |v_i| */
    struct pk_monitor monitor; /* of constants of the motion; its memory is `block` */
    void *block;
    size_t at;   /* last record of the reference motion before the current time */
    double lost; /* when it was first apart from the reference motion; infinite: never */
    /* Results of stability_judge() for a method's motion (watch.c). */
    double exchange, moved, follows;
    const char *constant; /* name of the constant that moved most, or NULL */
};

struct pk_stability {
    struct pk_run *run; /* holds settings, problem, memory and messages; it is not integrated */
    const struct settings *settings;
    struct pk_problem problem;
    size_t n, coordinates; /* unknowns; the first `coordinates` are q, the others first-order */
    struct json out;       /* writer of `answer` */
    char *answer;          /* of malloc() */
    const char *what;      /* the current question */
    const struct pk_stability_question *question;
    double until; /* CPU time at which integrations end, seconds */
    int good;     /* whether there is an answer */
    double *work; /* 4 n + 1: q, v, p, pdot */
    /* Modes of the start as an equilibrium, computed at the first use. */
    int has_modes;
    size_t n_modes;
    struct pk_mode *modes; /* 2 n */
    double *shapes;        /* 2 n by 2 n: n real parts, n imaginary parts of each mode */
    /* The reference motion, from dop853. */
    int known, leaves;
    struct pk_integrator *exact; /* its integrator */
    enum pk_status motion;       /* status of `exact` */
    struct looking *looking;     /* condition numbers along it */
    struct record *records;      /* one per step */
    size_t n_records, room;
    unsigned char *idle; /* n: cyclic, or a first-order variable that no rate depends on */
    int by_norm;         /* first-order variables matter: judged by distance, not by energy */
    /* Region of the motion in q and v; NULL until stability_cover(). */
    double *middle, *box; /* 2 n each: centre, width; the width of a constant is its magnitude */
    double *reach;        /* n: largest stability_apart() of each unknown */
    struct unknowns unknowns; /* of closed orbits, set at the first use */
    /* n_states states (q, v) at the first records; time up to which a looser tolerance agrees. */
    double *states, horizon;
    size_t n_states, states_room;
    struct watched watched; /* measurements of the reference motion */
    double *far; /* 3 n: largest |q - q0| up to a half, three quarters and the end of `until` */
};

/* The reference motion over the duration of a point, which is a method's run at one step size. */
struct reference {
    double scale;     /* range of v.p: twice the kinetic energy that comes and goes */
    double size;      /* largest |v.p| + |L|: what round-off of the energy is relative to */
    double low, high; /* energies in the last quarter; the first one where energy is constant */
    double top;       /* largest energy; the first one where energy is constant */
    int judges;       /* it lasts to the end and does not leave, so methods are judged by it */
};

/* Returns whether no equation depends on q_i or the first-order variable i. */
static inline int stability_idle(const struct pk_stability *s, size_t i) { return s->idle[i]; }

/* Returns the distance of q_i, or of the first-order variable i, from the start. */
static inline double stability_apart(const struct pk_stability *s, const double *q, const double *v,
                                     size_t i)
{
    return i < s->coordinates ? q[i] - s->settings->q[i] : v[i] - s->settings->v[i];
}

/* Computes the quantities by which a motion is judged: energy, v.p (its range is the scale), and
 * |v.p| + |L| (the size of round-off). With by_norm, all three are half the squared distance from
 * the start in units of reach; 0 before stability_cover(). */
void stability_energies(struct pk_stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size);
/* Returns an integrator with memory of its own, or NULL with the status of its failure. */
struct pk_integrator *stability_begin(struct pk_stability *s, const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status);
void stability_end(struct pk_stability *s, struct pk_integrator *it);
/* Returns an integrator of the reference motion: dop853 at rtol `looser` times 1e-10. */
struct pk_integrator *stability_motion_begun(struct pk_stability *s, double looser,
                                             enum pk_status *status);

/* Sets middle, box, reach; the first call follows the motion to `until`. */
void stability_cover(struct pk_stability *s);

/* Measures a method's motion, or the reference motion. For each state stability_energies() comes
 * first, since it leaves p in s->work. */
void stability_watch_begin(struct pk_stability *s, struct watched *w);
void stability_watch_end(struct pk_stability *s, struct watched *w);
void stability_watch(struct pk_stability *s, struct watched *w, double t, const double *q,
                     const double *v);
/* Compares a state with the reference motion, and sets w->lost when they are first apart. */
void stability_compare(const struct pk_stability *s, struct watched *w, double t, const double *q,
                       const double *v);
/* Stores the state of the last record, while there is room. */
void stability_keep(struct pk_stability *s, const double *q, const double *v);
/* Computes exchange, moved and follows of a method's motion. */
void stability_judge(struct pk_stability *s, struct watched *w);

/* Follows the reference motion to `until` if it has not come so far, and returns its summary. */
struct reference stability_reference(struct pk_stability *s, double until);

/* Writes the answer to a question. Returns 1, or 0 with a message. */
typedef int stability_answer(struct pk_stability *s, const struct pk_stability_question *q);
stability_answer stability_ready, stability_motion, stability_point, stability_oscillator,
    stability_equilibria, stability_near, stability_leave, stability_fastest, stability_orbits,
    stability_returns, stability_neighbour, stability_place, stability_resolved;
/* Adds a message; returns 0. */
int stability_wrong(struct pk_stability *s, const char *message);
/* Returns the method of that name if it has a fixed step; else NULL, with a message. */
const struct pk_method *stability_method(struct pk_stability *s, const char *name);

#endif
