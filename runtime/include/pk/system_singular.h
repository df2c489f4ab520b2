/* Parts of a system (pk/system.h): where its equations end, change or are nearly constant. */
#ifndef PK_SYSTEM_SINGULAR_H
#define PK_SYSTEM_SINGULAR_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* A singularity: an expression that the acceleration divides by or takes a root or logarithm of, or
 * an angle at whose cut L jumps. At its root one of three ends: the coordinates, if M is singular
 * there (the pole of a sphere); the motion itself (a collision); or only the expression, if the
 * quotient has a limit. */
enum pk_singularity_kind {
    PK_SINGULARITY_COORDINATES,
    PK_SINGULARITY_DIVISOR,
    PK_SINGULARITY_ROOT,
    PK_SINGULARITY_LOGARITHM,
    PK_SINGULARITY_ARC, /* 1 - x^2 of an asin or acos of x */
    PK_SINGULARITY_CUT  /* cos(angle/2) of an angle by atan2, at whose cut L jumps */
};
struct pk_singularity {
    struct pk_quantity what; /* name: the expression as text, "sin(theta)" */
    enum pk_singularity_kind kind;
};

/* With a family kept as a loop, a singularity or a switch stands for each member i, or for each
 * pair i and j, which its name contains: "x[i+1] - x[i]". */
struct pk_place {
    size_t which; /* index into the table */
    ptrdiff_t i, j;
};

/* Singularities: n expressions, whose values are monitored from step to step. With families kept as
 * loops, count() returns the number of values, and place() writes the expression and the members of
 * value number k; NULL: n values, one for each expression. */
struct pk_part_singularities {
    size_t n;
    const struct pk_singularity *table;
    pk_kernel *values;
    size_t (*count)(const void *params);
    void (*place)(const void *params, size_t k, struct pk_place *place);
};

/* An `event` of the model: a root of a function of the state, crossed in a direction. */
struct pk_event {
    struct pk_quantity what;
    int direction; /* +1 rising, -1 falling, 0 either */
    int stop;      /* a run ends there; 2, if linear in q: also refuses a start beyond it */
};

/* The events of the model. */
struct pk_part_events {
    size_t n;
    const struct pk_event *table;
    pk_kernel *values;
};

/* Jumps across a switch: of L or a holonomic constraint; of a rolling row. */
enum pk_impulse { PK_IMPULSE_ENERGY = 1, PK_IMPULSE_ROLLING = 2 };

/* Switches: arguments s of step(s) and abs(s), and a - b of min(a, b). At their roots the equations
 * change from one smooth form to another. Side 1 selects the form of s > 0, side -1 that of s < 0,
 * for any s; side 0, the default, takes the sign of s. With all sides set the equations are smooth
 * (PK_SWITCHED). A switch inside a root or a non-integer power has no side, since these are
 * undefined beyond its root. The n sides are pk_real at byte offset `sides` of the params;
 * pk/events.h sets them in a copy. With families kept as loops, count() returns the number of
 * switches, place() writes the expression and the members of number k, and a pointer to the sides
 * is at that offset.
 *
 * impulses: for each switch, bits of enum pk_impulse if rates may jump there, because L or a
 * constraint row does; NULL: nowhere. Then `slopes` writes ds/dq (n rows by pk_system.n columns; in
 * columns of body rates along the rotation, 0 in the others) and ds/dt, and the system has
 * unconstrained, inertia and energy. Only pk_events_step() makes such steps. */
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

/* Marks: arguments u of exp(u) and similar calls. Beyond +-36 such a call is constant, zero or
 * huge. The integrator monitors u along each step (src/core/short_force_limiter.c). */
struct pk_part_marks {
    size_t n;
    const struct pk_quantity *names; /* the calls as text, "exp(-x^2/w^2)" */
    pk_kernel *values;
};

PK_END

#endif
