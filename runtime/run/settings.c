/* Reads the settings; see settings.h. Parameters first take their defaults, then those that were
 * given, and derive() lets the rest follow; the start is computed from them and then overridden.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>
#endif

enum { EXIT_USAGE = 2 };

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

static int usage(size_t line, const char *message, const char *word)
{
    fprintf(stderr, "run: settings line %zu: %s%s%s\n", line, message, word ? ": " : "",
            word ? word : "");
    return EXIT_USAGE;
}

static int parse_real(const char *word, pk_real *x)
{
    char *end = NULL;
    if (!word || !*word)
        return 0;
#ifdef PK_LONG_DOUBLE
    *x = strtold(word, &end);
#else
    *x = (pk_real)strtod(word, &end);
#endif
    return *end == '\0' && *x - *x == PK_C(0.0);
}

static int parse_index(const char *word, size_t count, size_t *index)
{
    char *end = NULL;
    if (!word || *word < '0' || *word > '9')
        return 0;
    const unsigned long long value = strtoull(word, &end, 10);
    *index = (size_t)value;
    return *end == '\0' && value < count;
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) {
        fprintf(stderr, "run: out of memory\n");
        exit(4);
    }
    return memory;
}

/* A member of a family of parameters, to be set again once defaults have followed. */
struct member {
    size_t index, position;
    pk_real x;
};

/* Sizes are known: memory for what depends on them, and the defaults. */
static void begin(struct settings *s, const struct pk_system *system)
{
    if (s->begun)
        return;
    s->begun = 1;
    if (system->attach) {
        const size_t bytes = system->block_size(s->params);
        s->params_block = allocate(bytes, 1);
        system->attach(s->params, s->params_block);
    }
    s->n = pk_system_count(system, s->params);
    s->q = (pk_real *)allocate(2 * s->n, sizeof *s->q);
    s->v = s->q + s->n;
    s->start_given = (unsigned char *)allocate(2 * s->n, 1);
    system->defaults(s->params);
}

static int set_size(struct settings *s, const struct pk_system *system, size_t line,
                    char *const word[])
{
    size_t index, value;
    if (s->begun || !parse_index(word[1], system->n_sizes, &index))
        return usage(line, s->begun ? "sizes come first" : "no such size", word[1]);
    if (!parse_index(word[2], PTRDIFF_MAX / 64, &value) || value == 0)
        return usage(line, "not a size", word[2]);
    const ptrdiff_t length = (ptrdiff_t)value;
    memcpy((char *)s->params + system->sizes[index].offset, &length, sizeof length);
    return 0;
}

static void set_member(struct settings *s, const struct pk_system *system,
                       const struct member *member)
{
    pk_real *values;
    memcpy(&values, (char *)s->params + system->parameters[member->index].offset, sizeof values);
    values[member->position] = member->x;
}

static int set_param(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[])
{
    struct pk_range range = {0, 1, 0};
    struct member member;
    if (!parse_index(word[1], system->n_parameters, &member.index))
        return usage(line, "no such parameter", word[1]);
    if (!parse_real(word[2], &member.x))
        return usage(line, "not a number", word[2]);
    if (system->range)
        system->range(s->params, 1, member.index, &range);
    s->given[member.index] = 1;
    if (!range.is_family) {
        memcpy((char *)s->params + system->parameters[member.index].offset, &member.x,
               sizeof member.x);
        return 0;
    }
    if (!parse_index(word[3], range.count, &member.position))
        return usage(line, "no such member", word[3]);
    struct member *more =
        (struct member *)realloc(s->members, (s->n_members + 1) * sizeof *more);
    if (!more)
        return usage(line, "out of memory", NULL);
    s->members = more;
    more[s->n_members++] = member;
    return 0;
}

/* Defaults that follow. Of a family of which some members are given, the others follow first. */
static void follow(struct settings *s, const struct pk_system *system)
{
    if (s->n_members) {
        unsigned char *whole = (unsigned char *)allocate(system->n_parameters, 1);
        memcpy(whole, s->given, system->n_parameters);
        for (size_t k = 0; k < s->n_members; k++)
            whole[s->members[k].index] = 0;
        system->derive(s->params, whole);
        free(whole);
        for (size_t k = 0; k < s->n_members; k++)
            set_member(s, system, &s->members[k]);
    }
    system->derive(s->params, s->given);
}

static int set_start(struct settings *s, size_t line, char *const word[])
{
    size_t index;
    pk_real x;
    const int rate = word[1] && strcmp(word[1], "v") == 0;
    if (!word[1] || (!rate && strcmp(word[1], "q") != 0))
        return usage(line, "start wants q or v", word[1]);
    if (!parse_index(word[2], s->n, &index))
        return usage(line, "no such coordinate", word[2]);
    if (!parse_real(word[3], &x))
        return usage(line, "not a number", word[3]);
    (rate ? s->v : s->q)[index] = x;
    s->start_given[rate ? s->n + index : index] = 1;
    return 0;
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
        if (!parse_real(word[1], table[i].x))
            return usage(line, "not a number", word[1]);
        if (*table[i].x < 0 || (!table[i].zero_too && !(*table[i].x > 0)))
            return usage(line, "must be positive", word[0]);
        s->has_rtol |= table[i].x == &s->options.rtol;
        s->has_atol |= table[i].x == &s->options.atol;
        return 0;
    }
    return usage(line, "unknown setting", word[0]);
}

