/* Records and reports the crossings of events and switches; an observer. */
#include "observers.h"

enum { FEW = 4 }; /* An event function evaluated at no more than FEW states is not judged. */

static void note(struct pk_run *run, size_t event, const struct moment *at)
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

/* Returns whether an event is of contacts alone, which report what it does: its name begins with a
 * digit. */
static int is_hidden(const struct pk_system *system, size_t k)
{
    return k < system->events.n && *watch_name(system, k) <= '9';
}

/* Returns the run's integrator, or that of block k; NULL if k is behind the last one. */
static const struct pk_integrator *integrator(const struct pk_run *run, size_t k)
{
    if (run->settings.n_parts)
        return k < run->subsystems.count && run->subsystems.parts ? &run->subsystems.parts[k].it
                                                                  : NULL;
    return k == 0 ? &run->it : NULL;
}

static void warn_of_short_forces(struct pk_run *run)
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

void watch_warn(struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    warn_of_short_forces(run);
    for (size_t k = 0; run->crossed && k < system->events.n + system->switches.n; k++)
        if (run->crossed[k].doubts)
            run_say(run, "warning: %s %s: from t = %.9g on %s",
                    k < system->events.n ? "event" : "switch", watch_name(system, k),
                    (double)run->crossed[k].doubtful_t, WATCH_TOO_OFTEN);
    for (size_t k = 0; run->crossed && k < system->events.n; k++)
        if (run->crossed[k].count && !run->crossed[k].leaves && run->crossed[k].states > FEW &&
            !is_hidden(system, k))
            run_say(run,
                    "event %s: its function stays within %g of zero, beside what it is made "
                    "of: its crossings may be no more than errors",
                    system->events.table[k].what.name, (double)WATCH_NOISE);
}

/* Writes `count` events or switches, the first with index `from`, and their crossing times. */
static void report_kind(const struct pk_run *run, struct json *j, const char *key, size_t from,
                        size_t count)
{
    const struct pk_system *system = run->problem.system;
    json_open(j, key, '[');
    for (size_t k = from; run->crossed && k < from + count; k++) {
        const struct crossed *crossed = &run->crossed[k];
        if (is_hidden(system, k))
            continue;
        json_open(j, NULL, '{');
        json_text(j, "name", watch_name(system, k));
        if (k < system->events.n)
            json_flag(j, "stop", system->events.table[k].stop);
        if (k < system->events.n && system->events.table[k].stop > 1)
            json_flag(j, "limit", 1);
        json_counts(j, {"doubts", crossed->doubts}, {"count", crossed->count});
        json_numbers(j, "times", crossed->t,
                     crossed->count < WATCH_TIMES ? crossed->count : WATCH_TIMES);
        json_close(j, '}');
    }
    json_close(j, ']');
}

static void report(const struct pk_run *run, struct json *j)
{
    const struct pk_system *system = run->problem.system;
    const struct pk_integrator *it;
    report_kind(run, j, "events", 0, system->events.n);
    report_kind(run, j, "switches", system->events.n, system->switches.n);
    json_open(j, "contacts", '[');
    for (size_t k = 0; run->acts && k < system->contacts.n; k++) {
        const struct pk_contact_seen *seen = &run->actor.seen[k];
        if (system->contacts.table[k].kind == PK_FRICTION)
            continue;
        json_open(j, NULL, '{');
        json_text(j, "name", system->contacts.table[k].name);
        json_reals(j, {"impacts", seen->impacts}, {"lost", seen->lost}, {"rests", seen->rests},
                   {"grazes", seen->grazes});
        json_close(j, '}');
    }
    json_close(j, ']');
    json_integer(j, "event_tries", run->events.tries);
    json_open(j, "passed_over", '[');
    for (size_t k = 0; (it = integrator(run, k)) != NULL; k++) {
        if (!it->passed_over.count)
            continue;
        json_open(j, NULL, '{');
        json_text(j, "name", it->problem.system->marks.names[it->passed_over.which].name);
        json_integer(j, "steps", it->passed_over.count);
        json_real(j, "t", it->passed_over.t);
        json_close(j, '}');
    }
    json_close(j, ']');
}

static void keep(struct pk_run *run, struct pk_keep *k)
{
    const struct pk_system *system = run->problem.system;
    for (size_t i = 0; run->crossed && i < system->events.n + system->switches.n; i++) {
        struct crossed *crossed = &run->crossed[i];
        pk_real *const times = crossed->t;
        crossed->t = NULL;
        PK_KEEP(k, *crossed);
        crossed->t = times;
        pk_keep(k, times, WATCH_TIMES * sizeof *times);
    }
}

const struct observer watch_observer = {.event = note, .report = report, .keep = keep};
