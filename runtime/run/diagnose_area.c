/* The members of a loop while they run: q and p of each at the rows. What they enclose is found
 * from them in diagnose_area_find.c.
 */
#include "diagnose_area.h"

#include <math.h>
#include <stdlib.h>

#include "diagnose.h"
#include "words.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>

static const double BYTES = 2147483648.0; /* of q and p at all rows */

static int refuse(const char *why)
{
    fprintf(stderr, "run: diagnose area: %s\n", why);
    return EXIT_USAGE;
}

static const char *unfit(const struct settings *s, size_t n)
{
    for (size_t k = 0; k < s->n_columns; k++)
        if (s->columns[k].kind == 'p' || s->columns[k].kind == 'i')
            return "members with parameters or inputs of their own are no loop of one motion: let "
                   "starts alone differ";
    if (n == 0)
        return "the model has states alone, which have no momenta: there is no area";
    if (!run_model->canonical)
        return "the system has no kernel canonical";
    if (!pk_gsl_loop_takes(s->members))
        return "a loop has 32 members at least, and a number of them without a prime factor above "
               "1000: take 1000, 1024 or 100000";
    if (s->at && !s->has_every)
        return "rows at an event are at other times for each member: give --every, for rows that "
               "they have in common";
    return NULL;
}

int area_begin(struct run *run, const pk_real *t, size_t count)
{
    const struct settings *s = &run->settings;
    const size_t n = pk_system_coordinates(run_model, s->params);
    if (!(s->diagnose & DIAGNOSE_AREA))
        return 0;
    const char *why = unfit(s, n);
    if (why)
        return refuse(why);
    if (16.0 * (double)s->members * (double)(count + 1) * (double)n > BYTES)
        return refuse("so many rows of so many members take more than 2 GB: record less often");
    struct loop *l = (struct loop *)words_allocate(1, sizeof *l);
    l->members = s->members;
    l->rows = count + 1;
    l->n = n;
    l->whole = s->n;
    l->x = (double *)words_allocate(2 * l->rows * n * l->members, sizeof *l->x);
    l->t = (double *)words_allocate(l->rows, sizeof *l->t);
    l->came = (size_t *)words_allocate(l->members, sizeof *l->came);
    l->work = (pk_real *)words_allocate(2 * l->whole * l->members, sizeof *l->work);
    for (size_t k = 0; k < count; k++)
        l->t[k + 1] = (double)t[k];
    run->loop = l;
    return 0;
}

void area_note(struct run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    struct loop *l = run->loop;
    if (!l)
        return;
    const size_t member = run->member, row = l->came[member];
    const double now = (double)t;
    if (row >= l->rows || now < l->t[row] || now > l->t[row]) /* a row at an event, or a stop */
        return;
    pk_real *p = l->work + 2 * l->whole * member;
    run_model->canonical(run->settings.params, t, q, v, run->settings.u, p, p + l->whole);
    for (size_t i = 0; i < l->n; i++) {
        area_series(l, row, i, 0)[member] = (double)q[i];
        area_series(l, row, i, 1)[member] = (double)p[i];
    }
    l->came[member]++;
}

void area_free(struct run *run)
{
    struct loop *l = run->loop;
    if (!l)
        return;
    free(l->x);
    free(l->t);
    free(l->came);
    free(l->work);
    free(l);
    run->loop = NULL;
}
#else
int area_begin(struct run *run, const pk_real *t, size_t count)
{
    (void)t, (void)count;
    if (!(run->settings.diagnose & DIAGNOSE_AREA))
        return 0;
    fprintf(stderr, "run: diagnose area: it needs the GNU Scientific Library, which is not here\n");
    return EXIT_USAGE;
}
void area_note(struct run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    (void)run, (void)t, (void)q, (void)v;
}
void area_free(struct run *run) { (void)run; }
#endif
