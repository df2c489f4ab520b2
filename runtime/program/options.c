/* The options of `pkgen run`, for one model. */
#include "program.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static int usage(const char *option, const char *value, const char *why)
{
    fprintf(stderr, "run: %s%s%s: %s\n", option, value ? " " : "", value ? value : "", why);
    return PK_RUN_USAGE;
}

void options_free(struct program *p)
{
    for (size_t k = 0; k < p->n_lists; k++)
        free(p->lists[k]);
}

/* The lists in the settings to which options append values, by kind; see find_name(). */
static const struct list {
    char kind;
    size_t list, count; /* offsets of the list and of its length in struct pk_run_settings */
} assigned[] = {
#define PLACE(member) offsetof(struct pk_run_settings, member)
    {'p', PLACE(parameters), PLACE(n_parameters)},
    {'i', PLACE(inputs), PLACE(n_inputs)},
    {'q', PLACE(q), PLACE(n_q)},
    {'v', PLACE(v), PLACE(n_v)},
    {'s', PLACE(sizes), PLACE(n_sizes)},
};

/* Appends a value to a list. The scene's own list is constant, so it is copied first. */
static void add(struct program *p, const struct list *of, struct pk_run_value x)
{
    struct pk_run_value *list, *fixed;
    size_t count;
    memcpy(&list, (char *)&p->settings + of->list, sizeof list);
    memcpy(&fixed, (const char *)&program_settings + of->list, sizeof fixed);
    memcpy(&count, (char *)&p->settings + of->count, sizeof count);
    struct pk_run_value *more = keep(p, list == fixed ? NULL : list, (count + 1) * sizeof *more);
    if (list == fixed && count)
        memcpy(more, fixed, count * sizeof *more);
    more[count++] = x;
    memcpy((char *)&p->settings + of->list, &more, sizeof more);
    memcpy((char *)&p->settings + of->count, &count, sizeof count);
}

struct option {
    const char *name, *value, *help;
    int (*take)(struct program *p, const struct option *o, const char *text);
    /* offset of the number that the option sets in the settings, or of a text in struct program */
    size_t offset;
    const char *kinds; /* kinds of lists that assign() may append to; "0": count() takes 0 too */
};

/* Parses NAME=VALUE and appends the value to the list for that kind of name. */
static int assign(struct program *p, const struct option *o, const char *text)
{
    const char *equals = strchr(text, '='), *unit = "";
    struct pk_run_value x = {0, 0, 0};
    if (!equals)
        return usage(o->name, text, "give a name and a value");
    for (size_t k = 0; k < sizeof assigned / sizeof *assigned; k++) {
        const struct list *of = &assigned[k];
        if (!strchr(o->kinds, of->kind) ||
            !find_name(text, (size_t)(equals - text), of->kind, &x.index, &unit))
            continue;
        if (!read_number(equals + 1, unit, &x.value))
            return usage(o->name, text,
                         *unit ? "not a number in SI, nor with the unit that it has"
                               : "not a number");
        add(p, of, x);
        return 0;
    }
    return usage(o->name, text, "the model has no such name; see --help");
}

/* Parses the names of the columns: --record a,b,energy. */
static int record(struct program *p, const struct option *o, const char *text)
{
    struct pk_run_settings *s = &p->settings;
    struct pk_run_column *columns = NULL;
    const char *unit;
    size_t count = 0;
    for (const char *name = text; name; name = strchr(name, ',') ? strchr(name, ',') + 1 : NULL) {
        const size_t length = strcspn(name, ",");
        const char *kind = "qvo";
        struct pk_run_column c = {0, 0, 0};
        for (; *kind && !c.kind; kind++)
            if (find_name(name, length, *kind, &c.index, &unit))
                c.kind = *kind;
        if (!c.kind && length == 6 && strncmp(name, "energy", 6) == 0)
            c.kind = 'e';
        if (!c.kind)
            return usage(o->name, text, "the rows have no such column; see --help");
        columns = keep(p, columns, (count + 1) * sizeof *columns);
        columns[count++] = c;
    }
    s->columns = columns;
    s->n_columns = count;
    return 0;
}

static int diagnose(struct program *p, const struct option *o, const char *text)
{
    char name[64];
    for (const char *from = text; from; from = strchr(from, ',') ? strchr(from, ',') + 1 : NULL) {
        const size_t length = strcspn(from, ",");
        memcpy(name, from, length < 63 ? length : 63);
        name[length < 63 ? length : 63] = '\0';
        if (!pk_run_diagnostic(name))
            return usage(o->name, text, "there is no such diagnostic");
        if (strcmp(name, "modes") == 0)
            return usage(o->name, text, "modes are found by 'pkgen run', in Python");
        p->settings.diagnose |= pk_run_diagnostic(name);
    }
    return 0;
}

static int at(struct program *p, const struct option *o, const char *text)
{
    const char *unit;
    size_t index;
    if (!find_name(text, strlen(text), 'e', &index, &unit))
        return usage(o->name, text, "the model has no such event");
    p->settings.at = index + 1;
    return 0;
}

static int output(struct program *p, const struct option *o, const char *path)
{
    const size_t length = strlen(path);
    p->output = strcmp(path, "-") == 0 ? NULL : path;
    return !p->output || (length > 4 && (strcmp(path + length - 4, ".csv") == 0 ||
                                         strcmp(path + length - 4, ".npy") == 0))
               ? 0
               : usage(o->name, path, "the file's name must end in .csv or .npy");
}

