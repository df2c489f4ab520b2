/* The spectrum of each coordinate and first-order variable, from the rows of a run. */

#include "parts.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>

static void lines(struct diagnostics *d, const struct pk_spectrum *s, const double *x, size_t i,
                  size_t count, double dt)
{
    const struct settings *set = &d->run->settings;
    struct json *j = &d->json;
    double away = 0, size = 0; /* `away`: largest |x - mean - rate t|; `size`: largest |x| */
    char name[128];
    for (size_t k = 0; k < count; k++) {
        away = fmax(away, fabs(x[k] - s->mean - s->rate * (double)k * dt));
        size = fmax(size, fabs(x[k]));
    }
    pk_system_name(set->system, set->params,
                   i < set->n ? set->system->coordinates : set->system->rates,
                   i < set->n ? i : i - set->n, name, sizeof name);
    json_open(j, NULL, '{');
    json_text(j, "name", name);
    json_reals(j, {"mean", s->mean}, {"rate", s->rate}, {"residual", s->residual},
               {"away", size > 0 ? away / size : 0},
               {"drifts", size > 0 ? fabs(s->rate) * dt * (double)count / size : 0});
    json_open(j, "lines", '[');
    for (size_t k = 0; k < s->count; k++)
        json_object(j, NULL, {"frequency", s->lines[k].frequency}, {"error", s->lines[k].error},
                    {"amplitude", s->lines[k].amplitude}, {"phase", s->lines[k].phase});
    json_close(j, ']');
    json_close(j, '}');
}

/* Uses rows at equal intervals: a last row after a shorter interval is dropped. */
void diagnose_spectrum(struct diagnostics *d)
{
    const struct settings *set = &d->run->settings;
    const size_t n = set->n, width = 1 + 2 * n, seen = settings_coordinates(set);
    const double dt = set->every > 0 ? set->every : set->options.h;
    const int at_events = set->asked.at && !set->has_every;
    struct json *j = &d->json;
    enum pk_status status = PK_DONE;
    char reason[200];
    size_t count = d->n_rows;
    if (count > 1 && d->rows[(count - 1) * width] < (double)(count - 1) * dt * (1 - 1e-12))
        count--;
    if (at_events)
        snprintf(reason, sizeof reason,
                 "rows are at event %s alone: give --every too, for rows at equal times",
                 set->system->events.table[set->asked.at - 1].what.name);
    else
        snprintf(reason, sizeof reason, "%zu rows at equal times; at least %d are needed: --every",
                 count, (int)PK_SPECTRUM_LEAST);
    if (count < PK_SPECTRUM_LEAST || at_events) {
        diagnose_told(d, PK_REFUSED, reason, NULL);
        return;
    }
    double *x = memory_take(&d->run->memory, n * count, sizeof *x);
    struct pk_spectrum *found = memory_take(&d->run->memory, n, sizeof *found);
    for (size_t i = 0; i < n && status >= 0; i++) {
        for (size_t k = 0; k < count; k++) /* coordinates, then first-order variables */
            x[i * count + k] = d->rows[k * width + 1 + (i < seen ? i : n + i)];
        status = pk_gsl_spectrum(&found[i], x + i * count, count, dt, PK_LINES);
        if (run_stopped(d->run, (double)i / (double)n))
            break;
    }
    if (!diagnose_told(d, status, NULL, NULL))
        return;
    json_integer(j, "rows", count);
    json_reals(j, {"interval", dt}, {"nyquist", found[0].nyquist},
               {"resolution", found[0].resolution});
    json_open(j, "coordinates", '[');
    for (size_t i = 0; i < n; i++)
        lines(d, &found[i], x + i * count, i < seen ? i : n + i, count, dt);
    json_close(j, ']');
}
#else
DIAGNOSE_NEEDS_GSL(spectrum)
#endif
