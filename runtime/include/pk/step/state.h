/* Shared by all methods, in the library and where a step is compiled together with a model's
 * kernels: the private part of an integrator, tolerances, trial steps, inputs, failures. Not for
 * programs that only integrate. */
#ifndef PK_STEP_STATE_H
#define PK_STEP_STATE_H

#include <pk/integrator.h>
#include <pk/step/ahead.h>

/* Defined if fma() is an instruction with the same results on all processors. */
#if (defined __FP_FAST_FMA || defined __FMA__ || defined __ARM_FEATURE_FMA) && \
    !defined PK_LONG_DOUBLE && !defined PK_FLOAT128 && !defined PK_PORTABLE
#define PK_HAVE_FMA
#endif

/* The times of fixed steps, which form a grid: t = anchor + count * h, without a running sum. */
struct pk_grid {
    pk_real anchor, count;
    /* 1: the current step is shorter than h, so its end becomes the anchor of a new grid */
    int off;
};

/* Progress of the integration, for the checks in src/integrate/grid.c. */
struct pk_progress {
    pk_real passed; /* sum of the lengths of all steps since init */
    /* values at the last check of progress: of `passed` and of t, and, in the next line, of the
     * numbers of trial steps and of rejections */
    pk_real judged_passed, judged_t;
    unsigned long judged, judged_rejections;
    pk_real longest;                  /* longest rejected step */
    unsigned long rounded_rejections; /* number of rejections when rounding was last measured */
    pk_real rounded_step; /* step size when rounding was last measured; see src/core/rounding.c */
};

/* Flags of src/constraints/singular_crossing.c. crossed: the last step crossed a singular position;
 * near: the state is near a singular position; seen: the bits PK_SEEN, PK_SEEN_LOW, PK_SEEN_DIPS
 * for the end of the step. */
struct pk_passing {
    int crossed, near, seen;
};

/* State of src/core/short_force_limiter.c. */
struct pk_short_force {
    /* known: flag: the values of the marks at the start of the step are known; unlooked: number
     * of coming steps that are not checked */
    int known, unlooked;
    /* reach: largest length of the next step (0: no limit); rise: that of the step after it */
    pk_real reach, rise;
    pk_real calm; /* length of the last step in which the marks hardly changed */
    /* range: largest change of a mark in the trial step; varied: that while the force varies */
    pk_real range, varied;
};

/* The failure of the last trial step that failed. If the step size then underflows just before
 * reason.time, this failure is reported as the cause. status = PK_DONE: no trial step failed. */
struct pk_trouble {
    enum pk_status status;
    struct pk_reason reason;
};

/* The private part of an integrator, it->own; only for methods and the runtime. */
struct pk_integrator_private {
    /* Pointers, which a saved integrator (pk/keep.h) does not contain. They end before `slopes`. */
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit); /* step function */
    pk_real *state, *next;  /* two states, with the parts listed in pk/step/numbers.h */
    pk_real *u, *work;      /* u: inputs at one time, then inputs for each lane */
    pk_real *atol;          /* absolute tolerances of q, then v (core/scale.c); NULL: fixed steps */
    pk_real *lane;          /* one state and its acceleration, for a system without lane kernels */
    pk_real *singularities; /* work of src/core/singularity.c; NULL: no singularities */
    pk_real *project;       /* work of src/constraints/project.c, or NULL */
    pk_real *crossing;      /* work of src/constraints/singular_crossing.c; NULL: no constraints */
    pk_real *marks;         /* work of short_force_limiter.c; NULL: no marks */
    pk_real *params;        /* memory for a copy of the params */
    struct pk_ahead *ahead; /* a step computed in advance in a SIMD lane, or NULL */
    void *extra;            /* memory of a foreign library */
    size_t n_singularities; /* number of monitored values (pk_system_singularity_count()) */

    int slopes;     /* flags of singularity.c (KNOWN, QUIET) */
    int ready;      /* 1: init or reset accepted a start, so that steps can be made */
    int made;       /* 1: the method has computed its tables, which it does only once */
    int direction;  /* direction of time, +1 or -1; 0 before the first step */
    int flags;      /* bits such as PK_HAVE_A */
    pk_real next_t; /* end of the current step */
    pk_real h;      /* signed size of the last or the next step */
    pk_real error;  /* error of the last accepted adaptive step relative to the tolerance */
    struct pk_grid grid;
    struct pk_progress progress;
    struct pk_passing passing;
    struct pk_short_force short_force;
    struct pk_trouble trouble;
};

/* bits of it->own->flags */
enum { PK_HAVE_A = 1, PK_HAVE_LU = 2, PK_HAVE_STEP = 4, PK_HAVE_DENSE = 8, PK_REFRESH = 16 };

/* Return a part (such as PK_Q) of the state, and of the new state. */
static inline pk_real *pk_state(const struct pk_integrator *it, int part)
{
    return pk_part(it->own->state, it->n_q, it->n, part);
}
static inline pk_real *pk_next(const struct pk_integrator *it, int part)
{
    return pk_part(it->own->next, it->n_q, it->n, part);
}

/* Returns the sign of the steps. */
static inline pk_real pk_direction(const struct pk_integrator *it)
{
    return (pk_real)it->own->direction;
}

/* Returns the tolerance of number i of (q, v), with values a before and b after the step. */
static inline pk_real pk_tolerance(const struct pk_integrator *it, size_t i, pk_real a, pk_real b)
{
    return it->own->atol[i] + it->options.rtol * pk_max(pk_abs(a), pk_abs(b)) + PK_TINY;
}

/* Returns a tolerance for the choice of the first step size: infinity instead of the tolerance of a
 * number that has been zero so far. */
