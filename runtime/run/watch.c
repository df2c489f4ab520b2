/* Events of a run; see watch.h. */
#include "watch.h"

#include <stdlib.h>

enum { MOST_TIMES = 1000 }; /* of an event, in the report */

static int found(void *context, const struct pk_events *events)
{
    struct run *run = (struct run *)context;
    struct crossed *crossed = &run->crossed[events->which];
    if (crossed->count < MOST_TIMES)
        crossed->t[crossed->count] = events->t;
    crossed->count++;
    if (!run->settings.land && !run_dense_rows(run, events->t))
        return 1;
    if (run->settings.at == events->which + 1) {
        run->at_event = 1;
        output_row(run, stdout, events->t, events->q, events->v);
        run->at_event = 0;
    }
    return run->write_failed;
}

int watch_start(struct run *run)
{
    const size_t m = run->problem.system->n_events;
    const size_t size = pk_events_size(&run->problem, run->settings.method);
    if (m == 0)
        return 0;
    run->events_block = malloc(size);
    run->crossed = (struct crossed *)calloc(m, sizeof *run->crossed);
    int missing = !run->events_block || !run->crossed;
    for (size_t k = 0; !missing && k < m; k++) {
        run->crossed[k].t = (pk_real *)malloc(MOST_TIMES * sizeof(pk_real));
        missing = !run->crossed[k].t;
    }
    if (missing || pk_events_init(&run->events, &run->it, run->events_block, size) < 0) {
        fprintf(stderr, "run: out of memory\n");
        return 4;
    }
    run->events.found = found;
    run->events.context = run;
    return 0;
}

enum pk_status watch_step(struct run *run, pk_real limit)
{
    return run->crossed ? pk_events_step(&run->events, &run->it, limit)
                        : pk_integrator_step(&run->it, limit);
}

void watch_report(struct run *run, FILE *file)
{
    const struct pk_system *system = run->problem.system;
    fputs("  \"events\": [", file);
    for (size_t k = 0; run->crossed && k < system->n_events; k++) {
        const struct crossed *crossed = &run->crossed[k];
        fprintf(file, "%s\n    {\"name\": ", k ? "," : "");
        output_text(file, system->events[k].what.name);
        fprintf(file, ", \"stop\": %s, \"count\": %lu, \"times\": [",
                system->events[k].stop ? "true" : "false", crossed->count);
        for (unsigned long i = 0; i < crossed->count && i < MOST_TIMES; i++) {
            fputs(i ? ", " : "", file);
            output_real(file, crossed->t[i]);
        }
        fputs("]}", file);
    }
    fprintf(file, "],\n  \"event_tries\": %lu,\n", run->events.tries);
}

void watch_free(struct run *run)
{
    for (size_t k = 0; run->crossed && k < run->problem.system->n_events; k++)
        free(run->crossed[k].t);
    pk_events_free(&run->events);
    free(run->crossed);
    free(run->events_block);
}
