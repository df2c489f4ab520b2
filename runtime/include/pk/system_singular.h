/* Parts of a system (pk/system.h): where its equations end, change or are nearly constant. */
#ifndef PK_SYSTEM_SINGULAR_H
#define PK_SYSTEM_SINGULAR_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* An expression that the acceleration divides by, or takes a root or a logarithm of, or an angle that
 * jumps, and L with it. At a zero
 * there ends one of three: the coordinates, if M is singular there (the pole of a sphere); the
 * motion itself (a collision); or the expression alone, if the quotient has a limit. */
enum pk_singularity_kind {
    PK_SINGULARITY_COORDINATES,
    PK_SINGULARITY_DIVISOR,
    PK_SINGULARITY_ROOT,
    PK_SINGULARITY_LOGARITHM,
    PK_SINGULARITY_ARC, /* 1 - x^2 of an asin or acos of x */
    PK_SINGULARITY_CUT  /* of an angle by atan2, at whose cut L jumps: the cosine of its half */
};
struct pk_singularity {
    struct pk_quantity what; /* name: the expression as text, "sin(theta)" */
    enum pk_singularity_kind kind;
};

/* Of a family kept as loops a singularity, or a switch, is one for each member i, or for each pair
 * of i and j, which stand in its name: "x[i+1] - x[i]". */
struct pk_place {
    size_t which; /* in the table */
    ptrdiff_t i, j;
};

/* Where the equations end: n expressions, whose values are watched from step to step. Of families
 * kept as loops `count` says how many values there are, and `place` which expression and members
 * value number k belongs to; NULL: n, one each. */
struct pk_part_singularities {
    size_t n;
    const struct pk_singularity *table;
    pk_kernel *values;
    size_t (*count)(const void *params);
    void (*place)(const void *params, size_t k, struct pk_place *place);
};

/* What `event` declares: a zero of a function of the state, crossed in a direction. */
struct pk_event {
    struct pk_quantity what;
    int direction; /* +1 rising, -1 falling, 0 either */
    int stop;      /* a run ends there; 2, of a function linear in q: a start beyond it too */
};

/* What `event` declares. */
struct pk_part_events {
    size_t n;
    const struct pk_event *table;
    pk_kernel *values;
};

/* What may jump across a switch: L or a constraint of positions; a rolling's row. */
enum pk_impulse { PK_IMPULSE_ENERGY = 1, PK_IMPULSE_ROLLING = 2 };

/* Switches: arguments s of step(s), abs(s), and a - b of min(a, b), at whose zeros the equations
 * change from one smooth form to another. Side 1 fixes the form of s > 0, -1 that of s < 0,
 * whatever s is; 0, the default, takes the side of s. With all sides given the equations are smooth
 * (PK_SWITCHED). Switches within a root or a power that is no integer are not held, since beyond
 * their zeros these have no value. The sides are n pk_real from the byte `sides` of the params on;
 * see pk/events.h, which sets them in a copy. Of families kept as loops `count` says how many there
 * are, `place` of which expression and member number k is, and at that byte is a pointer to them.
 *
 * Of each switch whether rates may jump there, for L or a row of constraints does: bits of enum
 * pk_impulse; `impulses` NULL: nowhere. Then there are `slopes`, which writes ds/dq (n by the
 * degrees of freedom, along body rates; 0 of others) and ds/dt, and unconstrained, inertia and
 * energy. See pk/events.h; a step by pk_integrator_step() alone is refused. */
struct pk_part_switches {
    size_t n;
    const struct pk_quantity *names; /* the expressions as text, "t - t0" */
    size_t sides;
    pk_kernel *values;
    const unsigned char *impulses;
    pk_kernel_2 *slopes;
    size_t (*count)(const void *params); /* NULL: n */
    void (*place)(const void *params, size_t k, struct pk_place *place);
};

/* Marks: u of exp(u) and the like in the equations, which are constant, zero or huge where u is
 * beyond +-36. The integrator looks at them along each step (src/core/marks.c). */
struct pk_part_marks {
    size_t n;
    const struct pk_quantity *names; /* the calls as text, "exp(-x^2/w^2)" */
    pk_kernel *values;
};

PK_END

#endif
