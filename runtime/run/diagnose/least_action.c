/* Finds whether the action of a run is a minimum among neighbouring paths with the same end points,
 * and the conjugate points, after which it is no minimum. The action is an integral by quadrature;
 * the number of panels is doubled until the action does not change any more. */

#include "parts.h"

#ifdef PK_WITH_GSL

#include <pk/gsl.h>

enum { MODES = 24, MOST = 400, PANELS = 32, MOST_PANELS = 4096, SHOWN = 8 };
static const double SETTLED = 1e-12; /* relative change of the action when panels are doubled */
/* amplitude of a varied path in the norm of the matrix B; see pk/least_action.h */
static const double AMPLITUDE = 1e-3;

/* Computes the action with more and more quadrature panels until it settles. A panel is never
 * longer than half a wave of the shortest mode. */
static enum pk_status integrate(struct pk_least_action *found, struct pk_run *run, size_t modes)
{
    const struct settings *s = &run->settings;
    const size_t least = modes > PANELS ? modes : PANELS;
    enum pk_status status = PK_DONE;
    double before = 0, change = HUGE_VAL;
    for (size_t panels = least;
         status >= 0 && panels <= MOST_PANELS && !(change <= SETTLED * found->size); panels *= 2) {
        const size_t size = pk_least_action_size(&run->problem, s->method, panels, modes);
        void *block = memory_take(&run->memory, size, 1);
        pk_least_action_free(found);
        status = pk_least_action_find(found, &run->problem, s->method, &s->options, 0, s->q, s->v,
                                      run->it.t, panels, modes, block, size);
        change = panels > least ? fabs(found->action - before) : HUGE_VAL;
        before = found->action;
    }
    return status;
}

static size_t negative(const double *lambda, size_t count)
{
    size_t found = 0;
    while (found < count && lambda[found] < 0)
        found++;
    return found;
}

/* Returns the change of the action for a varied path along the mode of the lowest eigenvalue. */
static double neighbour(const struct pk_least_action *found, double *a, size_t m)
{
    for (size_t i = 0; i < m; i++)
        a[i] *= AMPLITUDE;
    return pk_least_action_at(found, a) - found->action;
}

/* Returns the Morse index: the number of negative eigenvalues, or the number of conjugate points if
 * that is larger, since too few modes give too few negative eigenvalues. */
static size_t index_of(const struct pk_least_action *found, const double *lambda)
{
    const size_t index = negative(lambda, found->n * found->modes);
    return index > found->n_conjugate ? index : found->n_conjugate;
}

static void write(struct diagnostics *d, const struct pk_least_action *found, const double *lambda,
                  double *lowest, size_t index_of_half)
{
    const size_t m = found->n * found->modes, index = index_of(found, lambda);
    const size_t points = found->n_conjugate;
    struct json *j = &d->json;
    json_reals(j, {"action", found->action}, {"time", found->time}, {"slope", found->slope});
    json_flag(j, "minimum", !index);
    json_integer(j, "index", index);
    json_flag(j, "settled", index == index_of_half);
    json_integer(j, "modes", found->modes);
    json_numbers(j, "curvatures", lambda, m < SHOWN ? m : SHOWN);
    json_numbers(j, "conjugate", found->conjugate,
                 points < PK_CONJUGATE_MOST ? points : PK_CONJUGATE_MOST);
    json_reals(j, {"neighbour", neighbour(found, lowest, m)},
               {"expected", AMPLITUDE * AMPLITUDE * lambda[0] / 2});
}

void diagnose_least_action(struct pk_run *run, struct diagnostics *d)
{
    const struct pk_system *system = run->problem.system;
    const size_t n = run->settings.n;
    size_t modes = MODES * n <= MOST ? MODES : MOST / n;
    struct pk_least_action found = {0};
    enum pk_status status = PK_REFUSED;
    const char *why = diagnose_not_free(system);
    if (!why && system->n_first_order)
        why = "the model has states, whose rates follow from no action";
    if (!why && !(system->facts & PK_VARIATIONAL))
        why = "forces act besides those of L (dissipation or force): the motion is no extremum of "
              "an action";
    why = why ? why : diagnose_no_variation(run);
    if (!why && modes < 2)
        why = "too many coordinates for its neighbours: 200 at most";
    double *lambda = NULL;
    size_t half = 0;
    for (int more = !why; more;) {
        const size_t m = n * modes;
        status = integrate(&found, run, modes);
        lambda = memory_take(&run->memory, 2 * m, sizeof *lambda);
        if (status >= 0)
            status = pk_gsl_least_action(&found, modes / 2, lambda, NULL);
        half = status < 0 ? 0 : negative(lambda, n * (modes / 2));
        if (status >= 0)
            status = pk_gsl_least_action(&found, modes, lambda, lambda + m);
        /* With few modes some negative directions may not show yet. */
        more = status >= 0 && half < index_of(&found, lambda) && 2 * m <= MOST;
        modes *= more ? 2 : 1;
    }
    if (diagnose_told(d, status, why, &found.it))
        write(d, &found, lambda, lambda + n * modes, half);
    pk_least_action_free(&found);
}

#else
DIAGNOSE_NEEDS_GSL(least_action)
#endif
