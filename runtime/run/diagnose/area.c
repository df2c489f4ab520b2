/* Collects q and p of the members of a loop at their rows; area_find.c computes the area. */
#include "area.h"

#include "../observers/observers.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>
#endif

static const double BYTES = 2147483648.0; /* memory limit for q and p at all rows */

static const char *unfit(const struct settings *s, size_t n, size_t count)
{
    for (size_t k = 0; k < s->asked.n_member_columns; k++)
        if (s->asked.member_columns[k].kind == 'p' || s->asked.member_columns[k].kind == 'i')
            return "members with parameters or inputs of their own are no loop of one motion: let "
                   "starts alone differ";
    if (n == 0)
        return "the model has states alone, which have no momenta: there is no area";
    if (!s->system->canonical)
        return "the system has no kernel canonical";
#ifdef PK_WITH_GSL
    if (!pk_gsl_loop_takes(s->asked.members))
        return "a loop has 32 members at least, and a number of them without a prime factor above "
               "1000: take 1000, 1024 or 100000";
#else
    return "it needs the GNU Scientific Library, which is not here";
#endif
    if (s->asked.at && !s->has_every)
        return "rows at an event are at other times for each member: give --every, for rows that "
               "they have in common";
    return 16.0 * (double)s->asked.members * (double)(count + 1) * (double)n > BYTES
               ? "so many rows of so many members take more than 2 GB: record less often"
               : NULL;
}

enum pk_run_code area_begin(struct pk_run *run, const pk_real *t, size_t count)
{
    const struct settings *s = &run->settings;
    const size_t n = settings_coordinates(s);
    if (!(s->asked.diagnose & DIAGNOSE_AREA))
        return PK_RUN_DONE;
    const char *why = unfit(s, n, count);
    if (why)
        return run_refuse(run, "diagnose area: %s", why);
    struct loop *l = memory_take(&run->memory, 1, sizeof *l);
    l->members = s->asked.members;
    l->rows = count + 1;
    l->n = n;
    l->whole = s->n;
    l->x = memory_take(&run->memory, 2 * l->rows * n * l->members, sizeof *l->x);
    l->t = memory_take(&run->memory, l->rows, sizeof *l->t);
    l->came = memory_take(&run->memory, l->members, sizeof *l->came);
    l->work = memory_take(&run->memory, 2 * l->whole * l->members, sizeof *l->work);
    for (size_t k = 0; k < count; k++)
        l->t[k + 1] = (double)t[k];
    run->loop = l;
    return PK_RUN_DONE;
}

void area_note(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    struct loop *l = run->loop;
    if (!l)
        return;
    const size_t member = run->member, row = l->came[member];
    const double now = (double)t;
    if (row >= l->rows || now < l->t[row] || now > l->t[row]) /* ignores extra rows at events */
        return;
    pk_real *p = l->work + 2 * l->whole * member;
    run->settings.system->canonical(run->settings.params, t, q, v, run->settings.u, p,
                                    p + l->whole);
    for (size_t i = 0; i < l->n; i++) {
        area_series(l, row, i, 0)[member] = (double)q[i];
        area_series(l, row, i, 1)[member] = (double)p[i];
    }
    l->came[member]++;
}

static void row(struct pk_run *run, const struct moment *at)
{
    if (!run->at_event)
        area_note(run, at->t, at->q, at->v);
}

static void keep(struct pk_run *run, struct pk_keep *k)
{
    const struct loop *l = run->loop;
    if (!l)
        return;
    pk_keep(k, l->x, 2 * l->rows * l->n * l->members * sizeof *l->x);
    pk_keep(k, l->came, l->members * sizeof *l->came);
}

const struct observer area_observer = {.row = row, .keep = keep};
