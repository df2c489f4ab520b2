/* Rows. CSV quotes a name that holds a comma, a quote or a blank (RFC 4180). */
#include "choose_rows.h"
#include "diagnose.h"
#include "diagnose_area.h"
#include "ensemble.h"
#include "expect.h"
#include "numbers.h"

#include <errno.h>
#include <math.h>
#include <string.h>

static void csv_name(FILE *file, const char *name)
{
    fputc(',', file);
    if (!strpbrk(name, ",\" \n")) {
        fputs(name, file);
        return;
    }
    fputc('"', file);
    for (; *name; name++) {
        if (*name == '"')
            fputc('"', file);
        fputc(*name, file);
    }
    fputc('"', file);
}

/* The states are the last of the rates; their integrals are nobody's. */
static size_t rows_coordinates(const struct run *run)
{
    return pk_system_coordinates(run->problem.system, run->settings.params);
}

void output_header(struct run *run, FILE *file)
{
    const struct pk_system *system = run->problem.system;
    const struct pk_quantity *const tables[] = {system->coordinates, system->rates};
    char name[128];
    if (run->settings.headless)
        return;
    if (run->settings.ensemble)
        fprintf(file, "%s,", run->settings.member_name ? run->settings.member_name : "member");
    fputc('t', file);
    for (size_t i = 0; i < run->settings.n_show; i++) {
        const struct shown *show = &run->settings.show[i];
        if (show->kind == 'q' || show->kind == 'v')
            pk_system_name(system, run->settings.params, tables[show->kind == 'v'], show->index,
                           name, sizeof name);
        csv_name(file, show->kind == 'o'   ? system->observed[show->index].name
                       : show->kind == 'z' ? system->quadratures[show->index].name
                       : show->kind == 'e' ? "energy"
                                           : name);
    }
    if (run->settings.n_show) {
        fputc('\n', file);
        return;
    }
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < (k ? run->settings.n : rows_coordinates(run)); i++) {
            pk_system_name(system, run->settings.params, tables[k], i, name, sizeof name);
            csv_name(file, name);
        }
    for (size_t i = 0; i < system->n_observed; i++)
        if (!expect_hides(&run->settings, i))
            csv_name(file, system->observed[i].name);
    for (size_t i = 0; i < system->n_quadratures; i++)
        csv_name(file, system->quadratures[i].name);
    fputs(system->energy ? ",energy\n" : "\n", file);
}

static int is_finite(pk_real x) { return x - x == PK_C(0.0); }

/* A number that is none has no sign. */
static void cell(FILE *file, pk_real x)
{
    fputc(',', file);
    if (isnan((double)x))
        fputs("nan", file);
    else
        numbers_write(file, (double)x);
}

pk_real output_value(const struct run *run, const struct shown *column, pk_real t,
                     const pk_real *q, const pk_real *v, const pk_real *z, const pk_real *out)
{
    const size_t i = column->index;
    switch (column->kind) {
    case 'q':
        return q[i];
    case 'v':
        return v[i];
    case 'o':
        return out[i];
    case 'z':
        return z[i];
    default:
        return run->problem.system->energy(run->settings.params, t, q, v, run->settings.u);
    }
}

/* The columns that were asked for; the name of the first that is not finite, or NULL. */
static const char *shown_row(struct run *run, FILE *file, pk_real t, const pk_real *q,
                             const pk_real *v, const pk_real *z, pk_real *out)
{
    const struct pk_system *system = run->problem.system;
    const struct settings *s = &run->settings;
    const char *bad = NULL;
    if (system->n_observed)
        system->observe(s->params, t, q, v, s->u, out);
    for (size_t i = 0; i < s->n_show; i++) {
        const struct shown *show = &s->show[i];
        const pk_real x = output_value(run, show, t, q, v, z, out);
        cell(file, x);
        if (!is_finite(x) && !bad)
            bad = show->kind == 'o' ? system->observed[show->index].name : "energy";
    }
    return bad;
}

static const char *whole_row(struct run *run, FILE *file, pk_real t, const pk_real *q,
                             const pk_real *v, const pk_real *z, pk_real *out)
{
    const struct pk_system *system = run->problem.system;
    const struct settings *s = &run->settings;
    const char *bad = NULL;
    for (size_t i = 0; i < rows_coordinates(run); i++)
        cell(file, q[i]);
    for (size_t i = 0; i < s->n; i++)
        cell(file, v[i]);
    if (system->n_observed)
        system->observe(s->params, t, q, v, s->u, out);
    for (size_t i = 0; i < system->n_observed; i++) {
        if (expect_hides(&run->settings, i))
            continue;
        cell(file, out[i]);
        if (!is_finite(out[i]) && !bad)
            bad = system->observed[i].name;
    }
    for (size_t i = 0; i < system->n_quadratures; i++)
        cell(file, z[i]);
    if (!system->energy)
        return bad;
    const pk_real energy = system->energy(s->params, t, q, v, s->u);
    cell(file, energy);
    return is_finite(energy) || bad ? bad : "energy";
}

/* The motion may be valid where what is computed from it is not: rows go on, the run says so. */
void output_row(struct run *run, FILE *file, pk_real t, const pk_real *q, const pk_real *v,
                const pk_real *z)
{
    pk_real *out = run->row + 2 * run->settings.n;
    if (run->kept) {
        rows_keep(run, t, q, v, z, out);
        return;
    }
    if (run->settings.ensemble)
        fprintf(file, "%ld,", ensemble_number(&run->settings, run->member));
    numbers_write(file, (double)t);
    const char *bad = (run->settings.n_show ? shown_row : whole_row)(run, file, t, q, v, z, out);
    fputc('\n', file);
    run->rows++;
    run->last_row = t;
    if (bad && run->bad_rows++ == 0) {
        run->not_finite = bad;
        run->bad_t = (double)t;
    }
    diagnose_row(run, t, q, v);
    if (!run->at_event)
        area_note(run, t, q, v);
    expect_row(run, t, q, v, z);
    if (ferror(file))
        run->write_failed = errno ? errno : EIO;
}
