/* The area within a loop of members in phase space, sum over coordinates of the closed integral of
 * p dq, which any flow of L preserves (Poincare). Members shear apart along the loop, which then
 * has more structure than they resolve: what the area is worth is told by the last harmonics.
 * Reference: V. I. Arnold, Mathematical Methods of Classical Mechanics, 44.
 */
#include "diagnose_area.h"

#include <math.h>
#include <stdlib.h>

#include "diagnose_parts.h"
#include "ensemble.h"
#include "words.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>

#define RESOLVED 1e-12                     /* of the tail */
static const double BYTES = 2147483648.0; /* of q and p at all rows */

struct loop {
    size_t members, rows, n;
    double *x, *t; /* of each row: q of all members for each coordinate, then p */
    pk_real *p, *pdot;
};

static double *series(const struct loop *l, size_t row, size_t i, int momentum)
{
    return l->x + ((2 * row + (size_t)momentum) * l->n + i) * l->members;
}

static int refuse(const char *why)
{
    fprintf(stderr, "run: diagnose area: %s\n", why);
    return EXIT_USAGE;
}

int area_begin(struct run *run, size_t rows)
{
    const struct settings *s = &run->settings;
    if (!(s->diagnose & DIAGNOSE_AREA))
        return 0;
    for (size_t k = 0; k < s->n_columns; k++)
        if (s->columns[k].kind == 'p' || s->columns[k].kind == 'i')
            return refuse("members with parameters or inputs of their own are no loop of one "
                          "motion: let starts alone differ");
    if (!run_model->canonical)
        return refuse("the system has no kernel canonical");
    if (16.0 * (double)s->members * (double)rows * (double)s->n > BYTES)
        return refuse("so many rows of so many members take more than 2 GB: record less often");
    struct loop *l = (struct loop *)words_allocate(1, sizeof *l);
    l->members = s->members;
    l->rows = rows;
    l->n = s->n;
    l->x = (double *)words_allocate(2 * rows * l->n * l->members, sizeof *l->x);
    l->t = (double *)words_allocate(rows, sizeof *l->t);
    l->p = (pk_real *)words_allocate(2 * l->n, sizeof *l->p);
    l->pdot = l->p + l->n;
    for (size_t k = 0; k < 2 * rows * l->n * l->members; k++)
        l->x[k] = NAN; /* until a member comes there */
    run->loop = l;
    return 0;
}

void area_note(struct run *run, size_t row, pk_real t, const pk_real *q, const pk_real *v)
{
    struct loop *l = run->loop;
    if (!l)
        return;
    run_model->canonical(run->settings.params, t, q, v, run->settings.u, l->p, l->pdot);
    l->t[row] = (double)t;
    for (size_t i = 0; i < l->n; i++) {
        series(l, row, i, 0)[run->member] = (double)q[i];
        series(l, row, i, 1)[run->member] = (double)l->p[i];
    }
}

/* By how much a coordinate of the starts is more after once round: a multiple of 2 pi. */
static double winding_of(const double *q, size_t count)
{
    const double gap = 2 * q[count - 1] - q[count - 2] - q[0];
    return 2 * PK_PI * round(gap / (2 * PK_PI));
}

/* At one row; the worst tail of the coordinates that have a part in it beyond rounding. */
static enum pk_status area_at(const struct loop *l, size_t row, const double *winding,
                              struct pk_loop_area *parts, double *area, double *tail)
{
    double most = 0;
    *area = *tail = 0;
    for (size_t i = 0; i < l->n; i++) {
        const enum pk_status status = pk_gsl_loop_area(series(l, row, i, 0), series(l, row, i, 1),
                                                       l->members, winding[i], &parts[i]);
        if (status < 0)
            return status;
        *area += parts[i].area;
        most = fmax(most, parts[i].size);
    }
    for (size_t i = 0; i < l->n; i++)
        if (parts[i].size > PK_EPSILON * most)
            *tail = fmax(*tail, parts[i].tail);
    return PK_DONE;
}

static void write_rows(struct run *run, struct diagnostics *d, const double *winding)
{
    const struct loop *l = run->loop;
    struct pk_drift drift;
    struct pk_loop_area *parts =
        (struct pk_loop_area *)words_allocate(l->n, sizeof *parts);
    double until = -1;
    int resolved = 1;
    pk_drift_init(&drift);
    fprintf(d->file, ", \"members\": %zu, ", l->members);
    output_numbers(d->file, "winding", winding, l->n);
    diagnose_real(d, "threshold", RESOLVED);
    fprintf(d->file, ", \"conserved\": %s, \"rows\": [",
            run_model->facts & PK_VARIATIONAL ? "true" : "false");
    for (size_t row = 0; row < l->rows; row++) {
        double area, tail;
        const int done = area_at(l, row, winding, parts, &area, &tail) == PK_DONE;
        resolved = resolved && done && tail <= RESOLVED;
        if (resolved) {
            pk_drift_update(&drift, l->t[row], area);
            until = l->t[row];
        }
        fputs(row ? ",\n      [" : "\n      [", d->file);
        output_real(d->file, l->t[row]);
        fputs(", ", d->file);
        output_real(d->file, done ? area : PK_INFINITY);
        fputs(", ", d->file);
        output_real(d->file, done ? tail : PK_INFINITY);
        fputs("]", d->file);
        run_progress(run, (double)row / (double)l->rows, 0);
    }
    fputs("]", d->file);
    diagnose_real(d, "resolved_until", until < 0 ? PK_INFINITY : until);
    fputs(", \"drift\": ", d->file);
    output_drift(d->file, "area", &drift);
    fputs("}", d->file);
    free(parts);
}

int area_find(struct run *run, int code)
{
    struct loop *l = run->loop;
    if (!l)
        return code;
    struct diagnostics *d = diagnose_open(run);
    double *winding = (double *)words_allocate(l->n, sizeof *winding);
    double *copy = (double *)words_allocate(2 * l->members, sizeof *copy);
    struct pk_loop_area first;
    for (size_t k = 0; k < l->members; k++) {
        copy[k] = series(l, 0, 0, 0)[k];
        copy[l->members + k] = series(l, 0, 0, 1)[k];
    }
    const enum pk_status status = pk_gsl_loop_area(copy, copy + l->members, l->members, 0, &first);
    const char *reason =
        status == PK_BAD_ARGUMENT
            ? "a loop has 32 members at least, and a number of them without a prime factor above "
              "1000: take 1000, 1024 or 100000"
            : pk_status_text(status);
    for (size_t i = 0; i < l->n && status == PK_DONE; i++)
        winding[i] = winding_of(series(l, 0, i, 0), l->members);
    if (diagnose_member(d, "area", status == PK_BAD_ARGUMENT ? PK_REFUSED : status, reason))
        write_rows(run, d, winding);
    fclose(d->file);
    free(copy);
    free(winding);
    free(l->x);
    free(l->t);
    free(l->p);
    free(l);
    run->loop = NULL;
    return code ? code : d->code;
}
#else
int area_begin(struct run *run, size_t rows)
{
    (void)rows;
    if (!(run->settings.diagnose & DIAGNOSE_AREA))
        return 0;
    fprintf(stderr, "run: diagnose area: it needs the GNU Scientific Library, which is not here\n");
    return EXIT_USAGE;
}
void area_note(struct run *run, size_t row, pk_real t, const pk_real *q, const pk_real *v)
{
    (void)run, (void)row, (void)t, (void)q, (void)v;
}
int area_find(struct run *run, int code)
{
    (void)run;
    return code;
}
#endif
