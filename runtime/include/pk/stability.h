/* The computations behind `pkgen stability` for one model: its equilibria and modes, a motion, and
 * how methods reproduce it at given step sizes. A question is a call; its answer is one JSON
 * object.
 *
 *     equilibria   equilibria found from `count` starts, and their modes
 *     start        the start and the parameters of the motion
 *     motion       the motion itself over `until`, by dop853 at rtol 1e-10
 *     point        how `method` reproduces that motion at step size `h` (after `motion`)
 *     near         `count` steps of a method from near the start, an equilibrium
 *     leave        how fast `mode` leaves the start, by dop853 at rtol 1e-13
 *     rates        the eigenvalues of the equations linearised along the motion
 *     orbits       orbits of a method's step map that close after `first` to `count` steps of h,
 *                  and their multipliers, searched from the start and `tries` more; with `free` h
 *                  is an unknown. Without a method: of the motion over h
 *     returns      times after `until` (a multiple of h, if that is given) at which the motion
 *                  returns to its state at `until`
 *     beside       the distance after `count` steps of a method between the start and a state
 *                  displaced by `amplitude`, in units of the range of the motion
 *     place        a state projected onto the constraints of the start, quaternions normalised
 *     resolved     the largest error of `count` steps of a method from states along the motion,
 *                  in units of the range of the motion
 *     oscillator   the map of a step of a method on q'' = -stiffness q - damping q', h > 0
 *
 * `near` begins along `mode`, or all modes (-1), at `amplitude`, with mode `other` (-1: none) at
 * `seed`. Modes are counted from 0, in the order of `equilibria`. `equilibria`, `near`, `leave`,
 * `rates`, `orbits`, `returns` and `beside` need GSL.
 */
#ifndef PK_STABILITY_H
#define PK_STABILITY_H

#include <pk/run.h>

PK_BEGIN

struct pk_stability;

struct pk_stability_question {
    const char *method;
    double h, amplitude, seed, stiffness, damping;
    double cap; /* processor seconds after which integrations end; 0: no limit */
    long mode, other, free;
    size_t first, count, tries;
    const double
        *state; /* start of `orbits`, `beside` and `place`: q, then v; NULL: the model's start */
};

/* Returns NULL only if memory is short; each question reports wrong settings. */
struct pk_stability *pk_stability_new(const struct pk_run_model *model,
                                      const struct pk_run_settings *settings);
/* Returns the answer, valid until the next question; NULL: pk_stability_wrong() returns why. */
const char *pk_stability_ask(struct pk_stability *stability, const char *what,
                             const struct pk_stability_question *question);
const char *pk_stability_wrong(const struct pk_stability *stability);
void pk_stability_free(struct pk_stability *stability);

/* Returns the methods of a model (`own`: only its own), or of the runtime, in JSON: traits, needs,
 * and where their steps grow on linear equations. Valid until the next call. */
const char *pk_stability_methods(const struct pk_run_model *model, int own);

PK_END

#endif
