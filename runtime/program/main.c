/* The program that `pkgen build` makes of a model: it reads options, runs the model by pk/run.h,
 * and writes rows and a report. It needs only the C library.
 *
 * Exit codes: those of enum pk_run_code. */
#define _POSIX_C_SOURCE 200809L

#include "program.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static volatile sig_atomic_t ended;

static void on_signal(int number)
{
    (void)number;
    ended = 1;
}

static int poll_signals(void *context, double part)
{
    const struct program *p = (const struct program *)context;
    if (p->shows)
        fprintf(stderr, "\r%3.0f %%", 100 * part);
    return ended;
}

static int help(const struct program *p)
{
    const struct pk_system *system = program_model.system;
    printf("usage: %s [options]\n\nIntegrates %s; rows go to standard output, words to standard "
           "error.\nNumbers are in SI; a unit behind one, \"2 [kg]\", is to be the one below.\n\n",
           p->name, system->name);
    options_help(stdout);
    static const char *const heads[] = {"parameters, by --set", "inputs, by --set",
                                        "coordinates, by --start", "rates, by --start"};
    const struct pk_quantity *const lists[] = {NULL, system->inputs, system->coordinates,
                                               system->rates};
    const size_t counts[] = {system->n_parameters, system->n_inputs,
                             system->families.count ? system->families.n_coordinates : system->n,
                             system->families.count ? system->families.n_coordinates : system->n};
    for (size_t k = 0; k < 4; k++) {
        printf(counts[k] ? "\n%s:" : "", heads[k]);
        for (size_t i = 0; i < counts[k]; i++) {
            const struct pk_quantity *q = k ? &lists[k][i] : &system->parameters[i].what;
            printf(" %s%s%s%s", q->name, *q->unit ? " [" : "", q->unit, *q->unit ? "]" : "");
        }
    }
    printf("\n");
    return 0;
}

/* Returns `path` with `end` appended; the caller frees it. */
static char *named(const char *path, const char *end)
{
    char *text = (char *)malloc(strlen(path) + strlen(end) + 1);
    return text ? strcat(strcpy(text, path), end) : NULL;
}

static int failed(const char *what, const char *path)
{
    fprintf(stderr, "run: cannot %s %s: %s\n", what, path, strerror(errno));
    return PK_RUN_USAGE;
}

/* Writes the report and the names and units of the columns to OUTPUT.json. */
static int write_side_file(struct program *p, struct pk_run *run)
{
    char *path = named(p->output, ".json");
    FILE *file = path ? fopen(path, "w") : NULL;
    int code = PK_RUN_DONE;
    if (file) {
        write_description(p, run, file);
        code = fclose(file) ? failed("write", path) : PK_RUN_DONE;
    } else {
        code = failed("write", path ? path : p->output);
    }
    free(path);
    return code;
}

static int go(struct program *p)
{
    const int binary = p->output && strcmp(p->output + strlen(p->output) - 4, ".npy") == 0;
    const char *const checkpoint = p->settings.checkpoint;
    char *partial = p->output ? named(p->output, ".partial") : NULL;
    int fd = p->json && !p->output ? -1 : STDOUT_FILENO;
    const int how = p->settings.resume ? O_RDWR : O_RDWR | O_CREAT | O_TRUNC;
    if (checkpoint && !p->settings.resume && access(checkpoint, F_OK) == 0) {
        fprintf(stderr, "run: %s is there: --resume goes on from it, remove it to begin anew\n",
                checkpoint);
        return PK_RUN_USAGE;
    }
    if (partial && !binary && (fd = open(partial, how, 0666)) < 0)
        return failed("write", partial);
    if (partial && !binary && p->settings.resume && lseek(fd, 0, SEEK_END) == 0) {
        fprintf(stderr, "run: the rows so far are not in %s any more\n", partial);
        return PK_RUN_USAGE;
    }
    p->settings.csv = binary ? -1 : fd;
    p->settings.poll = poll_signals;
    p->settings.context = p;
    p->shows = isatty(STDERR_FILENO);
    struct pk_run *run = pk_run_new(&program_model, &p->settings);
    int code = run ? (int)pk_run_go(run) : PK_RUN_FAILED;
    if (p->shows)
        fprintf(stderr, "\r     \r");
    for (const char *line = run ? pk_run_messages(run) : "out of memory\n"; *line;) {
        const int length = (int)strcspn(line, "\n");
        fprintf(stderr, "run: %.*s\n", length, line);
        line += length + (line[length] == '\n');
    }
    if (run && binary && code != PK_RUN_USAGE && code != PK_RUN_LEFT && write_npy(run, partial))
        code = failed("write", partial);
    const int over =
        run && (code == PK_RUN_DONE || (code == PK_RUN_FAILED && strlen(pk_run_report(run)) > 2));
    if (checkpoint && over) /* A run that has ended does not need its checkpoint any more. */
        remove(checkpoint);
    if (run && p->output && code != PK_RUN_USAGE && code != PK_RUN_LEFT) {
        const int whole = strstr(pk_run_report(run), "\"whole\": true") != NULL;
        if (whole && rename(partial, p->output))
            code = failed("write", p->output);
        if (!whole)
            fprintf(stderr, "run: rows as far as they came: %s\n", partial);
        code = write_side_file(p, run) ? PK_RUN_USAGE : code;
    } else if (partial && !checkpoint) {
        remove(partial);
    }
    if (run && p->json)
        write_description(p, run, stdout);
    else if (run)
        write_summary(run, stderr);
    pk_run_free(run);
    free(partial);
    return code;
}

int main(int argc, char **argv)
{
    static struct program program;
    struct program *p = &program;
    p->name = argv[0];
    p->settings = program_settings;
    const int read = options_read(p, argc, argv);
    if (read == OPTIONS_HELP)
        return help(p);
    if (read)
        return read;
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGTTOU, SIG_IGN);
    const int ends[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        if (signal(ends[i], on_signal) == SIG_IGN)
            signal(ends[i], SIG_IGN);
    const int code = p->shard ? shard_write(p) : go(p);
    options_free(p);
    return fflush(stdout) ? PK_RUN_USAGE : code;
}
