/* Computes the columns of rows, and writes rows as CSV or keeps them in memory. Names in CSV with a
 * comma, quote, blank or newline are quoted (RFC 4180). */
#include <pk/constraint.h>

#include "observers.h"

#include "../base/numbers.h"
#include "../settings/settings.h"

#define LOST PK_C(1e-3)
#define ROUNDING (8 * PK_EPSILON)

static void begin(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    run->row = memory_take(&run->memory, 2 * s->n + pk_system_outputs(system, s->params) + 1,
                           sizeof *run->row);
    run->cells = memory_take(&run->memory, run_width(run), sizeof *run->cells);
}

static void csv_name(FILE *file, const char *name)
{
    const int quoted = strpbrk(name, ",\" \n") != NULL;
    fputs(quoted ? "\"" : "", file);
    for (; *name; name++)
        fprintf(file, *name == '"' ? "\"%c" : "%c", *name);
    fputs(quoted ? "\"" : "", file);
}

/* Sets `name` to the name of an output or to "energy". */
static void name_of(const struct pk_run *run, const struct pk_run_column *column, char *name,
                    size_t size)
{
    const struct settings *s = &run->settings;
    if (column->kind == 'o')
        pk_system_output_name(s->system, s->params, column->index, name, size);
    else
        snprintf(name, size, "energy");
}

int pk_run_column_name(const struct pk_run *of, size_t i, char *name, size_t size,
                       const char **unit)
{
    const struct settings *s = &of->settings;
    const struct pk_system *system = s->system;
    const size_t before = 1 + (s->asked.members > 0);
    const int dimensionless = !system->n || !*system->rates[0].unit;
    *unit = "";
    if (i < before) {
        *unit = i + 1 == before && !dimensionless ? "s" : "";
        snprintf(name, size, "%s", i + 1 == before ? "t" : s->asked.member_name);
        return 1;
    }
    if (i - before >= s->n_show)
        return 0;
    const struct pk_run_column *show = &s->show[i - before];
    const struct pk_quantity *const places = show->kind == 'v' ? system->rates
                                                               : system->coordinates;
    if (show->kind == 'e' || show->kind == 'o') {
        *unit = show->kind == 'e'            ? dimensionless ? "" : "J"
                : system->families.n_outputs ? ""
                                             : system->observed[show->index].unit;
        name_of(of, show, name, size);
    } else {
        pk_system_name(system, s->params, places, show->index, name, size);
        *unit = system->families.count ? "" : places[show->index].unit;
    }
    return 1;
}

void rows_header(struct pk_run *run)
{
    char name[128];
    const char *unit;
    if (!run->out || !run->settings.asked.header)
        return;
    for (size_t i = 0; pk_run_column_name(run, i, name, sizeof name, &unit); i++) {
        fputs(i ? "," : "", run->out);
        csv_name(run->out, name);
    }
    fputc('\n', run->out);
}

pk_real rows_value(const struct pk_run *run, const struct pk_run_column *column,
                   const struct moment *at, const pk_real *out)
{
    const size_t i = column->index;
    switch (column->kind) {
    case 'q':
        return at->q[i];
    case 'v':
        return at->v[i];
    case 'o':
        return out[i];
    default:
        return run->settings.system->energy(run->settings.params, at->t, at->q, at->v,
                                            run->settings.u);
    }
}

/* Sets an output to NaN if round-off of the state changes it by more than the fraction LOST of its
 * value. Accelerations and constraint forces are such where constraints become dependent. */
static void lose(struct pk_run *run, const struct moment *at, pk_real *out)
{
    const struct settings *s = &run->settings;
    const size_t n = s->n, m = pk_system_outputs(s->system, s->params);
    const struct pk_run_column *found = NULL;
    pk_real *q = memory_ask(&run->memory, 2 * n + m, sizeof *q), *v = q + n, *near = v + n;
    if (!q)
        return;
    for (size_t i = 0; i < n; i++) {
        const pk_real by = (i % 2 ? 1 : -1) * ROUNDING * (pk_real)(i + 1) / (pk_real)n;
        q[i] = at->q[i] * (1 + by);
        v[i] = at->v[i] * (1 - by);
    }
    s->system->observe(s->params, at->t, q, v, s->u, near);
    for (size_t i = 0; i < m; i++) {
        const pk_real moved = PK_F(fabs)(near[i] - out[i]);
        if (moved <= LOST * PK_F(fabs)(out[i]) || moved <= PK_F(sqrt)(PK_EPSILON))
            continue;
        out[i] = (pk_real)NAN;
        for (size_t k = 0; k < s->n_show && !found; k++)
            if (s->show[k].kind == 'o' && s->show[k].index == i)
                found = &s->show[k];
    }
    memory_drop(&run->memory, q);
    if (found && run->lost_rows++ == 0) {
        run->lost = found;
        run->lost_t = (double)at->t;
    }
}

const struct pk_run_column *rows_fill(struct pk_run *run, const struct moment *at)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    const struct pk_run_column *bad = NULL;
    pk_real *out = run->row + 2 * s->n;
    refresh_inputs(s, at->t, at->q, at->v);
    if (system->n_observed)
        system->observe(s->params, at->t, at->q, at->v, s->u, out);
    const int singular = system->n_observed && system->constraints.n &&
                         pk_constraint_singular(&run->it, at->t, at->q, at->v);
    if (singular)
        lose(run, at, out);
    pk_real *cell = run->cells;
    if (s->asked.members)
        *cell++ = (pk_real)member_number(s, run->member);
    *cell++ = at->t;
    for (size_t i = 0; i < s->n_show; i++) {
        const struct pk_run_column *show = &s->show[i];
        const pk_real x = *cell++ = rows_value(run, show, at, out);
        if (!(x - x == PK_C(0.0)) && !bad && !(singular && show->kind == 'o'))
            bad = show;
    }
    return bad;
}

