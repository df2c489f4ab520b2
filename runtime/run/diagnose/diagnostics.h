/* The diagnostics of `pkgen run --diagnose`, told once: what the command line knows it reads here.
 *
 *     X(name, made of, kernels)
 *
 * One of a MOTION is made after the run by diagnose_NAME() in NAME.c, in this order;
 * OF_ROWS and REDUCED of the rows kept on the way too. REDUCED ones, asked for without others, are
 * of what a scene's reductions leave. MEMBERS of an ensemble have their own file. Kernels beside
 * those of a run: LINEAR the equations linearised, PARTICLES the particles' places, EVERY all; NONE.
 */
#ifndef RUN_DIAGNOSTICS_H
#define RUN_DIAGNOSTICS_H

#define DIAGNOSTICS(X)                     \
    X(lyapunov, MOTION, LINEAR)            \
    X(reversal, MOTION, NONE)              \
    X(spectrum, OF_ROWS, NONE)             \
    X(symplectic, OF_ROWS, LINEAR)         \
    X(least_action, MOTION, LINEAR)        \
    X(action, REDUCED, NONE)               \
    X(angular_momentum, MOTION, PARTICLES) \
    X(lrl, MOTION, PARTICLES)              \
    X(modes, REDUCED, EVERY)
#define DIAGNOSTICS_OF_MEMBERS(X) X(area, MEMBERS, NONE)

#endif
