/* What every step is made of, in the core and where pkgen compiles a step together with a model's
 * kernels: round-off, the layout of a state, the compensated sum, failures by their names.
 * Not for programs that only integrate.
 */
#ifndef PK_STEP_STATE_H
#define PK_STEP_STATE_H

#include <pk/integrator.h>
#include <pk/step/ahead.h>

/* Whether fma() is an instruction, and as good everywhere. */
#if (defined __FP_FAST_FMA || defined __FMA__ || defined __ARM_FEATURE_FMA) && \
    !defined PK_LONG_DOUBLE && !defined PK_FLOAT128 && !defined PK_PORTABLE
#define PK_HAVE_FMA
#endif

/* What is behind it->own, for methods and the runtime alone. */
struct pk_integrator_private {
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit); /* method's or system's */
    pk_real *state, *next; /* each the parts of pk/step/numbers.h */
    pk_real *u, *work;     /* u: inputs at one time, and behind them those of each lane */
    pk_real *atol; /* absolute tolerances of q, then v; NULL: fixed steps; src/core/scale.c */
    unsigned long rounded;  /* rejections when rounding was last looked at */
    pk_real looked;         /* the length of the steps then */
    pk_real *singularities; /* NULL: the system has none; see src/core/singularity.c */
    size_t n_singularities; /* their values: of families one a member */
    int slopes;             /* of the singularities: what is known of them at this state */
    pk_real *lane;          /* one state and its acceleration, of a system without lane kernels */
    pk_real passed;         /* the lengths of all steps since init; when steps were last judged */
    pk_real judged_passed;  /* by their progress: that, their number with those rejected, and t */
    pk_real judged_t;
    unsigned long judged, judged_rejections;
    pk_real longest;         /* of the steps that were rejected */
    pk_real next_t;          /* end of the step being made */
    pk_real h;               /* signed step, made or to be made */
    pk_real anchor, grid;    /* fixed steps: t = anchor + grid * h, never a running sum */
    pk_real error;           /* adaptive: of the last accepted step, in units of the tolerance */
    int off_grid;            /* fixed steps: the one being made is shorter, and ends the grid */
    int ready;               /* a start was accepted; without it nothing steps */
    int made;                /* what the method makes once, whatever the start */
    int direction;           /* +1, -1, 0 before the first step */
    int flags;               /* the method's own */
    pk_real condition;       /* of a singular M: the least pivot beside its diagonal entry */
    pk_real *project;        /* rotations and constraints: src/constraints/project.c; NULL: none */
    pk_real *passage;        /* src/constraints/passage.c; NULL: there are no constraints */
    int crossed, near, seen; /* the last step was made by it; where the step is near one */
    pk_real *params;         /* room for a copy of them */
    pk_real *marks;          /* values at the begin, ...: src/core/marks.c; NULL: there are none */
    int marked, unlooked;    /* whether those at the begin are known; steps not looked at */
    pk_real reach, rise;     /* how long the next step may be for them, 0: any; the one behind */
    pk_real calm;            /* so long a step was made in which they hardly vary */
    pk_real range, varied;   /* by how much they vary in the trial step, and where they matter */
    enum pk_status trouble;  /* what the last trial step that broke down met, when, and its */
    pk_real trouble_t;       /* where and condition: the cause to name if steps then shrink to */
    size_t trouble_where;    /* nothing just before it */
    pk_real trouble_condition;
    struct pk_ahead *ahead; /* NULL: nobody makes steps ahead */
    void *extra;            /* of a foreign library */
};

/* it->own->flags */
enum { PK_HAVE_A = 1, PK_HAVE_LU = 2, PK_HAVE_STEP = 4, PK_HAVE_DENSE = 8, PK_REFRESH = 16 };

/* A part of the state, and of what the step at hand makes of it. */
static inline pk_real *pk_state(const struct pk_integrator *it, int part)
{
    return pk_part(it->own->state, it->n_q, it->n, part);
}
static inline pk_real *pk_next(const struct pk_integrator *it, int part)
{
    return pk_part(it->own->next, it->n_q, it->n, part);
}

/* What number i of q and v in a row, which goes from a to b, may err by. */
static inline pk_real pk_tolerance(const struct pk_integrator *it, size_t i, pk_real a, pk_real b)
{
    return it->own->atol[i] + it->options.rtol * pk_max(pk_abs(a), pk_abs(b)) + PK_TINY;
}

/* For a guess of the first step, which is no longer for it: what is zero and has shown no scale. */
static inline pk_real pk_scale_shown(pk_real tolerance)
{
    return tolerance > PK_C(1e6) * PK_F(sqrt)(PK_TINY) ? tolerance : PK_INFINITY;
}

PK_BEGIN
/* it->own->atol for a step of length h: rounding of forces counts over the step that is tried. */
void pk_scale_attempt(const struct pk_integrator *it, pk_real h);
PK_END

