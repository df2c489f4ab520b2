/* What changes a motion at once: values given by events, contacts, friction that sticks, latches.
 *
 * A contact is a row of the constraints that holds at times: `mode`, an input, is 1 while it does.
 * The multiplier of a closed contact pushes; where that would pull, the contact opens. Where a gap
 * closes, impulses change the rates by Newton's or Poisson's law of restitution. Friction holds its
 * row, a slip, at 0, up to a bound of its multiplier; beyond, it pushes against the slip.
 *
 *     struct pk_actor a = {.system = &model_system, .params = &params, .u = u, .events = &events};
 *     status = pk_actor_start(&a, &it, work);          (pk_actor_reals() numbers)
 *     ... events.found = function that returns pk_actor_note(&a, events) ...
 *     status = pk_events_step(&events, &it, end);
 *     if (status == PK_STOPPED_EVENT && a.acting)
 *         status = pk_actor_run(&a, &it);
 *
 * Several contacts and frictions act together as the solution of a linear complementarity problem,
 * found by Murty's least-index pivots, for impulses and for accelerations.
 * References: C. Glocker, F. Pfeiffer, Multibody Dynamics with Unilateral Contacts, Wiley 1996;
 * K. G. Murty, Linear Complementarity, Linear and Nonlinear Programming, 1988, section 4.1. */
#ifndef PK_ACT_H
#define PK_ACT_H

#include <pk/events.h>
#include <pk/keep.h>

PK_BEGIN

/* A contact as far as a run has seen it. `rests` is the time from which it has stayed closed, or
 * NaN; `lost` is the energy that its impacts have taken. */
struct pk_contact_seen {
    pk_real impacts, rests, lost;
    pk_real grazes;                /* first time of a touch without a force, or NaN */
    pk_real highest, last, flight; /* largest height of a bounce; last impact, and time before it */
};

struct pk_actor {
    const struct pk_system *system;
    const void *params;
    pk_real
        *u; /* the inputs, which the modes are among; the integrator's input function gives them */

    struct pk_events *events; /* those that find what is noted, initialised, or NULL */

    int acting;                   /* flag: an event that changes the motion was noted */
    size_t stopped;               /* 1 + the first event noted that ends the run, or 0 */
    struct pk_contact_seen *seen; /* one for each contact */
    /* The first impact whose outcome depends on the order of two contacts: its time, or NaN. */
    pk_real order_t, order_of[2];

    /* Private to the runtime. */
    size_t n_q, n;
    pk_real changed;           /* time of the last change */
    pk_real crowd, crowd_from; /* changes since a time that is hardly past */
    pk_real most[3]; /* the largest coordinate, rate and acceleration so far, times sqrt(M_kk) */
    pk_real *work, *happened, *next, *values, *before, *A, *b, *x, *B, *touches, *state, *idle,
        *floats, *clings, *room;
};

/* Returns the number of pk_real of work memory; 0 if nothing in the system acts. */
size_t pk_actor_reals(const struct pk_problem *problem);
/* Finds the modes at the start of a motion, or after a change by the caller. Fails with
 * PK_PENETRATES, PK_NO_CONTACT, or as pk_integrator_reset(). */
enum pk_status pk_actor_start(struct pk_actor *a, struct pk_integrator *it, pk_real *work);
/* Notes an event; to be called by pk_events.found. Returns whether the motion changes there. */
int pk_actor_note(struct pk_actor *a, const struct pk_events *events);
/* Changes the motion at the events noted, and resets the integrator there. Returns
 * PK_STOPPED_EVENT if one of them ends the run; else PK_DONE, or a failure as pk_actor_start(). */
enum pk_status pk_actor_run(struct pk_actor *a, struct pk_integrator *it);
/* Returns the status of pk_actor_run() if a step that ended with `status` ended at an event noted
 * that changes the motion, or if rates break a closed gap behind a kink; else `status`. */
enum pk_status pk_actor_act(struct pk_actor *a, struct pk_integrator *it, enum pk_status status);
void pk_actor_keep(struct pk_actor *a, struct pk_keep *k);

PK_END

#endif
