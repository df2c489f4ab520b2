/* Parts of struct pk_system: where the equations are singular, change or are nearly constant. */
#ifndef PK_SYSTEM_SINGULAR_H
#define PK_SYSTEM_SINGULAR_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* A singularity: an expression that the acceleration divides by or takes a root or logarithm of, or
 * an angle at whose branch cut L jumps. There are three cases at a root of the expression. Either M
 * is singular, but the motion could continue in other coordinates (the pole of a sphere). Or the
 * motion itself ends (a collision). Or only the expression of the acceleration is undefined, since
 * it is a quotient that has a finite limit. */
enum pk_singularity_kind {
    PK_SINGULARITY_COORDINATES,
    PK_SINGULARITY_DIVISOR,
    PK_SINGULARITY_ROOT,
    PK_SINGULARITY_LOGARITHM,
    PK_SINGULARITY_ARC, /* the expression is 1 - x^2, for asin(x) or acos(x) */
    /* the expression is cos(angle/2), for an angle computed by atan2 at whose branch cut L jumps */
    PK_SINGULARITY_CUT
};
struct pk_singularity {
    struct pk_quantity what; /* its name is the text of the expression, such as "sin(theta)" */
    enum pk_singularity_kind kind;
};

/* In a system of variable size, a singularity or a switch may stand for many expressions: one for
 * each member i of a family, or for each pair i and j. Its name contains these indices: "x[i+1] -
 * x[i]". This struct is one of these expressions. */
struct pk_place {
    size_t which; /* index of the singularity or switch */
    ptrdiff_t i, j;
};

/* Singularities: n expressions, whose values are monitored at each step. In a system of variable
 * size count() returns the number of values, and place() writes to which expression, and which
 * indices i and j, value number k belongs. If both are NULL, each expression has one value. */
struct pk_part_singularities {
    size_t n;
    const struct pk_singularity *table;
    pk_kernel *values;
    size_t (*count)(const void *params);
    void (*place)(const void *params, size_t k, struct pk_place *place);
};

/* An `event` of the model: a root of a function of the state, crossed in a given direction. */
struct pk_event {
    struct pk_quantity what;
    /* +1: only roots where the function rises with time, -1: only where it falls, 0: all roots */
    int direction;
    /* 1: the run ends at the event; 2: it also ends at once if its start is beyond the root */
    int stop;
};

/* The events of the model. */
struct pk_part_events {
    size_t n;
    const struct pk_event *table;
    pk_kernel *values;
};

/* Values after an event: next() writes q, v and all inputs after it. */
struct pk_reset {
    size_t event;
    pk_kernel *next;
};
struct pk_part_resets {
    size_t n;
    const struct pk_reset *table;
};

/* A constraint row that holds at times; see pk/act.h. */
enum pk_contact_kind { PK_CONTACT, PK_FRICTION, PK_LATCH };
struct pk_contact {
    const char *name;
    enum pk_contact_kind kind;
    size_t row; /* of the constraints */
    /* The input that is 1 while the row holds. The next input is for friction the direction of the
     * slip, or 0; else the energy lost in impacts. The third is 1 while the row is kept at 0 by
     * others that it is a combination of, without a force of its own that is to be found. */
    size_t mode;
    size_t of; /* of a friction: number of the contact whose multiplier bounds it, or of none */
    /* Events: where a gap closes, where a contact opens; where friction changes; where a latch
     * closes and opens. */
    size_t event, open;
    int flag; /* of a contact: Poisson's law of restitution; of a latch: it holds at the start */
};
/* values() writes five numbers for each: the acceleration of the row if no row holds that may open;
 * then of a contact the coefficient of restitution, and of a friction its bound while it slips,
 * F + mu lambda, as F and mu, and the same while it sticks. modes: for each constraint row 1 + the
 * input that is its mode, or 0 if it always holds. */
struct pk_part_contacts {
    size_t n;
    const struct pk_contact *table;
    const size_t *modes;
    pk_kernel *values;
};

/* Kinds of jumps across a switch. PK_IMPULSE_ENERGY: L or a holonomic constraint jumps;
 * PK_IMPULSE_ROLLING: a rolling constraint jumps. */
enum pk_impulse { PK_IMPULSE_ENERGY = 1, PK_IMPULSE_ROLLING = 2 };

/* Switches: arguments s of step(s) and abs(s), and a - b of min(a, b). At their roots the equations
 * change from one smooth form to another. Each switch has a number, its side. Side 1 selects the
 * form of the equations for s > 0, side -1 the form for s < 0, whatever the value of s is. Side 0,
 * the default, and NaN, for an s that stays exactly 0, select the form by the value of s. With all
 * sides set the equations are smooth (PK_SWITCHED). A switch inside a root or a non-integer power
 * has no side, since these are undefined on one side. The n sides are pk_real at byte offset
 * `sides` of the params; pk/events.h sets them in a copy. In a system of variable size, count()
 * returns the number of switches, place() writes the expression and the members of number k, and
 * `offset` is that of a pointer to the sides.
 *
 * impulses: for each switch, bits of enum pk_impulse. A bit is set if rates may jump at the switch,
 * because L or a constraint row jumps. NULL: rates jump at no switch. If a bit is set, `slopes`
 * writes ds/dq (n rows by pk_system.n columns; in the columns of body rates the derivative along
 * the rotation, 0 in those of other first-order variables) and ds/dt, and the system has
 * unconstrained, inertia and energy. Only pk_events_step() handles switches. */
struct pk_part_switches {
    size_t n;
    const struct pk_quantity *names; /* the text of each expression, "t - t0" */
    size_t sides;
    pk_kernel *values;
    const unsigned char *impulses;
    pk_kernel_2 *slopes;
    size_t (*count)(const void *params); /* number of switches; NULL: n */
    void (*place)(const void *params, size_t k, struct pk_place *place);
};

/* Marks are the arguments u of exp(u) and similar functions. For |u| > 36 such a function is nearly
 * constant, zero or huge. So a step in which u passes through the whole range |u| < 36 could miss a
 * short force. The integrator monitors u along each step (src/core/short_force_limiter.c). */
struct pk_part_marks {
    size_t n;
    const struct pk_quantity *names; /* the text of each call, "exp(-x^2/w^2)" */
    pk_kernel *values;
};

PK_END

#endif