/* Whether the step at hand, of the length h, was made ahead; then it is to be taken. */
static inline int pk_is_ahead(const struct pk_integrator *it, pk_real h)
{
    return pk_ahead_serves(it->own->ahead, it->t, h, it->own->next_t);
}

/* Whether a trial was rejected and the next one is to be made ahead: it goes on with that. */
static inline int pk_waits(const struct pk_integrator *it)
{
    return it->own->ahead && it->own->ahead->waits;
}

/* The first, or the next one of those that wait. */
static inline struct pk_trial pk_trial(const struct pk_integrator *it, pk_real limit)
{
    if (pk_waits(it))
        return it->own->ahead->trial;
    const pk_real round = PK_C(10.0) * PK_EPS * pk_abs(it->t) + PK_TINY;
    struct pk_trial x = {0, 0, 0, 0, 0, 0, 0};
    x.sign = (pk_real)it->own->direction;
    x.left = pk_abs(limit - it->t);
    x.least = pk_max(it->options.h_min, round);
    x.planned = pk_abs(it->own->h);
    return x;
}

/* The next one, to it->own->next_t; 0: it would be too short, also where a step shrank while it was
 * accepted. */
static inline int pk_trial_next(struct pk_integrator *it, pk_real limit, struct pk_trial *x)
{
    if (it->options.h_max > 0)
        x->planned = pk_min(x->planned, it->options.h_max);
    if (!(x->planned > x->least) && (x->left > x->least || x->rejected))
        return 0;
    x->lands = x->planned * PK_C(1.01) >= x->left || !(x->left > x->least);
    it->own->next_t = x->lands ? limit : it->t + x->sign * x->planned;
    x->h = it->own->next_t - it->t; /* what rounded times are apart: no drift between q and t */
    pk_scale_attempt(it, x->h);
    return 1;
}

/* A shorter one is to follow. */
static inline void pk_trial_reject(struct pk_integrator *it, struct pk_trial *x, pk_real planned)
{
    x->planned = planned;
    x->rejected = 1;
    it->own->longest = pk_max(it->own->longest, pk_abs(x->h));
    it->count.rejections++;
    it->own->h = x->sign * planned;
}

/* Whether the next one is to be made ahead as this was; then nothing was done so far. */
static inline int pk_waits_for(struct pk_integrator *it, const struct pk_trial *x)
{
    struct pk_ahead *a = it->own->ahead;
    a->taken = 0;
    a->waits = a->again;
    a->trial = *x;
    return a->waits;
}

/* It is accepted, and the next one is to be so long; `cut`: but for what was left, longer. After a
 * step below round-off the next is guessed like a first one. */
static inline void pk_trial_accept(struct pk_integrator *it, const struct pk_trial *x, pk_real next,
                                   int cut)
{
    const pk_real h = x->lands && !x->rejected && cut ? pk_max(next, x->planned) : next;
    it->own->h = x->planned > x->least || x->left > x->least ? x->sign * h : 0;
}

/* A trial step up to t broke down. */
static inline void pk_trouble(struct pk_integrator *it, enum pk_status status, pk_real t)
{
    it->own->trouble = status;
    it->own->trouble_t = t;
    it->own->trouble_where = it->where;
    it->own->trouble_condition = it->own->condition;
}

PK_BEGIN

/* So many parts of the new state from a lane, and the slopes of so many stages. */
void pk_ahead_take(struct pk_integrator *it, int part, int parts);
void pk_ahead_slopes(struct pk_integrator *it, pk_real *to, int stages);
int pk_all_finite(const pk_real *x, size_t count);
/* The inputs at t, into u, which is 0 where nobody fills it; and into it->own->u. */
void pk_input(const struct pk_problem *problem, pk_real t, pk_real *u);
const pk_real *pk_eval_input(struct pk_integrator *it, pk_real t);
/* The same at a state. */
void pk_feedback(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                 pk_real *u);
const pk_real *pk_eval_feedback(struct pk_integrator *it, pk_real t, const pk_real *q,
                                const pk_real *v);
/* The status of an acceleration that returned `failed`, with the coordinate and the time. */
enum pk_status pk_eval_failed(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, int failed);
/* system->lanes(), or lane by lane where the system has none. */
unsigned long long pk_eval_lanes(struct pk_integrator *it, const pk_real *t, const pk_real *q,
                                 const pk_real *v, const pk_real *u, pk_real *a);
/* A first step, `share` of |y|/|y'| with y' = (v, a), HNW II.4 (4.14), or the one asked for; no longer
 * than to the limit. */
pk_real pk_first_step(const struct pk_integrator *it, const pk_real *a, pk_real share,
                      pk_real limit);
/* The status of an adaptive method whose step h became too small, with its cause if known. */
enum pk_status pk_underflow(struct pk_integrator *it, pk_real h);

PK_END

#endif