static int set(struct settings *s, const struct pk_system *system, size_t line,
               char *const word[])
{
    size_t index;
    if (strcmp(word[0], "size") == 0)
        return set_size(s, system, line, word);
    if (strcmp(word[0], "param") == 0 || strcmp(word[0], "start") == 0)
        begin(s, system);
    if (strcmp(word[0], "param") == 0)
        return set_param(s, system, line, word);
    if (strcmp(word[0], "start") == 0)
        return set_start(s, line, word);
    if (strcmp(word[0], "input") == 0) {
        if (!parse_index(word[1], system->n_inputs, &index))
            return usage(line, "no such input", word[1]);
        return parse_real(word[2], &s->u[index]) ? 0 : usage(line, "not a number", word[2]);
    }
    if (!word[1])
        return usage(line, "a value is missing", word[0]);
    if (strcmp(word[0], "method") == 0) {
        s->method = run_method_find(word[1]);
        return s->method ? 0 : usage(line, "unknown method", word[1]);
    }
    if (strcmp(word[0], "iteration") == 0) {
        if (strcmp(word[1], "newton") != 0 && strcmp(word[1], "fixed") != 0)
            return usage(line, "iteration is newton or fixed", word[1]);
        s->options.iteration = word[1][0] == 'f' ? PK_FIXED_POINT : PK_NEWTON;
        return 0;
    }
    if (strcmp(word[0], "rows") == 0) {
        if (strcmp(word[1], "land") != 0 && strcmp(word[1], "dense") != 0)
            return usage(line, "rows is land or dense", word[1]);
        s->land = word[1][0] == 'l';
        return 0;
    }
    if (strcmp(word[0], "max_steps") == 0) {
        if (!parse_index(word[1], (size_t)-1, &index))
            return usage(line, "not a count", word[1]);
        s->options.max_steps = (unsigned long)index;
        return 0;
    }
    if (strcmp(word[0], "progress") == 0) {
        s->progress = word[1][0] == '1';
        return 0;
    }
    return set_number(s, system, line, word);
}

/* A line as up to four words; the path of `report` may hold blanks and is the rest of its line. */
static int set_line(struct settings *s, const struct pk_system *system, size_t line, char *text)
{
    char *word[5] = {NULL};
    text[strcspn(text, "\r\n")] = '\0';
    if (strncmp(text, "report ", 7) == 0) {
        free(s->report);
        s->report = (char *)allocate(strlen(text + 7) + 1, 1);
        strcpy(s->report, text + 7);
        return 0;
    }
    size_t count = 0;
    for (char *w = strtok(text, " \t"); w && count < 5; w = strtok(NULL, " \t"))
        word[count++] = w;
    if (count == 0)
        return 0;
    return count == 5 ? usage(line, "too many words", word[4]) : set(s, system, line, word);
}

static int finish(struct settings *s, const struct pk_system *system)
{
    begin(s, system);
    pk_real *q = (pk_real *)allocate(2 * s->n, sizeof *q), *v = q + s->n;
    follow(s, system);
    const int outside = system->prepare(s->params);
    if (outside) {
        if ((size_t)outside > system->n_parameters + 1)
            fprintf(stderr, "run: a size is too small\n");
        else if ((size_t)outside > system->n_parameters)
            fprintf(stderr, "run: what is computed from the parameters is not finite\n");
        else
            fprintf(stderr, "run: parameter %s is outside its bounds\n",
                    system->parameters[outside - 1].what.name);
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
    if (s->has_rtol && !s->has_atol)
        s->options.atol = s->options.rtol;
    if (!s->method)
        return usage(0, "no method", NULL);
    if (!(s->until > 0))
        return usage(0, "no until", NULL);
    return 0;
}

int settings_read(struct settings *s, const struct pk_system *system, FILE *file)
{
    char text[4096];
    int code = 0;
    memset(s, 0, sizeof *s);
    s->every = -1;
    s->land = -1;
    s->options = pk_options_default();
    s->params = allocate(1, system->params_size);
    s->given = (unsigned char *)allocate(system->n_parameters, 1);
    s->u = (pk_real *)allocate(system->n_inputs, sizeof *s->u);
    if (system->set_sizes)
        system->set_sizes(s->params);
    else
        begin(s, system);
    for (size_t line = 1; code == 0 && fgets(text, sizeof text, file); line++) {
        if (!strchr(text, '\n') && !feof(file))
            code = usage(line, "line too long", NULL);
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
    free(s->members);
    free(s->q);
    free(s->u);
    free(s->start_given);
    free(s->report);
}
