/* The report, and pieces of JSON, where a number that is not finite is null: it has no other word. */
#include "apart.h"
#include "diagnose.h"
#include "expect.h"
#include "numbers.h"
#include "trust.h"
#include "watch.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define LARGE PK_C(0.1) /* a drift, of its scale */

enum { MOST_LISTED = 10000 };

void output_text(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(file, "\\%c", c);
        else if (c < 0x20)
            fprintf(file, "\\u%04x", c);
        else
            fputc(c, file);
    }
    fputc('"', file);
}

void output_real(FILE *file, pk_real x)
{
    if (x - x == PK_C(0.0))
        numbers_write(file, (double)x);
    else
        fputs("null", file);
}

void output_numbers(FILE *file, const char *key, const pk_real *x, size_t count)
{
    fprintf(file, "\"%s\": [", key);
    for (size_t i = 0; x && i < count; i++) {
        fputs(i ? ", " : "", file);
        output_real(file, x[i]);
    }
    fputs("]", file);
}

void output_drift(FILE *file, const char *name, const struct pk_drift *drift)
{
    fputs("{\"name\": ", file);
    output_text(file, name);
    fputs(", \"max\": ", file);
    output_real(file, pk_drift_max(drift));
    fputs(", \"final\": ", file);
    output_real(file, pk_drift_final(drift));
    fputs(", \"slope\": ", file);
    output_real(file, pk_drift_slope(drift));
    /* What the three are relative to: where it is round-off, so is the drift. */
    fputs(", \"scale\": ", file);
    output_real(file, drift->scale);
    pk_real exponent, spread;
    const enum pk_growth growth = pk_drift_growth(drift, &exponent, &spread);
    fputs(", \"first\": ", file);
    output_real(file, drift->first);
    fputs(", \"exponent\": ", file);
    output_real(file, exponent);
    fputs(", \"spread\": ", file);
    output_real(file, spread);
    fputs(", \"growth\": ", file);
    /* That a drift grows no more does not make it small. */
    const int far = growth == PK_GROWTH_BOUNDED && pk_drift_max(drift) > LARGE;
    output_text(file, far ? "off by more than a tenth" : pk_growth_text(growth));
    fputs("}", file);
}

static void json_drifts(struct run *run, FILE *file)
{
    const struct pk_system *system = run->problem.system;
    const struct pk_monitor *m = &run->monitor;
    int first = 1;
    /* Of what is constant: the energy, momenta of cyclic coordinates, the author's claims. */
    fputs("  \"drifts\": [", file);
    if (m->has_energy) {
        output_drift(file, "energy", &m->energy);
        first = 0;
    }
    for (size_t i = 0; m->momenta && i < run->settings.n; i++)
        if (system->cyclic && system->cyclic[i]) {
            fputs(first ? "" : ", ", file);
            first = 0;
            output_drift(file, system->momenta[i].name, &m->momenta[i]);
        }
    for (size_t i = 0; m->conserved && i < system->n_conserved; i++) {
        fputs(first ? "" : ", ", file);
        first = 0;
        output_drift(file, system->conserved[i].name, &m->conserved[i]);
    }
    fputs("]", file);
    diagnose_report(run, file);
    fputs("\n}\n", file);
}

