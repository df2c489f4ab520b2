/* What `pkgen chart` measures of one model: how much a method at a step (or a tolerance) costs, and
 * where it ends. The settings come from a file (settings.h); then every line of standard input is
 * a request, and every line of standard output its answer, a JSON object:
 *
 *     point METHOD SETTING SECONDS CAP    one integration, then laps of it for SECONDS; given up
 *                                         after CAP seconds
 *     path METHOD SETTING COUNT CAP       the states at COUNT equal times
 *     jacobians METHOD SETTING COUNT CAP  and there da/dq and da/dv
 *     given                               parameters and start as they are in memory, so that the
 *                                         same model in another precision can have the same ones
 *
 * SETTING is a step, shortened so that a whole number of them makes the time to go, or for an
 * adaptive method rtol. The first integration of a point is the one whose counts and drifts
 * are told; it is watched at each step, and so not timed. A time is that of the fastest lap. All
 * times are by the processor's clock: what one on the wall shows where nothing else runs. Numbers
 * of more digits than a double's are told as a sum of two.
 */
#define _POSIX_C_SOURCE 200809L

#include "chart.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "ensemble.h"
#include "jacobians.h"
#include "numbers.h"
#include "words.h"

#define LAP_SECONDS 1e-3 /* so many runs that the clock's own cost is nothing */

struct chart {
    struct settings s;
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_system system; /* whose switches are located, and not its events */
    struct pk_events events;
    struct pk_monitor monitor;
    void *block, *events_block, *monitor_block;
    pk_real *work;
    double began, cap;
    int slow; /* given up at the cap */
};

static double processor_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static enum pk_status begin(struct chart *c, const struct pk_method *method, pk_real setting,
                            pk_real span)
{
    struct pk_options options = c->s.options;
    if (method->traits & PK_ADAPTIVE)
        options.h = 0, options.rtol = setting, options.atol = PK_ATOL_OF_MOTION;
    else
        options.h = span / run_intervals(span, setting);
    pk_integrator_free(&c->it);
    free(c->block);
    const size_t size = pk_integrator_size(&c->problem, method);
    c->block = words_allocate(size, 1);
    c->began = processor_now();
    c->slow = 0;
    const enum pk_status status = pk_integrator_init(&c->it, &c->problem, method, &options, 0,
                                                     c->s.q, c->s.v, c->block, size);
    if (status < 0)
        return status;
    const size_t events_size = pk_events_size(&c->problem, method);
    pk_events_free(&c->events);
    free(c->events_block);
    c->events_block = words_allocate(events_size, 1);
    return pk_events_init(&c->events, &c->it, c->events_block, events_size);
}

/* To t, watched at each step. 1 if it arrived. */
static int advance(struct chart *c, pk_real t, struct pk_monitor *monitor)
{
    struct pk_integrator *it = &c->it;
    while (it->t < t) {
        if (pk_events_step(&c->events, it, t) < 0)
            return 0;
        if (monitor)
            pk_monitor_update(monitor, it->t, it->q, it->v);
        if (processor_now() - c->began > c->cap) {
            c->slow = it->t < t;
            return !c->slow;
        }
    }
    return 1;
}

/* The fastest lap's seconds for one run; 0 if a run fails, as the first one did not. Laps are longer
 * until the clock shows them: under a limit of CPU time it goes by ticks of milliseconds. */
static double laps(struct chart *c, double seconds)
{
    struct pk_integrator *it = &c->it;
    unsigned long block = 1;
    double best = 0, total = 0;
    do {
        const double began = processor_now();
        for (unsigned long k = 0; k < block; k++)
            if (pk_integrator_reset(it, 0, c->s.q, c->s.v) < 0 ||
                (c->system.n_switches ? pk_events_to(&c->events, it, c->s.until)
                                      : pk_integrator_to(it, c->s.until)) < 0)
                return 0;
        const double took = processor_now() - began;
        total += took;
        if (took < LAP_SECONDS)
            block *= 2;
        else if (!(best > 0) || took < best * (double)block)
            best = took / (double)block;
    } while (!(best > 0) || total < seconds);
    return best;
}

static void print_end(const struct chart *c)
{
    const struct pk_integrator *it = &c->it;
    const struct pk_counters *k = &it->count;
    char reason[512] = "";
    pk_integrator_reason(it, reason, sizeof reason);
    printf("\"status\": \"%s\", \"slow\": %s, \"epsilon\": ", pk_status_name(it->status),
           c->slow ? "true" : "false");
    output_real(stdout, PK_EPSILON);
    fputs(", \"reason\": ", stdout);
    output_text(stdout, it->status < 0 ? reason : "");
    fputs(", \"t\": ", stdout);
    output_real(stdout, it->t);
    printf(", \"steps\": %lu, \"rejections\": %lu, \"evaluations\": %lu, \"jacobians\": %lu, "
           "\"factorisations\": %lu, \"iterations\": %lu",
           k->steps, k->rejections, k->evaluations, k->jacobians, k->factorisations,
           k->iterations);
}

static void print_drift(const char *name, const struct pk_drift *drift, const char **separator)
{
    printf("%s{\"name\": ", *separator);
    *separator = ", ";
    output_text(stdout, name);
    fputs(", \"max\": ", stdout);
    output_real(stdout, pk_drift_max(drift));
    fputs("}", stdout);
}

