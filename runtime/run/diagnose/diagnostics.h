/* The list of diagnostics of `pkgen run --diagnose`. The command line parses this file too.
 *
 *     X(name, kind, kernels)
 *
 * A diagnostic of the kind MOTION, OF_ROWS or REDUCED is computed after the run by the function
 * diagnose_NAME() in NAME.c, in the order of this list. OF_ROWS and REDUCED also read rows kept in
 * memory during the run. If a diagnostic REDUCED is the only one requested, it is computed for the
 * system without the coordinates that a scene eliminates. MEMBERS is computed for an ensemble.
 *
 * The last argument says which additional kernels the model must be compiled with: LINEAR for
 * linearised equations, PARTICLES for positions of particles, EVERY for all kernels, NONE. */
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
