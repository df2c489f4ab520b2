/* What `accuracy` has to know of one scene: what methods at settings come to, as `pkgen run` makes
 * them, rows and all. The scene's settings come from a file (settings.h); then every line of
 * standard input is a request, and every line of standard output its answer, a JSON object:
 *
 *     try METHOD SETTING ROWS SPAN LAPS CAP ACCURACY EVERY MAX_STEP
 *               one run up to SPAN, its rows kept in place of being written; SETTING is a step or
 *               rtol; ROWS is land or dense; EVERY the time between rows, 0 that of the scene;
 *               MAX_STEP bounds adaptive steps, 0: as the scene's settings do. Then runs again for LAPS seconds, of which the fastest is told; given up after CAP
 *               seconds. Where there are exact rows, how far it is from these, and until when it
 *               holds ACCURACY
 *     exact     the rows of the last run are exact from now on; whether they are the start and the
 *               end, for want of crossings to have rows at
 *     ignore N  column N of the rows does not count
 *     save PATH, load PATH    exact rows to and from a file, of another precision too
 *     given     parameters and start as they are in memory
 *
 * All times are by the processor's clock.
 */
#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE

#include "choose.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>

#include "choose_rows.h"
#include "ensemble.h"
#include "expect.h"
#include "numbers.h"
#include "trust.h"
#include "words.h"

struct choice {
    struct settings s; /* as they were read */
    struct run run;
    struct rows exact, tried;
    unsigned char *ignored;
    pk_real *columns; /* work: an error for each */
    double seconds;
};

/* Of the only thread: where a timer runs, Linux tells the process's by its ticks. */
static double processor_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void on_cap(int number)
{
    (void)number;
    run_interrupt(1);
}

/* Interrupts what runs after so many seconds; 0: no more. */
static void cap(double seconds)
{
    struct itimerval timer = {{0, 0}, {0, 0}};
    timer.it_value.tv_sec = (time_t)seconds;
    timer.it_value.tv_usec = (suseconds_t)(1e6 * (seconds - (double)timer.it_value.tv_sec));
    if (seconds > 0 && timer.it_value.tv_sec == 0 && timer.it_value.tv_usec == 0)
        timer.it_value.tv_usec = 1;
    setitimer(ITIMER_PROF, &timer, NULL);
}

struct trial {
    const struct pk_method *method;
    pk_real setting, span, accuracy, laps, cap, every, max_step;
    int land;
};

/* One run; 0 where it could not begin. */
static int once(struct choice *c, const struct trial *trial)
{
    struct run *run = &c->run;
    struct settings *s = &run->settings;
    run_free(run);
    memset(run, 0, sizeof *run);
    *s = c->s;
    s->method = trial->method;
    s->until = trial->span;
    if (trial->every > 0)
        s->every = trial->every;
    s->land = trial->land;
    s->progress = 0;
    s->diagnose = 0;
    if (s->method->traits & PK_ADAPTIVE)
        s->options.rtol = trial->setting, s->options.atol = PK_ATOL_OF_MOTION, s->options.h = 0;
    else
        s->options.h = trial->setting;
    if (trial->max_step > 0 && !(s->options.h_max > 0 && s->options.h_max <= trial->max_step))
        s->options.h_max = trial->max_step;
    rows_clear(&c->tried);
    run->kept = &c->tried;
    expect_begin(run);
    const double began = processor_now();
    const int able = run_settle(run) == 0 && run_begin(run) == 0;
    if (able)
        run_rows(run);
    c->seconds = processor_now() - began;
    if (able)
        rows_keep_ends(run);
    return able;
}

static void print_end(const struct choice *c, int able)
{
    const struct pk_integrator *it = &c->run.it;
    const struct pk_counters *k = &it->count;
    char reason[512] = "";
    if (it->method)
        trust_reason(&c->run, reason, sizeof reason);
    printf("{\"able\": %s, \"status\": \"%s\", \"slow\": %s, \"reason\": ",
           able ? "true" : "false", pk_status_name(it->status),
           c->run.interrupted ? "true" : "false");
    output_text(stdout, it->status < 0 ? reason : "");
    fputs(", \"t\": ", stdout);
    output_real(stdout, it->t);
    fputs(", \"setting\": ", stdout);
    output_real(stdout, c->run.settings.method->traits & PK_ADAPTIVE ? c->run.settings.options.rtol
                                                                     : c->run.settings.options.h);
    printf(", \"steps\": %lu, \"evaluations\": %lu, \"held\": %lu, \"rows\": %zu", k->steps,
           k->evaluations, k->held, c->tried.count);
}

