/* The report of one trajectory. */
#include "report.h"

#include "base/json.h"
#include "look/rows.h"
#include "look/trust.h"
#include "steps/apart.h"
#include "steps/observe.h"

enum { MOST_LISTED = 10000 };

void report_run(struct run *run, FILE *file)
{
    const struct pk_integrator *it = &run->it;
    const struct pk_method *method = run->settings.method;
    const struct pk_counters *c = &it->count;
    char reason[640];

    fputs("{\n  \"model\": ", file);
    report_text(file, run->settings.system->name);
    fputs(",\n  \"source_hash\": ", file);
    report_text(file, run->settings.system->source_hash);
    trust_reason(run, reason, sizeof reason);
    fprintf(file, ",\n  \"status\": \"%s\",\n  \"code\": %d,\n  \"text\": ",
            run->beyond ? TRUST_BEYOND_NAME : pk_status_name(it->status),
            run->beyond ? TRUST_BEYOND_CODE : (int)it->status);
    report_text(file, run->beyond ? TRUST_BEYOND_TEXT : pk_status_text(it->status));
    fputs(",\n  \"reason\": ", file);
    report_text(file, reason);
    fputs(",\n  \"besides\": ", file); /* "; the energy ..." */
    report_text(file, run->besides && *run->besides ? run->besides + 2 : "");
    trust_warning(run, reason, sizeof reason);
    fputs(",\n  \"warning\": ", file);
    report_text(file, reason);
    fprintf(file, ",\n  \"interrupted\": %s,\n  \"whole\": %s,\n  \"t\": ",
            run->interrupted ? "true" : "false",
            it->status >= 0 && !run->beyond && rows_whole(run) ? "true" : "false");
    report_real(file, it->t);
    fputs(",\n  \"last_valid\": ", file);
    report_real(file, trust_last_valid(run));
    fputs(",\n  ", file);
    /* Of a large system the last row has them. */
    const size_t coordinates = it->n - run->problem.system->n_first_order;
    report_numbers(file, "q", it->q, it->n <= MOST_LISTED ? coordinates : 0);
    fputs(", ", file);
    report_numbers(file, "v", it->v, it->n <= MOST_LISTED ? it->n : 0);
    if (it->z) {
        fputs(", ", file);
        report_numbers(file, "z", it->z, run->problem.system->quadratures.n);
    }
    fprintf(file, ",\n  \"method\": \"%s\",\n  \"order\": %d,\n", method->name, method->order);
    fputs("  \"step\": ", file);
    if (method->traits & PK_ADAPTIVE || run->settings.n_parts)
        fputs("null", file);
    else
        report_real(file, run->settings.options.h);
    fputs(",\n  \"not_finite\": ", file);
    if (run->not_finite)
        report_text(file, run->not_finite);
    else
        fputs("null", file);
    fputs(",\n  \"step_min\": ", file);
    report_real(file, run->h_min);
    fputs(",\n  \"step_max\": ", file);
    report_real(file, run->h_max);
    fputs(",\n  \"rtol\": ", file);
    report_real(file, run->settings.options.rtol);
    fputs(",\n  \"atol\": ", file);
    if (run->settings.options.atol < 0) /* of the motion */
        fputs("null", file);
    else
        report_real(file, run->settings.options.atol);
    fprintf(file,
            ",\n  \"rows\": %lu,\n  \"steps\": %lu,\n  \"rejections\": %lu,\n"
            "  \"evaluations\": %lu,\n  \"jacobians\": %lu,\n  \"factorisations\": %lu,\n"
            "  \"iterations\": %lu,\n  \"held\": %lu,\n  \"seconds\": %.6g,\n"
            "  \"processor\": %.9g,\n  \"begun\": %s,\n  \"slow\": %s,\n",
            run->rows, c->steps, c->rejections, c->evaluations, c->jacobians, c->factorisations,
            c->iterations, c->held, run->seconds, run->processor, run->begun ? "true" : "false",
            run->control.slow ? "true" : "false");
    apart_report(run, file);
    observe_report(run, file);
    fputs("\n}\n", file);
}
