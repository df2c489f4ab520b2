/* See choose_rows.h. */
#include "choose_rows.h"

#include <stdlib.h>
#include <string.h>

#include "expect.h"
#include "words.h"

enum { MOST_ROWS = 20000, MOST_NUMBERS = 4000000 }; /* kept; of more, every other one */

size_t rows_columns(const struct settings *s)
{
    size_t count = pk_system_coordinates(run_model, s->params) + s->n +
                   run_model->n_quadratures + (run_model->energy != NULL);
    if (s->n_show)
        return s->n_show;
    for (size_t i = 0; i < run_model->n_observed; i++)
        count += !expect_hides(s, i);
    return count;
}

static void grow(struct rows *rows)
{
    const size_t room = rows->room ? 2 * rows->room : 1024;
    pk_real *t = (pk_real *)words_allocate(room, sizeof *t);
    pk_real *x = (pk_real *)words_allocate(room * rows->columns, sizeof *x);
    if (rows->count) {
        memcpy(t, rows->t, rows->count * sizeof *t);
        memcpy(x, rows->x, rows->count * rows->columns * sizeof *x);
    }
    free(rows->t);
    free(rows->x);
    rows->t = t, rows->x = x, rows->room = room;
}

/* Every other row goes. */
static void thin(struct rows *rows)
{
    const size_t m = rows->columns;
    for (size_t k = 0; 2 * k < rows->count; k++) {
        rows->t[k] = rows->t[2 * k];
        memmove(rows->x + k * m, rows->x + 2 * k * m, m * sizeof *rows->x);
    }
    rows->count = (rows->count + 1) / 2;
    rows->stride *= 2;
}

/* The columns of the row, in the order of rows.c. */
static void shown(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *z, const pk_real *out, pk_real *x)
{
    const struct pk_system *system = run_model;
    const pk_real *const of[] = {q, v, out, z};
    static const char kinds[] = "qvoz";
    for (size_t i = 0; i < s->n_show; i++) {
        const char *kind = strchr(kinds, s->show[i].kind);
        *x++ = kind ? of[kind - kinds][s->show[i].index]
                    : system->energy(s->params, t, q, v, s->u);
    }
    if (s->n_show)
        return;
    const size_t coordinates = pk_system_coordinates(system, s->params);
    memcpy(x, q, coordinates * sizeof *x);
    memcpy(x += coordinates, v, s->n * sizeof *x);
    x += s->n;
    for (size_t i = 0; i < system->n_observed; i++)
        if (!expect_hides(s, i))
            *x++ = out[i];
    for (size_t i = 0; i < system->n_quadratures; i++)
        *x++ = z[i];
    if (system->energy)
        *x = system->energy(s->params, t, q, v, s->u);
}

void rows_keep(struct run *run, pk_real t, const pk_real *q, const pk_real *v, const pk_real *z,
               pk_real *out)
{
    const struct settings *s = &run->settings;
    struct rows *rows = run->kept;
    rows->columns = rows_columns(s);
    rows->by_number = s->at != 0;
    run->last_row = t;
    const int last = t == s->until;
    if (rows->seen++ % rows->stride && !last)
        return;
    if (run_model->n_observed)
        run_model->observe(s->params, t, q, v, s->u, out);
    if (rows->count == rows->room)
        grow(rows);
    rows->t[rows->count] = t;
    shown(s, t, q, v, z, out, rows->x + rows->count++ * rows->columns);
    if (!last && (rows->count > MOST_ROWS || rows->count * rows->columns > MOST_NUMBERS))
        thin(rows);
}

void rows_keep_ends(struct run *run)
{
    const struct pk_integrator *it = &run->it;
    struct settings *s = &run->settings;
    pk_real *out = run->row + 2 * s->n, *z = out + run_model->n_observed;
    if (!s->at || run->kept->count || it->status < 0)
        return;
    settings_z(s, run_model, s->params, z);
    rows_keep(run, 0, s->q, s->v, z, out);
    rows_keep(run, it->t, it->q, it->v, it->z, out);
    run->kept->without = 1;
}

void rows_clear(struct rows *rows)
{
    rows->count = rows->seen = 0;
    rows->without = 0;
    rows->stride = 1;
}

void rows_free(struct rows *rows)
{
    free(rows->t);
    free(rows->x);
    free(rows->low);
    memset(rows, 0, sizeof *rows);
}

pk_real rows_scale(const struct rows *rows, size_t column)
{
    pk_real largest = 0;
    for (size_t k = 0; k < rows->count; k++) {
        const pk_real x = PK_F(fabs)(rows->x[k * rows->columns + column]);
        largest = x > largest ? x : largest;
    }
    return largest;
}

