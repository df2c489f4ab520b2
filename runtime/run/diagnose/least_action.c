/* Finds whether the action of a run is a minimum among neighbouring paths with the same end points,
 * and the conjugate points, after which it is no minimum. The action is an integral by quadrature;
 * the number of panels is doubled until the action does not change any more. */

#include "parts.h"

#ifdef PK_WITH_GSL

#include <pk/gsl.h>

enum { MODES = 24, MOST = 400, PANELS = 32, MOST_PANELS = 4096, SHOWN = 8 };
static const double SETTLED = 1e-12; /* relative change of the action when panels are doubled */
/* amplitude of a varied path in the norm of the matrix B; see motion.h */
static const double AMPLITUDE = 1e-3;

/* Computes the action with more and more quadrature panels until it settles. A panel is never
 * longer than half a wave of the shortest mode. */
static enum pk_status integrate(struct least_action *found, const struct motion *m, size_t modes)
{
    const size_t least = modes > PANELS ? modes : PANELS;
    enum pk_status status = PK_DONE;
    double before = 0, change = HUGE_VAL;
    for (size_t panels = least;
         status >= 0 && panels <= MOST_PANELS && !(change <= SETTLED * found->size); panels *= 2) {
        pk_integrator_free(&found->variation.motion.it);
        status = least_action_find(found, m, panels, modes);
        change = panels > least ? fabs(found->action - before) : HUGE_VAL;
        before = found->action;
    }
    return status;
}

size_t least_action_eigenvalues(const struct least_action *found, size_t modes, double *lambda,
                                double *lowest, enum pk_status *status)
{
    struct memory *memory = found->variation.motion.memory;
    const size_t all = found->modes, wide = found->n * all, m = found->n * modes;
    double *C = memory_take(memory, 3 * m * m, sizeof *C), *B = C + m * m, *U = B + m * m;
    size_t negative = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            const size_t from = (i / modes * all + i % modes) * wide + j / modes * all + j % modes;
            C[i * m + j] = found->C[from];
            B[i * m + j] = found->B[from];
        }
    *status = pk_gsl_pencil(m, C, B, lambda, U); /* fails if M is singular */
    for (size_t i = 0; *status >= 0 && i < m; i++)
        lowest[i] = U[i * m];
    while (*status >= 0 && negative < m && lambda[negative] < 0)
        negative++;
    memory_drop(memory, C);
    return negative;
}

static void write(struct diagnostics *d, const struct least_action *found, const double *lambda,
                  double *lowest, size_t index, int settled)
{
    const size_t m = found->n * found->modes, points = found->n_conjugate;
    struct json *j = &d->json;
    json_reals(j, {"action", found->action}, {"time", found->time}, {"slope", found->slope});
    json_flag(j, "minimum", !index);
    json_integer(j, "index", index);
    json_flag(j, "settled", settled);
    json_integer(j, "modes", found->modes);
    json_numbers(j, "curvatures", lambda, m < SHOWN ? m : SHOWN);
    json_numbers(j, "conjugate", found->conjugate,
                 points < CONJUGATE_MOST ? points : CONJUGATE_MOST);
    for (size_t i = 0; i < m; i++) /* a varied path along the mode of the lowest eigenvalue */
        lowest[i] *= AMPLITUDE;
    json_reals(j, {"neighbour", least_action_at(found, lowest) - found->action},
               {"expected", AMPLITUDE * AMPLITUDE * lambda[0] / 2});
}

void diagnose_least_action(struct diagnostics *d)
{
    const struct motion motion = motion_of(d->run);
    const struct pk_system *system = motion.problem->system;
    const size_t n = d->run->settings.n;
    size_t modes = MODES * n <= MOST ? MODES : MOST / n, half = 0, index = 0;
    struct least_action found = {0};
    enum pk_status status = PK_REFUSED;
    const char *why = diagnose_not_free(system);
    if (!why && system->n_first_order)
        why = "the model has states, whose rates follow from no action";
    if (!why && !(system->facts & PK_VARIATIONAL))
        why = "forces act besides those of L (dissipation or force): the motion is no extremum of "
              "an action";
    why = why ? why : diagnose_no_variation(d->run);
    if (!why && modes < 2)
        why = "too many coordinates for its neighbours: 200 at most";
    double *lambda = NULL;
    for (int more = !why; more;) {
        const size_t m = n * modes;
        status = integrate(&found, &motion, modes);
        lambda = memory_take(motion.memory, 2 * m, sizeof *lambda);
        if (status >= 0)
            half = least_action_eigenvalues(&found, modes / 2, lambda, lambda + m, &status);
        if (status >= 0)
            index = least_action_eigenvalues(&found, modes, lambda, lambda + m, &status);
        /* The Morse index is the number of negative eigenvalues, or the number of conjugate points
         * if that is larger, since too few modes give too few negative eigenvalues. */
        index = index > found.n_conjugate ? index : found.n_conjugate;
        /* With few modes some negative directions may not show yet. */
        more = status >= 0 && half < index && 2 * m <= MOST;
        modes *= more ? 2 : 1;
    }
    if (diagnose_told(d, status, why, &found.variation.motion.it))
        write(d, &found, lambda, lambda + n * modes, index, index == half);
    pk_integrator_free(&found.variation.motion.it);
}

#else
DIAGNOSE_NEEDS_GSL(least_action)
#endif
