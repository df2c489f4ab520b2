/* The list of diagnostics of `pkgen run --diagnose`. The command line parses this file too.
 *
 *     X(name, made of, kernels)
 *
 * MOTION: made after the run by diagnose_NAME() in NAME.c, in this order. OF_ROWS and REDUCED: also
 * reads rows kept during the run. REDUCED: requested alone, it is made of the system that a scene's
 * reductions leave. MEMBERS: made of an ensemble. Kernels needed besides those of a run: LINEAR the
 * linearised equations, PARTICLES positions of particles, EVERY all kernels, NONE no others.
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