static void write_csv(struct pk_run *run)
{
    for (size_t i = 0; i < run_width(run); i++) {
        if (i)
            fputc(',', run->out);
        numbers_write(run->out, (double)run->cells[i]);
    }
    fputc('\n', run->out);
    if (ferror(run->out))
        run->write_failed = errno ? errno : EIO;
}

static void grow(struct pk_run *run, size_t more)
{
    const size_t count = run->n_kept + more, size = run_width(run) * sizeof(double);
    size_t room = run->room;
    run->kept = memory_room(&run->memory, run->kept, count, &room, size);
    if (sizeof(pk_real) > sizeof(double))
        run->kept_low = memory_room(&run->memory, run->kept_low, count, &run->room, size);
    run->room = room;
}

static void keep(struct pk_run *run)
{
    grow(run, 1);
    const size_t width = run_width(run), at = run->n_kept++ * width;
    for (size_t i = 0; i < width; i++) {
        const pk_real x = run->cells[i];
        run->kept[at + i] = (double)x;
        if (run->kept_low)
            run->kept_low[at + i] = (double)(x - (pk_real)(double)x);
    }
}

void rows_take(struct pk_run *run, const struct pk_run *from)
{
    const size_t width = run_width(run), bytes = from->n_kept * width * sizeof *run->kept;
    if (!from->n_kept)
        return;
    grow(run, from->n_kept);
    memcpy(run->kept + run->n_kept * width, from->kept, bytes);
    if (run->kept_low)
        memcpy(run->kept_low + run->n_kept * width, from->kept_low, bytes);
    run->n_kept += from->n_kept;
}

/* An output may be not finite although the motion is valid, so the run continues and reports it. */
static void write_row(struct pk_run *run, const struct moment *at)
{
    const int none = run->settings.asked.no_rows;
    const struct pk_run_column *bad = none && !run->reduces_rows ? NULL : rows_fill(run, at);
    if (!none)
        (run->out ? write_csv : keep)(run);
    run->rows++;
    run->last_row = at->t;
    if (bad && run->bad_rows++ == 0) {
        run->not_finite = bad;
        run->bad_t = (double)at->t;
    }
}

/* Saves or restores a pointer to a column as 1 + its index, or 0 for NULL. */
static void keep_column(struct pk_run *run, struct pk_keep *k, const struct pk_run_column **column)
{
    const struct settings *s = &run->settings;
    size_t number = *column ? 1 + (size_t)(*column - s->show) : 0;
    PK_KEEP(k, number);
    k->wrong |= number > s->n_show;
    *column = number && !k->wrong ? &s->show[number - 1] : NULL;
}

/* Saves or restores the rows kept in memory; rows in a file are not saved. */
static void keep_all(struct pk_run *run, struct pk_keep *k)
{
    const size_t size = run_width(run) * sizeof(double), had = run->n_kept;
    size_t count = had;
    PK_KEEP(k, count);
    if (k->from && !k->wrong && count > had) {
        k->wrong |= count > (k->size - k->used) / size;
        if (!k->wrong)
            grow(run, count - had);
    }
    run->n_kept = k->wrong ? had : count;
    pk_keep(k, run->kept, run->n_kept * size);
    if (run->kept_low)
        pk_keep(k, run->kept_low, run->n_kept * size);
    PK_KEEP(k, run->rows);
    PK_KEEP(k, run->last_row);
    PK_KEEP(k, run->bad_t);
    PK_KEEP(k, run->bad_rows);
    PK_KEEP(k, run->lost_t);
    PK_KEEP(k, run->lost_rows);
    keep_column(run, k, &run->not_finite);
    keep_column(run, k, &run->lost);
}

const struct observer rows_observer = {.begin = begin, .row = write_row, .keep = keep_all};

enum pk_run_code rows_end(struct pk_run *run, enum pk_run_code code)
{
    errno = 0;
    if (run->out && !run->write_failed && (fflush(run->out) || ferror(run->out)))
        run->write_failed = errno ? errno : EIO;
    if (!run->write_failed)
        return code;
    if (run->write_failed != EPIPE)
        run_say(run, "cannot write rows: %s", strerror(run->write_failed));
    return run->write_failed == EPIPE ? code : PK_RUN_USAGE;
}

enum pk_run_code rows_told(struct pk_run *run, enum pk_run_code code)
{
    char name[128];
    if (run->lost) {
        name_of(run, run->lost, name, sizeof name);
        run_say(run,
                "warning: %s is lost to rounding, and nan, in %lu of %lu rows, first at t = %.9g: "
                "constraints depend on each other there",
                name, run->lost_rows, run->rows, run->lost_t);
    }
    if (run->not_finite) {
        name_of(run, run->not_finite, name, sizeof name);
        run_say(run, "%s is not finite in %lu of %lu rows, first at t = %.17g", name, run->bad_rows,
                run->rows, run->bad_t);
        code = code ? code : PK_RUN_FAILED;
    }
    return run->write_failed ? PK_RUN_USAGE : code;
}

const char *rows_not_finite(const struct pk_run *run, char *name, size_t size)
{
    if (!run->not_finite)
        return NULL;
    name_of(run, run->not_finite, name, size);
    return name;
}

int rows_complete(const struct pk_run *run) { return !run->interrupted && !run->write_failed; }