static void print_difference(struct choice *c, pk_real accuracy)
{
    struct difference d;
    d.columns = c->columns;
    rows_compare(&c->exact, &c->tried, accuracy, c->ignored, &d);
    printf(", \"compared\": %zu, \"error\": ", d.count);
    output_real(stdout, d.largest);
    fputs(", \"holds\": ", stdout);
    output_real(stdout, d.holds);
    numbers_list(stdout, "columns", d.columns, c->exact.columns);
}

static void try(struct choice *c, const struct trial *trial)
{
    double fastest, total;
    run_interrupt(0);
    cap((double)trial->cap);
    const int able = once(c, trial);
    cap(0);
    fastest = total = c->seconds;
    print_end(c, able);
    const int arrived = able && c->run.it.status >= 0 && !c->run.interrupted;
    if (c->exact.count)
        print_difference(c, trial->accuracy);
    while (arrived && total < (double)trial->laps) {
        once(c, trial);
        total += c->seconds;
        fastest = c->seconds < fastest ? c->seconds : fastest;
    }
    printf(", \"arrived\": %s, \"seconds\": %.9g, \"took\": %.6g}\n", arrived ? "true" : "false",
           fastest, total);
}

static void make_exact(struct choice *c)
{
    const struct rows exact = c->exact;
    c->exact = c->tried;
    c->tried = exact;
    free(c->tried.low);
    c->tried.low = NULL;
    printf("{\"rows\": %zu, \"without\": %s, \"scales\": [", c->exact.count,
           c->exact.without ? "true" : "false");
    for (size_t i = 0; i < c->exact.columns; i++) {
        fputs(i ? ", " : "", stdout);
        output_real(stdout, rows_scale(&c->exact, i));
    }
    fputs("]}\n", stdout);
}

static int read_trial(size_t line, char *const word[], struct trial *trial)
{
    pk_real *const numbers[] = {&trial->setting, NULL,        &trial->span,    &trial->laps,
                                &trial->cap,     &trial->accuracy, &trial->every,
                                &trial->max_step};
    trial->method = run_method_find(word[1]);
    if (!trial->method)
        return words_usage(line, "unknown method", word[1]);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (numbers[i] && !words_real(word[2 + i], numbers[i]))
            return words_usage(line, "not a number", word[2 + i]);
    if (!(trial->setting > 0) || !(trial->span > 0))
        return words_usage(line, "must be positive", word[2]);
    trial->land = word[3][0] == 'l';
    return 0;
}

static int answer(struct choice *c, size_t line, char *text)
{
    char *word[10] = {NULL};
    size_t count = 0, index;
    struct trial trial;
    text[strcspn(text, "\r\n")] = '\0';
    for (char *w = strtok(text, " "); w && count < 10; w = strtok(NULL, " "))
        word[count++] = w;
    if (count == 10 && strcmp(word[0], "try") == 0) {
        const int code = read_trial(line, word, &trial);
        if (code)
            return code;
        try(c, &trial);
    } else if (count == 1 && strcmp(word[0], "exact") == 0) {
        make_exact(c);
    } else if (count == 1 && strcmp(word[0], "given") == 0) {
        settings_tell(&c->s, stdout);
    } else if (count == 2 && strcmp(word[0], "ignore") == 0) {
        if (!words_index(word[1], rows_columns(&c->s), &index))
            return words_usage(line, "no such column", word[1]);
        c->ignored[index] = 1;
        fputs("{}\n", stdout);
    } else if (count == 2 && (strcmp(word[0], "save") == 0 || strcmp(word[0], "load") == 0)) {
        if (word[0][0] == 's' ? rows_save(&c->exact, word[1])
                              : rows_load(&c->exact, word[1], rows_columns(&c->s)))
            return words_usage(line, "cannot be written or read", word[1]);
        c->exact.by_number = c->s.at != 0;
        printf("{\"rows\": %zu}\n", c->exact.count);
    } else {
        return words_usage(line, "no such request", word[0]);
    }
    return fflush(stdout) || ferror(stdout) ? 2 : 0;
}

int choose_run(const char *settings)
{
    static struct choice c;
    char text[4096];
    int code = settings_file(&c.s, run_model, settings);
    if (code == 0) {
        c.ignored = (unsigned char *)words_allocate(rows_columns(&c.s), 1);
        c.columns = (pk_real *)words_allocate(rows_columns(&c.s), sizeof *c.columns);
    }
    signal(SIGPROF, on_cap);
    for (size_t line = 1; code == 0 && fgets(text, sizeof text, stdin); line++)
        code = answer(&c, line, text);
    run_free(&c.run);
    rows_free(&c.exact);
    rows_free(&c.tried);
    settings_free(&c.s);
    free(c.ignored);
    free(c.columns);
    return code;
}