static int number(struct program *p, const struct option *o, const char *text)
{
    double x;
    if (!read_number(text, strchr("THD", o->value[0]) ? "s" : "", &x) || !(x > 0))
        return usage(o->name, text, "not a positive number in SI");
    memcpy((char *)&p->settings + o->offset, &x, sizeof x);
    return 0;
}

static int count(struct program *p, const struct option *o, const char *text)
{
    char *end;
    const unsigned long x = strtoul(text, &end, 10);
    if (!isdigit((unsigned char)*text) || *end || (!x && !*o->kinds))
        return usage(o->name, text,
                     *o->kinds ? "not a whole number" : "not a positive whole number");
    /* The number in the settings may be a size_t, which has the same size as x. */
    memcpy((char *)&p->settings + o->offset, &x, sizeof x);
    return 0;
}

static int checkpoint(struct program *p, const struct option *o, const char *path)
{
    (void)o;
    p->settings.checkpoint = path;
    if (!(p->settings.checkpoint_every > 0))
        p->settings.checkpoint_every = 60;
    return 0;
}

static int table(struct program *p, const struct option *o, const char *path)
{
    (void)o;
    return table_read(p, path);
}

/* Sets a text of struct program. */
static int word(struct program *p, const struct option *o, const char *text)
{
    memcpy((char *)p + o->offset, &text, sizeof text);
    return 0;
}

static int first(struct program *p, const struct option *o, const char *text)
{
    char *end;
    p->first = strtoul(text, &end, 10);
    return isdigit((unsigned char)*text) && !*end ? 0 : usage(o->name, text, "not a whole number");
}

static int iteration(struct program *p, const struct option *o, const char *text)
{
    p->settings.fixed_point = strcmp(text, "fixed") == 0;
    return p->settings.fixed_point || strcmp(text, "newton") == 0
               ? 0
               : usage(o->name, text, "newton or fixed");
}

static const struct option options[] = {
    {"--set", "p=VALUE", "a parameter or input", assign, 0, "pi"},
    {"--start", "a=VALUE", "a coordinate or a rate", assign, 0, "qv"},
    {"--size", "N=64", "length of a family", assign, 0, "s"},
    {"--until", "T", "duration", number, PLACE(until), ""},
    {"--method", "NAME", "see pkgen methods", word, offsetof(struct program, settings.method), ""},
    {"--step", "H", "of a method with fixed steps; else the first step", number, PLACE(step), ""},
    {"--max-step", "H", "of an adaptive method", number, PLACE(h_max), ""},
    {"--rtol", "R", "of an adaptive method", number, PLACE(rtol), ""},
    {"--atol", "A", "default: R times the scale that the motion shows", number, PLACE(atol), ""},
    {"--every", "DT", "time between rows", number, PLACE(every), ""},
    {"--record", "a,b,energy", "only these columns, behind t", record, 0, ""},
    {"--at", "EVENT", "a row at each crossing", at, 0, ""},
    {"--ensemble", "FILE.csv", "a row a trajectory: parameters, starts, inputs", table, 0, ""},
    {"--threads", "N", "of an ensemble (default: all cores)", count, PLACE(threads), ""},
    {"--seed", "N", "of the noise", count, PLACE(seed), "0"},
    {"--iteration", "newton|fixed", "of implicit methods", iteration, 0, ""},
    {"--diagnose", "LIST", "as of pkgen run", diagnose, 0, ""},
    {"--max-steps", "N", "", count, PLACE(max_steps), ""},
    {"--shard", "JSON", "of a sweep: which shard it is", word, offsetof(struct program, shard), ""},
    {"--starts", "FILE", "its members, as doubles", word, offsetof(struct program, starts), ""},
    {"--first", "N", "the number of the first, from 0", first, 0, ""},
    {"--to", "FILE", "what comes of them", word, offsetof(struct program, to), ""},
    {"--checkpoint", "FILE", "where the run is kept, for --resume", checkpoint, 0, ""},
    {"--checkpoint-every", "T", "seconds between two", number, PLACE(checkpoint_every), ""},
    {"-o", "FILE", "FILE.csv or FILE.npy; default: standard output", output, 0, ""},
};

void options_help(FILE *file)
{
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        fprintf(file, "  %-18s %-10s %s\n", options[i].name, options[i].value, options[i].help);
    fputs("  --json                        the report as JSON\n"
          "  --resume                      go on from the checkpoint, with the same options\n"
          "  --help                        this, and the names of the model\n",
          file);
}

int options_read(struct program *p, int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i];
        const size_t length = strcspn(word, "=");
        const int joined = word[0] == '-' && word[1] == '-' && word[length] == '=';
        size_t k = 0;
        if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)
            return OPTIONS_HELP;
        if (strcmp(word, "--json") == 0) {
            p->json = 1;
            continue;
        }
        if (strcmp(word, "--resume") == 0) {
            p->settings.resume = 1;
            continue;
        }
        while (k < sizeof options / sizeof *options &&
               (strlen(options[k].name) != length || strncmp(options[k].name, word, length) != 0))
            k++;
        if (k == sizeof options / sizeof *options)
            return usage(word, NULL, "there is no such option; see --help");
        if (!joined && i + 1 == argc)
            return usage(word, NULL, "a value is missing");
        const int code = options[k].take(p, &options[k], joined ? word + length + 1 : argv[++i]);
        if (code)
            return code;
    }
    return p->settings.resume && !p->settings.checkpoint
               ? usage("--resume", NULL, "it goes on from --checkpoint FILE")
               : 0;
}
