/* Events of a run; see watch.h. */
#include "watch.h"

#include "../base/json.h"
#include "observer.h"

enum { FEW = 4 }; /* states, that say nothing: a stop at the event is one of them */

static void note(struct run *run, size_t event, const struct moment *at)
{
    struct crossed *crossed = &run->crossed[event];
    if (crossed->count < WATCH_TIMES)
        crossed->t[crossed->count] = at->t;
    crossed->count++;
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
                    run->problem.system->events.table[k].what.name, (double)WATCH_NOISE);
}

static void report_times(FILE *file, const struct crossed *crossed)
{
    fprintf(file, ", \"doubts\": %lu, \"count\": %lu, \"times\": [", crossed->doubts,
            crossed->count);
    for (unsigned long i = 0; i < crossed->count && i < WATCH_TIMES; i++) {
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
