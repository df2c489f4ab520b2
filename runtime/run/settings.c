/* Reads the settings; see settings.h. Parameters first take their defaults, then those that were
 * given, and derive() lets the rest follow; the start is computed from them and then overridden.
 */
#include <stdlib.h>
#include <string.h>

#include "apart.h"
#include "diagnose.h"
#include "ensemble.h"
#include "expect.h"
#include "words.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>
#endif

const struct pk_method *run_method_at(size_t index)
{
    size_t core = 0;
    while (pk_method_at(core))
        core++;
#ifdef PK_WITH_GSL
    if (index >= core)
        return pk_gsl_method_at(index - core);
#endif
    return pk_method_at(index);
}

const struct pk_method *run_method_find(const char *name)
{
    for (size_t i = 0; run_method_at(i); i++)
        if (strcmp(run_method_at(i)->name, name) == 0)
            return run_method_at(i);
    return NULL;
}

static int set_start(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[])
{
    static const char kinds[] = "qvz"; /* one behind the other in memory */
    size_t index;
    const char *kind = word[1] && word[1][0] && !word[1][1] ? strchr(kinds, word[1][0]) : NULL;
    if (!kind)
        return words_usage(line, "start wants q, v or z", word[1]);
    if (!words_index(word[2], *kind == 'z' ? system->n_quadratures : s->n, &index))
        return words_usage(line, "no such coordinate", word[2]);
    index += (size_t)(kind - kinds) * s->n;
    if (!words_real(word[3], &s->q[index]))
        return words_usage(line, "not a number", word[3]);
    s->start_given[index] = 1;
    return 0;
}

int settings_column(const struct settings *s, const struct pk_system *system, const char *word,
                    struct shown *column)
{
    const char kind = word ? word[0] : '\0';
    const size_t count = kind == 'q' || kind == 'v' ? s->n
                         : kind == 'o'              ? system->n_observed
                         : kind == 'z'              ? system->n_quadratures
                         : kind == 'e' && system->energy;
    column->kind = kind;
    return count && words_index(word + 1, count, &column->index);
}

static int set_show(struct settings *s, const struct pk_system *system, size_t line,
                    char *const word[])
{
    const struct {
        const char *name;
        size_t count;
    } table[] = {{"q", s->n},
                 {"v", s->n},
                 {"observed", system->n_observed},
                 {"z", system->n_quadratures},
                 {"energy", system->energy != NULL}};
    struct shown *more = (struct shown *)realloc(s->show, (s->n_show + 1) * sizeof *more);
    if (!more)
        return words_usage(line, "out of memory", NULL);
    s->show = more;
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        if (!word[1] || strcmp(word[1], table[i].name) != 0)
            continue;
        more[s->n_show].kind = table[i].name[0];
        more[s->n_show].index = 0;
        const int ok = table[i].name[0] == 'e'
                           ? table[i].count > 0
                           : words_index(word[2], table[i].count, &more[s->n_show].index);
        if (!ok)
            return words_usage(line, "no such column", word[2]);
        s->n_show++;
        return 0;
    }
    return words_usage(line, "show wants q, v, observed, z or energy", word[1]);
}

static int set_number(struct settings *s, const struct pk_system *system, size_t line,
                      char *const word[])
{
    const struct {
        const char *name;
        pk_real *x;
        int zero_too;
    } table[] = {{"until", &s->until, 0},         {"every", &s->every, 1},
                 {"step", &s->options.h, 0},      {"rtol", &s->options.rtol, 1},
                 {"atol", &s->options.atol, 1},   {"h_min", &s->options.h_min, 1},
                 {"h_max", &s->options.h_max, 1}, {"newton_tol", &s->options.newton_tol, 1}};
    (void)system;
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        if (strcmp(word[0], table[i].name) != 0)
            continue;
        if (!words_real(word[1], table[i].x))
            return words_usage(line, "not a number", word[1]);
        if (*table[i].x < 0 || (!table[i].zero_too && !(*table[i].x > 0)))
            return words_usage(line, "must be positive", word[0]);
        s->has_rtol |= table[i].x == &s->options.rtol;
        return 0;
    }
    return words_usage(line, "unknown setting", word[0]);
}

