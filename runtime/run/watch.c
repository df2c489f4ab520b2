/* Events of a run; see watch.h. */
#include "watch.h"

#include "observe.h"

#include <string.h>

enum { MOST_TIMES = 1000 }; /* of an event, in the report */
enum { FEW = 4 };           /* states, that say nothing: a stop at the event is one of them */
#define NOISE PK_C(1e-8)    /* of the size of what is subtracted: no more than errors */

static void note_time(struct crossed *crossed, pk_real t)
{
    if (crossed->count < MOST_TIMES)
        crossed->t[crossed->count] = t;
    crossed->count++;
}

/* The step is about to be ended here, and with it its dense output. */
static void switched(void *context, const struct pk_events *events)
{
    struct run *run = (struct run *)context;
    note_time(&run->crossed[run->problem.system->events.n + events->which], events->t);
    run_due(run, events->t);
}

static void note(struct run *run, size_t event, const struct moment *at)
{
    note_time(&run->crossed[event], at->t);
}

static int found(void *context, const struct pk_events *events)
{
    struct run *run = (struct run *)context;
    const struct moment at = {events->t, events->q, events->v, events->z};
    observe_crossing(run, events->which, &at);
    if (!run_due(run, events->t))
        return 1;
    if (run->settings.at == events->which + 1) {
        run->at_event = 1;
        observe_row(run, &at);
        run->at_event = 0;
    }
    return run->write_failed;
}

static void doubtful(void *context, const struct pk_events *events)
{
    struct crossed *crossed = &((struct run *)context)->crossed[events->which];
    if (crossed->doubts++ == 0)
        crossed->doubtful_t = events->t;
}

enum pk_run_code watch_begin(struct run *run)
{
    const struct pk_system *system = run->problem.system;
    const size_t m = system->events.n, all = m + system->switches.n;
    const size_t size = pk_events_size(&run->problem, run->settings.method);
    if (all == 0)
        return PK_RUN_DONE;
    struct memory *memory = &run->memory;
    run->crossed = (struct crossed *)memory_take(memory, all, sizeof *run->crossed);
    run->event_values =
        (pk_real *)memory_take(memory, 2 * m + 2 * run->it.n, sizeof *run->event_values);
    for (size_t k = 0; k < all; k++)
        run->crossed[k].t = (pk_real *)memory_take(memory, MOST_TIMES, sizeof(pk_real));
    const enum pk_status status =
        pk_events_init(&run->events, &run->it, memory_take(memory, size, 1), size);
    if (status < 0) {
        run_say(run, "events: %s", pk_status_text(status));
        return PK_RUN_FAILED;
    }
    run->events.found = found;
    run->events.switched = switched;
    run->events.doubtful = doubtful;
    run->events.context = run;
    return PK_RUN_DONE;
}

/* A function that is zero but for errors, as that of a constant of the motion, crosses zero by
 * these errors alone. It is seen by what each coordinate and rate contributes to it: |dg/dx| |x|.
 */
static void note_leaving(struct run *run)
{
    const struct pk_system *system = run->problem.system;
    const size_t n = run->it.n, m = system->events.n;
    const pk_real t = run->it.t, *u = run->settings.u;
    pk_real *g = run->event_values, *moved = g + m, *x = moved + m;
    int all = 1;
    for (size_t k = 0; k < m; k++)
        all &= run->crossed[k].leaves;
    if (all) /* or there are switches alone */
        return;
    memcpy(x, run->it.q, n * sizeof *x);
    memcpy(x + n, run->it.v, n * sizeof *x);
    system->events.values(run->settings.params, t, x, x + n, u, g);
    for (size_t i = 0; i < 2 * n; i++) {
        const pk_real was = x[i], part = PK_C(1e-4);
        x[i] += part * was;
        system->events.values(run->settings.params, t, x, x + n, u, moved);
        x[i] = was;
        for (size_t k = 0; k < m; k++)
            run->crossed[k].parts =
                PK_F(fmax)(run->crossed[k].parts, PK_F(fabs)(moved[k] - g[k]) / part);
    }
    for (size_t k = 0; k < m; k++) {
        run->crossed[k].states++;
        run->crossed[k].leaves |= PK_F(fabs)(g[k]) > NOISE * run->crossed[k].parts;
    }
}

