/* The list of diagnostics of `pkgen run --diagnose`. The command line parses this file too.
 *
 *     X(name, kind, kernels)
 *
 * Kinds: MOTION is made by diagnose_NAME() in NAME.c after the run, in this order. OF_ROWS and
 * REDUCED also read rows kept during the run. REDUCED, if requested alone, is made of the system
 * without the coordinates that a scene eliminates. MEMBERS is made of an ensemble. Additional
 * kernels: LINEAR for linearised equations, PARTICLES for positions of particles, EVERY for all
 * kernels, NONE.
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