/* Infinite where it is no number. */
static pk_real apart(const struct rows *exact, size_t k, const struct rows *tried, size_t j,
                     size_t i, pk_real scale)
{
    const size_t m = exact->columns;
    pk_real error = tried->x[j * m + i] - exact->x[k * m + i];
    if (exact->low)
        error -= (pk_real)exact->low[k * m + i];
    error = PK_F(fabs)(error);
    if (error == 0)
        return 0;
    return error < PK_INFINITY ? error / scale : PK_INFINITY; /* a NaN is not less */
}

/* The row j of `tried` that is row k of the exact ones: 1, -1 if it is missing, 0 if it was not
 * kept, where one of them kept fewer. Rows by time are at the same doubles but for the last one,
 * which may be at an event; of those at crossings the third is the third. */
static int matching(const struct rows *exact, size_t k, const struct rows *tried, size_t *j)
{
    const int last = k + 1 == exact->count;
    if (exact->by_number) {
        *j = k;
        return k < tried->count && (!last || tried->count == exact->count) ? 1 : -1;
    }
    while (*j < tried->count && tried->t[*j] < exact->t[k])
        ++*j;
    if (*j < tried->count && tried->t[*j] == exact->t[k])
        return 1;
    if (last && tried->count && (*j == tried->count || *j + 1 == tried->count)) {
        *j = tried->count - 1;
        return 1;
    }
    return exact->stride == tried->stride ? -1 : 0;
}

void rows_compare(const struct rows *exact, const struct rows *tried, pk_real accuracy,
                  const unsigned char *ignored, struct difference *found)
{
    const size_t m = exact->columns;
    pk_real *scales = (pk_real *)words_allocate(m, sizeof *scales);
    const pk_real end = exact->count ? exact->t[exact->count - 1] : 0;
    int held = 1;
    found->largest = found->holds = 0;
    found->count = 0;
    for (size_t i = 0; i < m; i++)
        scales[i] = rows_scale(exact, i), found->columns[i] = 0;
    for (size_t k = 0, j = 0; k < exact->count; k++) {
        const int at = matching(exact, k, tried, &j);
        if (!at)
            continue;
        pk_real largest = at < 0 ? PK_INFINITY : 0;
        for (size_t i = 0; at > 0 && i < m; i++) {
            const pk_real error = apart(exact, k, tried, j, i, scales[i]);
            found->columns[i] = error > found->columns[i] ? error : found->columns[i];
            if (!ignored[i] && error > largest)
                largest = error;
        }
        for (size_t i = 0; at < 0 && i < m; i++)
            found->columns[i] = PK_INFINITY;
        if (at > 0 && end > 0) {
            /* Of an event, which is known to errors. */
            const pk_real late = PK_F(fabs)(tried->t[j] - exact->t[k]) / end;
            largest = late > largest ? late : largest;
        }
        found->count++;
        held &= largest <= accuracy;
        if (held)
            found->holds = exact->t[k];
        if (largest > found->largest)
            found->largest = largest;
    }
    free(scales);
}

int rows_save(const struct rows *rows, const char *path)
{
    FILE *file = fopen(path, "wb");
    if (!file)
        return -1;
    for (size_t k = 0; k < rows->count; k++)
        for (size_t i = 0; i <= rows->columns; i++) {
            const pk_real x = i ? rows->x[k * rows->columns + i - 1] : rows->t[k];
            const double pair[2] = {(double)x, (double)(x - (pk_real)(double)x)};
            fwrite(pair, sizeof *pair, 2, file);
        }
    const int failed = ferror(file);
    return fclose(file) || failed ? -1 : 0;
}

int rows_load(struct rows *rows, const char *path, size_t columns)
{
    FILE *file = fopen(path, "rb");
    double pair[2];
    if (!file)
        return -1;
    rows_free(rows);
    rows->columns = columns;
    rows->stride = 1;
    size_t at = 0;
    for (; fread(pair, sizeof *pair, 2, file) == 2; at++) {
        const size_t i = at % (columns + 1);
        if (i == 0) {
            if (rows->count == rows->room) {
                grow(rows);
                rows->low = (double *)realloc(rows->low, rows->room * columns * sizeof(double));
                if (!rows->low)
                    break;
            }
            rows->t[rows->count++] = (pk_real)pair[0];
        } else {
            rows->x[(rows->count - 1) * columns + i - 1] = (pk_real)pair[0];
            rows->low[(rows->count - 1) * columns + i - 1] = pair[1];
        }
    }
    fclose(file);
    return at && at % (columns + 1) == 0 ? 0 : -1;
}