static inline pk_real pk_scale_known(pk_real tolerance)
{
    return tolerance > PK_C(1e6) * PK_F(sqrt)(PK_TINY) ? tolerance : PK_INFINITY;
}

PK_BEGIN
/* Updates it->own->atol for a trial step of length h: the rounding of forces grows with h. */
void pk_scale_attempt(const struct pk_integrator *it, pk_real h);
PK_END

/* Returns whether the current step, of length h, was computed in a lane; the caller must use it. */
static inline int pk_is_ahead(const struct pk_integrator *it, pk_real h)
{
    return pk_ahead_serves(it->own->ahead, it->t, h, it->own->next_t);
}

/* Returns whether a trial was rejected and the next trial will be computed in a lane. */
static inline int pk_waits(const struct pk_integrator *it)
{
    return it->own->ahead && it->own->ahead->waits;
}

/* Returns the first trial step, or the next one if a trial step made in a lane was rejected. */
static inline struct pk_trial pk_trial(const struct pk_integrator *it, pk_real limit)
{
    if (pk_waits(it))
        return it->own->ahead->trial;
    const pk_real round = 10 * PK_EPS * pk_abs(it->t) + PK_TINY;
    struct pk_trial x = {0, 0, 0, 0, 0, 0, 0};
    x.sign = pk_direction(it);
    x.left = pk_abs(limit - it->t);
    x.least = pk_max(it->options.h_min, round);
    x.planned = pk_abs(it->own->h);
    return x;
}

/* Prepares the next trial step and sets its end, it->own->next_t. Returns 0 if the step would be
 * too short, no matter whether rejections shortened it or factors below 1 after accepted steps. */
static inline int pk_trial_next(struct pk_integrator *it, pk_real limit, struct pk_trial *x)
{
    if (it->options.h_max > 0)
        x->planned = pk_min(x->planned, it->options.h_max);
    if (!(x->planned > x->least) && (x->left > x->least || x->rejected))
        return 0;
    x->lands = x->planned * PK_C(1.01) >= x->left || !(x->left > x->least);
    it->own->next_t = x->lands ? limit : it->t + x->sign * x->planned;
    /* the difference of the rounded times, so that q and t stay consistent */
    x->h = it->own->next_t - it->t;
    pk_scale_attempt(it, x->h);
    return 1;
}

/* Rejects a trial step; the next trial step has size `planned`. */
static inline void pk_trial_reject(struct pk_integrator *it, struct pk_trial *x, pk_real planned)
{
    x->planned = planned;
    x->rejected = 1;
    it->own->progress.longest = pk_max(it->own->progress.longest, pk_abs(x->h));
    it->count.rejections++;
    it->own->h = x->sign * planned;
}

/* Returns whether the next trial step, after a rejection, will be computed in a lane; if so, this
 * call of step() ends without a result. */
static inline int pk_waits_for(struct pk_integrator *it, const struct pk_trial *x)
{
    struct pk_ahead *a = it->own->ahead;
    a->taken = 0;
    a->waits = a->again;
    a->trial = *x;
    return a->waits;
}

/* Accepts a trial step; next: the next step size. If the limit shortened this step and `cut` is
 * set, the next step has at least its planned size. If the step was shorter than the round-off of
 * t, the next step size is guessed as for a first step. */
static inline void pk_trial_accept(struct pk_integrator *it, const struct pk_trial *x, pk_real next,
                                   int cut)
{
    const pk_real h = x->lands && !x->rejected && cut ? pk_max(next, x->planned) : next;
    it->own->h = x->planned > x->least || x->left > x->least ? x->sign * h : 0;
}

/* Records the failure of a trial step up to t. */
static inline void pk_trouble(struct pk_integrator *it, enum pk_status status, pk_real t)
{
    it->own->trouble.status = status;
    it->own->trouble.reason = it->reason;
    it->own->trouble.reason.time = t;
}

PK_BEGIN

/* pk_ahead_take() copies `parts` parts of the new state from a lane, pk_ahead_slopes() slopes. */
void pk_ahead_take(struct pk_integrator *it, int part, int parts);
void pk_ahead_slopes(struct pk_integrator *it, pk_real *to, int stages);
int pk_all_finite(const pk_real *x, size_t count);
/* pk_input() writes the inputs at t to u, pk_eval_input() to it->own->u. Without a function they
 * are 0. */
void pk_input(const struct pk_problem *problem, pk_real t, pk_real *u);
const pk_real *pk_eval_input(struct pk_integrator *it, pk_real t);
/* pk_feedback() writes the inputs at the state (t, q, v) to u, pk_eval_feedback() to it->own->u.
 * Both call the function `feedback` of the problem; or pk_input() and pk_eval_input(). */
void pk_feedback(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                 pk_real *u);
const pk_real *pk_eval_feedback(struct pk_integrator *it, pk_real t, const pk_real *q,
                                const pk_real *v);
/* Returns the status of an acceleration that returned `failed`, and sets it->reason. */
enum pk_status pk_eval_failed(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, int failed);
/* Calls system->lanes(), or acceleration() for each lane if the system has no kernel `lanes`. */
unsigned long long pk_eval_lanes(struct pk_integrator *it, const pk_real *t, const pk_real *q,
                                 const pk_real *v, const pk_real *u, pk_real *a);
/* Returns the first step size: options.h, or `share` times |y|/|y'| with y' = (v, a), HNW II.4
 * (4.14); at most the distance to the limit. */
pk_real pk_first_step(const struct pk_integrator *it, const pk_real *a, pk_real share,
                      pk_real limit);
/* Returns the status for a step size h that became too small; sets the cause if it is known. */
enum pk_status pk_underflow(struct pk_integrator *it, pk_real h);

PK_END

#endif