static void json_run(struct run *run, FILE *file)
{
    const struct pk_integrator *it = &run->it;
    const struct pk_method *method = run->settings.method;
    const struct pk_counters *c = &it->count;
    char reason[640];

    fputs("{\n  \"model\": ", file);
    output_text(file, run->problem.system->name);
    fputs(",\n  \"source_hash\": ", file);
    output_text(file, run->problem.system->source_hash);
    trust_reason(run, reason, sizeof reason);
    fprintf(file, ",\n  \"status\": \"%s\",\n  \"code\": %d,\n  \"text\": ",
            run->beyond ? TRUST_BEYOND_NAME : pk_status_name(it->status),
            run->beyond ? TRUST_BEYOND_CODE : (int)it->status);
    output_text(file, run->beyond ? TRUST_BEYOND_TEXT : pk_status_text(it->status));
    fputs(",\n  \"reason\": ", file);
    output_text(file, reason);
    fputs(",\n  \"besides\": ", file); /* "; the energy ..." */
    output_text(file, run->besides && *run->besides ? run->besides + 2 : "");
    trust_warning(run, reason, sizeof reason);
    fputs(",\n  \"warning\": ", file);
    output_text(file, reason);
    fprintf(file, ",\n  \"interrupted\": %s,\n  \"whole\": %s,\n  \"t\": ",
            run->interrupted ? "true" : "false",
            it->status >= 0 && !run->beyond && output_whole(run) ? "true" : "false");
    output_real(file, it->t);
    fputs(",\n  \"last_valid\": ", file);
    output_real(file, trust_last_valid(run));
    fputs(",\n  ", file);
    /* Of a large system the last row has them. */
    const size_t coordinates = it->n - run->problem.system->n_states;
    output_numbers(file, "q", it->q, it->n <= MOST_LISTED ? coordinates : 0);
    fputs(", ", file);
    output_numbers(file, "v", it->v, it->n <= MOST_LISTED ? it->n : 0);
    if (it->z) {
        fputs(", ", file);
        output_numbers(file, "z", it->z, run->problem.system->n_quadratures);
    }
    fprintf(file, ",\n  \"method\": \"%s\",\n  \"order\": %d,\n", method->name, method->order);
    fputs("  \"step\": ", file);
    if (method->traits & PK_ADAPTIVE || run_parts)
        fputs("null", file);
    else
        output_real(file, run->settings.options.h);
    fputs(",\n  \"not_finite\": ", file);
    if (run->not_finite)
        output_text(file, run->not_finite);
    else
        fputs("null", file);
    fputs(",\n  \"step_min\": ", file);
    output_real(file, run->h_min);
    fputs(",\n  \"step_max\": ", file);
    output_real(file, run->h_max);
    fputs(",\n  \"rtol\": ", file);
    output_real(file, run->settings.options.rtol);
    fputs(",\n  \"atol\": ", file);
    if (run->settings.options.atol < 0) /* of the motion */
        fputs("null", file);
    else
        output_real(file, run->settings.options.atol);
    fprintf(file,
            ",\n  \"rows\": %lu,\n  \"steps\": %lu,\n  \"rejections\": %lu,\n"
            "  \"evaluations\": %lu,\n  \"jacobians\": %lu,\n  \"factorisations\": %lu,\n"
            "  \"iterations\": %lu,\n  \"held\": %lu,\n  \"seconds\": %.6g,\n",
            run->rows, c->steps, c->rejections, c->evaluations, c->jacobians, c->factorisations,
            c->iterations, c->held, run->seconds);
    watch_report(run, file);
    expect_report(run, file);
    apart_report(run, file);
    json_drifts(run, file);
}

int output_whole(const struct run *run) { return !run->interrupted && !run->write_failed; }

FILE *output_begin(const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file)
        fprintf(stderr, "run: cannot write %s: %s\n", path, strerror(errno));
    return file;
}

int output_end(FILE *file, const char *path)
{
    errno = 0;
    const int failed = ferror(file);
    if (!fclose(file) && !failed)
        return 0;
    fprintf(stderr, "run: cannot write %s: %s\n", path, strerror(errno ? errno : EIO));
    remove(path);
    return 1;
}

int output_rows_end(struct run *run, int code)
{
    errno = 0;
    if (!run->write_failed && (fflush(stdout) || ferror(stdout)))
        run->write_failed = errno ? errno : EIO;
    if (!run->write_failed)
        return code;
    if (run->write_failed != EPIPE)
        fprintf(stderr, "run: cannot write rows: %s\n", strerror(run->write_failed));
    return run->write_failed == EPIPE ? code : 2;
}

int output_report(struct run *run, const char *path)
{
    FILE *file = output_begin(path);
    if (!file)
        return 1;
    json_run(run, file);
    return output_end(file, path);
}