enum pk_status watch_step(struct run *run, pk_real limit)
{
    if (!run->crossed)
        return pk_integrator_step(&run->it, limit);
    const enum pk_status status = pk_events_step(&run->events, &run->it, limit);
    if (status >= 0)
        note_leaving(run);
    return status;
}

const char *watch_name(const struct pk_system *system, size_t k)
{
    return k < system->events.n ? system->events.table[k].what.name
                                : system->switches.names[k - system->events.n].name;
}

/* The integrator of the run, or those of its parts; NULL behind the last. */
static const struct pk_integrator *integrator(const struct run *run, size_t k)
{
    if (run->settings.n_parts)
        return k < run->apart.count && run->apart.parts ? &run->apart.parts[k].it : NULL;
    return k == 0 ? &run->it : NULL;
}

static void warn_of_short_forces(struct run *run)
{
    const struct pk_integrator *it;
    for (size_t k = 0; (it = integrator(run, k)) != NULL; k++)
        if (it->passed_over.count)
            run_say(run,
                    "warning: %s: from t = %.9g on steps are too long for what it does within "
                    "them (%lu of them), it may be missed: take shorter ones (--step), or an "
                    "adaptive method",
                    it->problem.system->marks.names[it->passed_over.which].name,
                    (double)it->passed_over.t, it->passed_over.count);
}

void watch_warn(struct run *run)
{
    const struct pk_system *system = run->problem.system;
    warn_of_short_forces(run);
    for (size_t k = 0; run->crossed && k < system->events.n + system->switches.n; k++)
        if (run->crossed[k].doubts)
            run_say(run, "warning: %s %s: from t = %.9g on %s",
                    k < system->events.n ? "event" : "switch", watch_name(system, k),
                    (double)run->crossed[k].doubtful_t, WATCH_TOO_OFTEN);
    for (size_t k = 0; run->crossed && k < run->problem.system->events.n; k++)
        if (run->crossed[k].count && !run->crossed[k].leaves && run->crossed[k].states > FEW)
            run_say(run,
                    "event %s: its function stays within %g of zero, beside what it is made "
                    "of: its crossings may be no more than errors",
                    run->problem.system->events.table[k].what.name, (double)NOISE);
}

static void report_times(FILE *file, const struct crossed *crossed)
{
    fprintf(file, ", \"doubts\": %lu, \"count\": %lu, \"times\": [", crossed->doubts,
            crossed->count);
    for (unsigned long i = 0; i < crossed->count && i < MOST_TIMES; i++) {
        fputs(i ? ", " : "", file);
        report_real(file, crossed->t[i]);
    }
    fputs("]}", file);
}

static void report(const struct run *run, FILE *file)
{
    const struct pk_system *system = run->problem.system;
    fputs("  \"events\": [", file);
    for (size_t k = 0; run->crossed && k < system->events.n; k++) {
        fprintf(file, "%s\n    {\"name\": ", k ? "," : "");
        report_text(file, system->events.table[k].what.name);
        fprintf(file, ", \"stop\": %s", system->events.table[k].stop ? "true" : "false");
        report_times(file, &run->crossed[k]);
    }
    fputs("],\n  \"switches\": [", file);
    for (size_t k = 0; run->crossed && k < system->switches.n; k++) {
        fprintf(file, "%s\n    {\"name\": ", k ? "," : "");
        report_text(file, system->switches.names[k].name);
        report_times(file, &run->crossed[system->events.n + k]);
    }
    fprintf(file, "],\n  \"event_tries\": %lu,\n  \"passed_over\": [", run->events.tries);
    const struct pk_integrator *it;
    unsigned long listed = 0;
    for (size_t k = 0; (it = integrator(run, k)) != NULL; k++) {
        if (!it->passed_over.count)
            continue;
        fputs(listed++ ? ", {\"name\": " : "{\"name\": ", file);
        report_text(file, it->problem.system->marks.names[it->passed_over.which].name);
        fprintf(file, ", \"steps\": %lu, \"t\": ", it->passed_over.count);
        report_real(file, it->passed_over.t);
        fputs("}", file);
    }
    fputs("],\n", file);
}

const struct observer watch_observer = {.event = note, .report = report};
