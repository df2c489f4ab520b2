/* Hamilton's principle of a run: whether its action is a minimum among neighbours with the same
 * ends, and where conjugate points end that. Panels are doubled until the action has settled.
 */
#include <stdlib.h>
#include <string.h>

#include "diagnose_parts.h"
#include "ensemble.h"
#include "words.h"

#ifdef PK_WITH_GSL
#include <math.h>

#include <pk/gsl.h>

enum { MODES = 24, MOST = 192, PANELS = 32, MOST_PANELS = 4096, SHOWN = 8 };
static const double SETTLED = 1e-12; /* of the action, from panels to twice as many */
static const double AMPLITUDE = 1e-3; /* of a neighbour, in the length in which B is 1 */

static const char FORCES[] = "forces act besides those of L (dissipation or force): the motion is no "
                             "extremum of an action";

struct stage {
    struct pk_least_action *found;
    void *block;
    enum pk_status status;
};

static void renew(struct stage *x, struct run *run, size_t panels, size_t modes)
{
    const struct settings *s = &run->settings;
    const size_t size = pk_least_action_size(&run->problem, s->method, panels, modes);
    free(x->block);
    x->block = words_allocate(size ? size : 1, 1);
    pk_least_action_free(x->found);
    x->status = pk_least_action_find(x->found, &run->problem, s->method, &s->options, 0, s->q,
                                     s->v, run->it.t, panels, modes, x->block, size);
}

static size_t negative(const double *lambda, size_t count)
{
    size_t found = 0;
    while (found < count && lambda[found] < 0)
        found++;
    return found;
}

static void numbers(struct diagnostics *d, const char *key, const pk_real *x, size_t count)
{
    fprintf(d->file, ", \"%s\": [", key);
    for (size_t i = 0; i < count; i++) {
        fputs(i ? ", " : "", d->file);
        output_real(d->file, x[i]);
    }
    fputs("]", d->file);
}

/* The neighbour along which the action falls the most, or rises the least. */
static void neighbour(struct diagnostics *d, const struct pk_least_action *found, double *a,
                      size_t m)
{
    for (size_t i = 0; i < m; i++)
        a[i] *= AMPLITUDE;
    const double there = pk_least_action_at(found, a);
    diagnose_real(d, "neighbour", there - found->action);
}

static void write(struct diagnostics *d, const struct pk_least_action *found, const double *lambda,
                  double *lowest, size_t index_of_half)
{
    const size_t m = found->n * found->modes, index = negative(lambda, m);
    diagnose_real(d, "action", found->action);
    diagnose_real(d, "time", found->time);
    diagnose_real(d, "slope", found->slope);
    fprintf(d->file, ", \"minimum\": %s, \"index\": %zu, \"settled\": %s, \"modes\": %zu",
            index ? "false" : "true", index, index == index_of_half ? "true" : "false",
            found->modes);
    numbers(d, "curvatures", lambda, m < SHOWN ? m : SHOWN);
    numbers(d, "conjugate", found->conjugate,
            found->n_conjugate < PK_CONJUGATE_MOST ? found->n_conjugate : PK_CONJUGATE_MOST);
    neighbour(d, found, lowest, m);
    diagnose_real(d, "expected", AMPLITUDE * AMPLITUDE * lambda[0] / 2);
    fputs("}", d->file);
}

void diagnose_least_action(struct run *run, struct diagnostics *d)
{
    const struct pk_system *system = run->problem.system;
    const size_t n = run->settings.n;
    const size_t modes = MODES * n <= MOST ? MODES : MOST / n;
    struct pk_least_action found = {0};
    struct stage x = {&found, NULL, PK_REFUSED};
    char reason[512] = "";
    if (system->n_states)
        strcpy(reason, "the model has states, whose rates follow from no action");
    else if (!(system->facts & PK_VARIATIONAL))
        strcpy(reason, FORCES);
    else if (diagnose_no_variation(system))
        strcpy(reason, diagnose_no_variation(system));
    else if (modes < 2)
        strcpy(reason, "too many coordinates for its neighbours: 96 at most");
    if (!*reason) {
        double before = 0;
        size_t panels = PANELS;
        do {
            renew(&x, run, panels, modes);
            const double change = fabs(found.action - before);
            before = found.action;
            if (panels > PANELS && change <= SETTLED * found.size)
                break;
        } while (x.status >= 0 && (panels *= 2) <= MOST_PANELS);
        strcpy(reason, pk_status_text(x.status));
        if (x.status < 0 && found.it.method)
            pk_integrator_reason(&found.it, reason, sizeof reason);
    }
    double *lambda = (double *)words_allocate(2 * n * modes + 1, sizeof *lambda);
    double *lowest = lambda + n * modes;
    size_t half = 0;
    if (x.status >= 0) {
        x.status = pk_gsl_least_action(&found, modes / 2, lambda, NULL);
        half = negative(lambda, n * (modes / 2));
    }
    if (x.status >= 0 && (x.status = pk_gsl_least_action(&found, modes, lambda, lowest)) < 0)
        strcpy(reason, pk_status_text(x.status));
    if (diagnose_member(d, "least_action", x.status, reason))
        write(d, &found, lambda, lowest, half);
    free(lambda);
    pk_least_action_free(&found);
    free(x.block);
}

#else

void diagnose_least_action(struct run *run, struct diagnostics *d)
{
    (void)run;
    diagnose_member(d, "least_action", PK_REFUSED, "its eigenvalues are made by GSL, without which "
                                                   "this was built");
}

#endif
