/* The spectrum of each coordinate and first-order variable, from the rows of a run. */

#include "parts.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>

static void spectrum_lines(struct pk_run *run, struct diagnostics *d, const struct pk_spectrum *s,
                           size_t i, size_t count, double dt)
{
    const size_t width = 1 + 2 * run->settings.n;
    struct json *j = &d->json;
    double away = 0, size = 0; /* `away`: largest |x - mean - rate t|; `size`: largest |x| */
    char name[128];
    for (size_t k = 0; k < count; k++) {
        const double x = d->rows[k * width + 1 + i];
        away = fmax(away, fabs(x - s->mean - s->rate * (double)k * dt));
        size = fmax(size, fabs(x));
    }
    const struct pk_system *system = run->problem.system;
    const size_t n = run->settings.n;
    pk_system_name(system, run->settings.params, i < n ? system->coordinates : system->rates,
                   i < n ? i : i - n, name, sizeof name);
    json_open(j, NULL, '{');
    json_text(j, "name", name);
    json_reals(j, {"mean", s->mean}, {"rate", s->rate}, {"residual", s->residual},
               {"away", size > 0 ? away / size : 0},
               {"drifts", size > 0 ? fabs(s->rate) * dt * (double)count / size : 0});
    json_open(j, "lines", '[');
    for (size_t k = 0; k < s->count; k++) {
        json_open(j, NULL, '{');
        json_reals(j, {"frequency", s->lines[k].frequency}, {"error", s->lines[k].error},
                   {"amplitude", s->lines[k].amplitude}, {"phase", s->lines[k].phase});
        json_close(j, '}');
    }
    json_close(j, ']');
    json_close(j, '}');
}

/* Returns the index in (q, v) of quantity i: coordinates first, then first-order variables. */
static size_t column(size_t i, size_t n, size_t seen) { return i < seen ? i : n + i; }

/* Uses rows at equal intervals: a last row after a shorter interval is dropped. */
void diagnose_spectrum(struct pk_run *run, struct diagnostics *d)
{
    const struct settings *set = &run->settings;
    const size_t n = set->n, width = 1 + 2 * n;
    const double dt = set->every > 0 ? set->every : set->options.h;
    size_t count = d->n_rows;
    if (count > 1 && d->rows[(count - 1) * width] < (double)(count - 1) * dt * (1 - 1e-12))
        count--;
    const int at_events = set->asked.at && !set->has_every;
    if (count < PK_SPECTRUM_LEAST || at_events) {
        char reason[200];
        if (at_events)
            snprintf(reason, sizeof reason,
                     "rows are at event %s alone: give --every too, for rows at equal times",
                     run->problem.system->events.table[set->asked.at - 1].what.name);
        else
            snprintf(reason, sizeof reason,
                     "%zu rows at equal times; at least %d are needed: --every", count,
                     (int)PK_SPECTRUM_LEAST);
        diagnose_told(d, PK_REFUSED, reason, NULL);
        return;
    }
    const size_t size = pk_gsl_spectrum_size(count);
    void *block = memory_take(&run->memory, size, 1);
    double *x = memory_take(&run->memory, count, sizeof *x);
    enum pk_status status = PK_DONE;
    struct pk_spectrum *found = memory_take(&run->memory, n, sizeof *found);
    const size_t seen = pk_system_coordinates(run->problem.system, set->params);
    for (size_t i = 0; i < n && status >= 0; i++) {
        for (size_t k = 0; k < count; k++)
            x[k] = d->rows[k * width + 1 + column(i, n, seen)];
        status = pk_gsl_spectrum(&found[i], x, count, dt, PK_LINES, block, size);
        if (run_stopped(run, (double)i / (double)n))
            break;
    }
    if (diagnose_told(d, status, NULL, NULL)) {
        struct json *j = &d->json;
        json_integer(j, "rows", count);
        json_reals(j, {"interval", dt}, {"nyquist", found[0].nyquist},
                   {"resolution", found[0].resolution});
        json_open(j, "coordinates", '[');
        for (size_t i = 0; i < n; i++)
            spectrum_lines(run, d, &found[i], column(i, n, seen), count, dt);
        json_close(j, ']');
    }
}
#else
DIAGNOSE_NEEDS_GSL(spectrum)
#endif
