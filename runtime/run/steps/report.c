/* Writes the report of one trajectory. */
#include "steps.h"

enum { MOST_LISTED = 10000 };

static void report_motion(struct json *j, const struct pk_run *run)
{
    const struct pk_integrator *it = &run->it;
    /* The report omits the state of a large system, which the last row contains. */
    const int listed = it->n <= MOST_LISTED;
    json_reals(j, {"t", it->t}, {"last_valid", trust_last_valid(run)});
    json_numbers(j, "q", it->q, listed ? pk_coordinates_of(&run->problem) : 0);
    json_numbers(j, "v", it->v, listed ? it->n : 0);
}

static void report_work(struct json *j, const struct pk_run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_counters *c = &run->it.count;
    json_text(j, "method", s->method->name);
    /* If atol < 0, it is derived from the motion; the report then gives null. */
    json_reals(j, {"order", s->method->order},
               {"step", run_fixed(run) && !s->n_parts ? s->options.h : PK_INFINITY},
               {"step_min", run->h_min > 0 ? run->h_min : run->h_max}, {"step_max", run->h_max},
               {"rtol", s->options.rtol},
               {"atol", s->options.atol < 0 ? PK_INFINITY : s->options.atol});
    if (s->system->noise.n)
        json_integer(j, "seed", s->asked.seed);
    json_counts(j, {"rows", run->rows}, {"steps", c->steps}, {"rejections", c->rejections},
                {"evaluations", c->evaluations}, {"jacobians", c->jacobians},
                {"factorisations", c->factorisations}, {"iterations", c->iterations},
                {"held", c->held});
    json_reals(j, {"seconds", (pk_real)run->seconds}, {"processor", (pk_real)run->processor});
    json_flag(j, "begun", run->begun);
    json_flag(j, "slow", run->control.slow);
}

void report_run(struct pk_run *run, FILE *file)
{
    const enum pk_status status = run->it.status;
    struct json json = {.file = file}, *j = &json;
    char text[640];
    json_open(j, NULL, '{');
    json_texts(j, {"model", run->settings.system->name},
               {"source_hash", run->settings.system->source_hash},
               {"status", run->beyond ? TRUST_BEYOND_NAME : pk_status_name(status)});
    json_real(j, "code", run->beyond ? TRUST_BEYOND_CODE : (int)status);
    json_text(j, "text", run->beyond ? TRUST_BEYOND_TEXT : pk_status_text(status));
    trust_reason(run, text, sizeof text);
    /* `besides` begins with "; " */
    json_texts(j, {"reason", text},
               {"besides", run->besides && *run->besides ? run->besides + 2 : ""});
    trust_warning(run, text, sizeof text);
    json_text(j, "warning", text);
    json_flag(j, "interrupted", run->interrupted);
    json_flag(j, "whole", status >= 0 && !run->beyond && rows_complete(run));
    json_text(j, "not_finite", rows_not_finite(run, text, sizeof text));
    report_motion(j, run);
    report_work(j, run);
    subsystems_report(run, j);
    observe_report(run, j);
    json_close(j, '}');
}
