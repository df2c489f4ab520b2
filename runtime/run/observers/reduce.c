/* Reduces each ensemble member to some numbers, instead of its rows or in addition to them; an
 * observer. It reads the columns from run->cells. */
#include "observers.h"

#include "../settings/settings.h"

enum { BEFORE = 2 }; /* number of values in run->cells before the columns: the member and t */

/* Returns whether a requested reduction is of one of these kinds. */
static int has(const struct pk_run *run, const char *kinds)
{
    const struct pk_run_settings *s = &run->settings.asked;
    for (size_t k = 0; k < s->n_reduced; k++)
        if (strchr(kinds, s->reduced[k].what))
            return 1;
    return 0;
}

static void begin(struct pk_run *run)
{
    const size_t count = run->settings.asked.n_reduced;
    run->reduced = count ? memory_take(&run->memory, count, sizeof *run->reduced) : NULL;
    run->reduces_rows = has(run, "Mma");
}

/* Updates the reductions by a row. A NaN in any row makes the result NaN. */
static void row(struct pk_run *run, const struct moment *at)
{
    const struct pk_run_settings *s = &run->settings.asked;
    (void)at;
    for (size_t k = 0; k < s->n_reduced; k++) {
        const char what = s->reduced[k].what;
        pk_real *so_far = &run->reduced[k];
        if (!strchr("Mma", what))
            continue;
        const pk_real x = run->cells[BEFORE + s->reduced[k].index];
        if (run->reduces == 0 || x != x)
            *so_far = x;
        else if (what == 'a')
            *so_far += x;
        else if (what == 'M' ? x > *so_far : x < *so_far)
            *so_far = x;
    }
    run->reduces++;
}

/* Returns whether the relation was checked for the current member, and always held. */
static int met(struct expected *x)
{
    const int found = x->count > x->counted && x->missed == x->lost;
    x->counted = x->count;
    x->lost = x->missed;
    return found;
}

static pk_real number(struct pk_run *of, size_t k)
{
    const struct pk_run_reduced r = of->settings.asked.reduced[k];
    const struct crossed *crossed = of->crossed ? &of->crossed[r.index] : NULL;
    switch (r.what) {
    case 'f':
        return of->cells[BEFORE + r.index];
    case 'a':
        return of->reduced[k] / (pk_real)of->reduces;
    case 'n':
        return crossed ? (pk_real)crossed->count : 0;
    case 't':
        return crossed && crossed->count ? crossed->t[0] : (pk_real)NAN;
    case 'd':
        return of->settings.drifting[r.index].last;
    case 'l':
        return of->model->diagnose->lyapunov(of);
    case 'x':
        return met(&of->settings.expected[r.index]);
    default:
        return of->reduces ? of->reduced[k] : (pk_real)NAN;
    }
}

void reduce_end(struct pk_run *run, struct pk_run *of, size_t member, enum pk_status status,
                const struct moment *at)
{
    const size_t count = run->settings.asked.n_reduced;
    if (!run->members)
        return;
    double *to = run->members + member * (2 + count);
    to[0] = status;
    to[1] = (double)at->t;
    const int ended = status >= 0 && at->q;
    if (ended && has(run, "f"))
        (void)rows_fill(of, at);
    for (size_t k = 0; k < count; k++) {
        const struct pk_run_reduced r = of->settings.asked.reduced[k];
        if (!ended && r.what == 'x')
            (void)met(&of->settings.expected[r.index]);
        to[2 + k] = (double)(ended ? number(of, k) : (pk_real)NAN);
    }
    of->reduces = 0;
}

/* Saves or restores the table of members; checkpoints are only written between members. */
static void keep(struct pk_run *run, struct pk_keep *k)
{
    const struct pk_run_settings *s = &run->settings.asked;
    if (run->members)
        pk_keep(k, run->members, s->members * (2 + s->n_reduced) * sizeof *run->members);
}

const struct observer reduce_observer = {.begin = begin, .row = row, .keep = keep};