static int set(struct settings *s, const struct pk_system *system, size_t line,
               char *const word[])
{
    size_t index;
    int code;
    if (strcmp(word[0], "size") == 0)
        return settings_size(s, system, line, word);
    if (strcmp(word[0], "param") == 0 || strcmp(word[0], "start") == 0)
        settings_begin(s, system);
    if (strcmp(word[0], "param") == 0)
        return settings_param(s, system, line, word);
    if (strcmp(word[0], "start") == 0)
        return set_start(s, system, line, word);
    if (strcmp(word[0], "show") == 0)
        return settings_begin(s, system), set_show(s, system, line, word);
    if (strcmp(word[0], "at") == 0) {
        if (!words_index(word[1], system->n_events, &index))
            return words_usage(line, "no such event", word[1]);
        s->at = index + 1;
        return 0;
    }
    if (strcmp(word[0], "input") == 0) {
        if (!words_index(word[1], system->n_inputs, &index))
            return words_usage(line, "no such input", word[1]);
        return words_real(word[2], &s->u[index]) ? 0 : words_usage(line, "not a number", word[2]);
    }
    if (!word[1])
        return words_usage(line, "a value is missing", word[0]);
    if (strcmp(word[0], "watch") == 0) {
        s->watch = word[1][0] == 't' ? 2 : 1;
        return 0;
    }
    if (strcmp(word[0], "method") == 0) {
        s->method = run_method_find(word[1]);
        return s->method ? 0 : words_usage(line, "unknown method", word[1]);
    }
    if (strcmp(word[0], "iteration") == 0) {
        if (strcmp(word[1], "newton") != 0 && strcmp(word[1], "fixed") != 0)
            return words_usage(line, "iteration is newton or fixed", word[1]);
        s->options.iteration = word[1][0] == 'f' ? PK_FIXED_POINT : PK_NEWTON;
        return 0;
    }
    if (strcmp(word[0], "rows") == 0) {
        if (strcmp(word[1], "land") != 0 && strcmp(word[1], "dense") != 0)
            return words_usage(line, "rows is land or dense", word[1]);
        s->land = word[1][0] == 'l';
        return 0;
    }
    if (strcmp(word[0], "max_steps") == 0) {
        if (!words_index(word[1], (size_t)-1, &index))
            return words_usage(line, "not a count", word[1]);
        s->options.max_steps = (unsigned long)index;
        return 0;
    }
    if (strcmp(word[0], "diagnose") == 0) {
        s->diagnose |= diagnose_flag(word[1]);
        return diagnose_flag(word[1]) ? 0 : words_usage(line, "no such diagnostic", word[1]);
    }
    if (strcmp(word[0], "header") == 0) {
        s->headless = word[1][0] == '0';
        return 0;
    }
    if (strcmp(word[0], "progress") == 0) {
        s->progress = word[1][0] == '1';
        return 0;
    }
    if (strcmp(word[0], "part") == 0)
        return apart_setting(s, line, word);
    if (ensemble_setting(s, system, line, word, &code) ||
        expect_setting(s, system, line, word, &code))
        return code;
    return set_number(s, system, line, word);
}

enum { MOST_WORDS = 7 };

/* A line as words; a path may hold blanks and is the rest of its line. */
static int set_line(struct settings *s, const struct pk_system *system, size_t line, char *text)
{
    char *word[MOST_WORDS + 1] = {NULL};
    text[strcspn(text, "\r\n")] = '\0';
    if (strncmp(text, "report ", 7) == 0)
        return words_keep(&s->report, text + 7), 0;
    if (strncmp(text, "ensemble ", 9) == 0)
        return words_keep(&s->ensemble, text + 9), 0;
    size_t count = 0;
    for (char *w = strtok(text, " \t"); w && count <= MOST_WORDS; w = strtok(NULL, " \t"))
        word[count++] = w;
    if (count == 0)
        return 0;
    if (count > MOST_WORDS)
        return words_usage(line, "too many words", word[MOST_WORDS]);
    return set(s, system, line, word);
}

static int finish(struct settings *s, const struct pk_system *system)
{
    settings_begin(s, system);
    pk_real *q = (pk_real *)words_allocate(2 * s->n, sizeof *q), *v = q + s->n;
    settings_follow(s, system);
    const int outside = system->prepare(s->params);
    if (outside) {
        fputs((size_t)outside > system->n_parameters ? "run: " : "run: parameter ", stderr);
        parameters_refused(stderr, system, s->params, outside);
        fputc('\n', stderr);
        free(q);
        return EXIT_USAGE;
    }
    system->start(s->params, q, v);
    for (size_t i = 0; i < s->n; i++) {
        if (!s->start_given[i])
            s->q[i] = q[i];
        if (!s->start_given[s->n + i])
            s->v[i] = v[i];
    }
    free(q);
    if (!s->method)
        return words_usage(0, "no method", NULL);
    if (!(s->until > 0))
        return words_usage(0, "no until", NULL);
    return 0;
}

int settings_read(struct settings *s, const struct pk_system *system, FILE *file)
{
    char text[4096];
    int code = 0;
    memset(s, 0, sizeof *s);
    s->every = -1;
    s->land = -1;
    s->first_member = 1;
    s->options = pk_options_default();
    s->params = words_allocate(1, system->params_size);
    s->given = (unsigned char *)words_allocate(system->n_parameters, 1);
    s->u = (pk_real *)words_allocate(system->n_inputs, sizeof *s->u);
    if (system->set_sizes)
        system->set_sizes(s->params);
    else
        settings_begin(s, system);
    for (size_t line = 1; code == 0 && fgets(text, sizeof text, file); line++) {
        if (!strchr(text, '\n') && !feof(file))
            code = words_usage(line, "line too long", NULL);
        else
            code = set_line(s, system, line, text);
    }
    return code ? code : finish(s, system);
}

void settings_free(struct settings *s)
{
    free(s->params);
    free(s->given);
    free(s->params_block);
    free(s->set);
    free(s->q);
    free(s->u);
    free(s->start_given);
    free(s->report);
    free(s->ensemble);
    free(s->member_name);
    free(s->show);
    free(s->columns);
    expect_free(s);
    free(s->parts);
}

int settings_file(struct settings *s, const struct pk_system *system, const char *path)
{
    FILE *file = fopen(path, "r");
    if (!file) {
        fprintf(stderr, "run: cannot read %s\n", path);
        return 2;
    }
    const int code = settings_read(s, system, file);
    fclose(file);
    return code;
}