static void print_drifts(const struct chart *c)
{
    const struct pk_monitor *m = &c->monitor;
    const char *separator = "";
    fputs(", \"drifts\": [", stdout);
    if (m->has_energy)
        print_drift("energy", &m->energy, &separator);
    for (size_t i = 0; i < c->s.n; i++)
        if (run_model->cyclic && run_model->cyclic[i])
            print_drift(run_model->momenta[i].name, &m->momenta[i], &separator);
    for (size_t i = 0; i < run_model->n_conserved; i++)
        print_drift(run_model->conserved[i].name, &m->conserved[i], &separator);
    fputs("]", stdout);
}

static void point(struct chart *c, const struct pk_method *method, pk_real setting, double seconds)
{
    const size_t size = pk_monitor_size(&c->problem);
    double fastest = 0;
    pk_monitor_init(&c->monitor, &c->problem, c->monitor_block, size);
    int arrived = begin(c, method, setting, c->s.until) >= 0;
    if (arrived) {
        pk_monitor_update(&c->monitor, 0, c->it.q, c->it.v);
        arrived = advance(c, c->s.until, &c->monitor);
    }
    fputs("{", stdout);
    print_end(c);
    print_drifts(c);
    if (c->it.state) {
        numbers_pairs(stdout, "q", c->it.q, pk_system_coordinates(run_model, c->s.params));
        numbers_pairs(stdout, "v", c->it.v, c->s.n);
    }
    if (arrived)
        fastest = laps(c, seconds);
    fputs(", \"seconds\": ", stdout);
    output_real(stdout, fastest > 0 ? (pk_real)fastest : PK_INFINITY); /* or null */
    printf(", \"took\": %.6g}\n", processor_now() - c->began);
}

static void path(struct chart *c, const struct pk_method *method, pk_real setting, size_t count,
                 int linear)
{
    const size_t n = c->s.n;
    pk_real *a_q = linear ? (pk_real *)words_allocate(2 * n * n, sizeof *a_q) : NULL;
    int arrived = begin(c, method, setting, c->s.until / (pk_real)count) >= 0;
    fputs("{\"states\": [", stdout);
    for (size_t k = 0; arrived && k <= count; k++) {
        const pk_real t = k < count ? c->s.until * (pk_real)k / (pk_real)count : c->s.until;
        if (!(arrived = advance(c, t, NULL)))
            break;
        fputs(k ? ", {\"t\": " : "{\"t\": ", stdout);
        output_real(stdout, t);
        numbers_pairs(stdout, "q", c->it.q, n - run_model->n_states);
        numbers_pairs(stdout, "v", c->it.v, n);
        if (linear && jacobians_at(&c->problem, c->it.t, c->it.q, c->it.v, c->s.u, a_q,
                                   a_q + n * n, c->work)) {
            numbers_list(stdout, "a_q", a_q, n * n);
            numbers_list(stdout, "a_v", a_q + n * n, n * n);
        }
        fputs("}", stdout);
    }
    fputs("], ", stdout);
    print_end(c);
    fputs("}\n", stdout);
    free(a_q);
}

static int answer(struct chart *c, size_t line, char *text)
{
    char *word[6] = {NULL};
    pk_real setting, cap, seconds;
    size_t count = 0, times = 0;
    text[strcspn(text, "\r\n")] = '\0';
    for (char *w = strtok(text, " "); w && count < 6; w = strtok(NULL, " "))
        word[count++] = w;
    if (count == 1 && strcmp(word[0], "given") == 0) {
        settings_tell(&c->s, stdout);
        return fflush(stdout) || ferror(stdout) ? 2 : 0;
    }
    if (count != 5)
        return words_usage(line, "a request has five words", word[0]);
    const struct pk_method *method = run_method_find(word[1]);
    const int is_point = strcmp(word[0], "point") == 0;
    const int linear = strcmp(word[0], "jacobians") == 0;
    if (!is_point && !linear && strcmp(word[0], "path") != 0)
        return words_usage(line, "no such request", word[0]);
    if (!method)
        return words_usage(line, "unknown method", word[1]);
    if (!words_real(word[2], &setting) || !(setting > 0))
        return words_usage(line, "not a step or a tolerance", word[2]);
    if (is_point ? !words_real(word[3], &seconds) : !words_index(word[3], 1u << 20, &times) || !times)
        return words_usage(line, "not a number", word[3]);
    if (!words_real(word[4], &cap))
        return words_usage(line, "not a number", word[4]);
    c->cap = (double)cap;
    if (is_point)
        point(c, method, setting, (double)seconds);
    else
        path(c, method, setting, times, linear);
    return fflush(stdout) || ferror(stdout) ? 2 : 0;
}

int chart_run(const char *settings)
{
    static struct chart c;
    char text[4096];
    int code = settings_file(&c.s, run_model, settings);
    if (code == 0) {
        c.problem = settings_motion(&c.s);
        c.system = *c.problem.system;
        c.system.n_events = 0;
        c.problem.system = &c.system;
        c.monitor_block = words_allocate(pk_monitor_size(&c.problem), 1);
        c.work = (pk_real *)words_allocate(jacobians_size(&c.problem), sizeof *c.work);
    }
    for (size_t line = 1; code == 0 && fgets(text, sizeof text, stdin); line++)
        code = answer(&c, line, text);
    pk_events_free(&c.events);
    pk_integrator_free(&c.it);
    settings_free(&c.s);
    free(c.block);
    free(c.events_block);
    free(c.monitor_block);
    free(c.work);
    return code;
}
