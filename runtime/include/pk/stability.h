/* What `pkgen stability` asks of one model: its equilibria and modes, a motion, and what methods at
 * steps make of it. A question is a call, its answer one JSON object.
 *
 *     equilibria   where the system can rest, sought from `count` starts, and its modes there
 *     start        where and with which parameters the motion begins
 *     motion       the motion itself over `until`, by dop853 at rtol 1e-10
 *     point        what becomes of that motion by `method` at `h` (after `motion`)
 *     near         `count` steps of a method from close to the start, an equilibrium
 *     leave        how fast `mode` leaves the start, by dop853 at rtol 1e-13
 *     rates        the eigenvalues of the equations linearised along the motion
 *     orbits       orbits of a method's step map that close after `first` to `count` steps of h,
 *                  and their multipliers, sought from the start and `tries` more; with `free` h is
 *                  sought too. Without a method: of the motion, in one go over h
 *     returns      after `until` (a multiple of h, if that is given), times at which the motion
 *                  comes back to where it is then
 *     beside       how far apart `count` steps of a method bring the start and a state that is
 *                  beside it by `amplitude`, in units of what the motion covers
 *     place        a state put onto the constraints of the start, and its quaternions to length 1
 *     resolved     how far `count` steps of a method, from states along the motion, are off at
 *                  most, in units of what the motion covers
 *     oscillator   what a step of a method makes of q'' = -stiffness q - damping q', h > 0
 *
 * `near` begins along `mode` or all (-1) at `amplitude`, with mode `other` (-1: none) at `seed`.
 * Modes are counted from 0, as `equilibria` gives them. `equilibria`, `near`, `leave`, `rates`,
 * `orbits`, `returns` and `beside` need GSL.
 */
#ifndef PK_STABILITY_H
#define PK_STABILITY_H

#include <pk/run.h>

PK_BEGIN

struct pk_stability;

struct pk_stability_question {
    const char *method;
    double h, amplitude, seed, stiffness, damping;
    double cap; /* seconds of the processor after which integrations end; 0: never */
    long mode, other, free;
    size_t first, count, tries;
    const double
        *state; /* of `orbits`, `beside` and `place`, q and then v: from there; NULL: the start */
};

/* Never NULL but without memory; what is wrong with the settings is said to each question. */
struct pk_stability *pk_stability_new(const struct pk_run_model *model,
                                      const struct pk_run_settings *settings);
/* The answer, valid until the next question; NULL: pk_stability_wrong() says why. */
const char *pk_stability_ask(struct pk_stability *stability, const char *what,
                             const struct pk_stability_question *question);
const char *pk_stability_wrong(const struct pk_stability *stability);
void pk_stability_free(struct pk_stability *stability);

/* The methods of a model, its `own` or the runtime's, in JSON: what each is and needs, and where its
 * steps grow on linear equations. Valid until the next call. */
const char *pk_stability_methods(const struct pk_run_model *model, int own);

PK_END

#endif
