/* Expectations of a scene; see expect.h. */
#include "expect.h"

#include <stdlib.h>
#include <string.h>

#include "ensemble.h"
#include "words.h"

/* What is off by the most so far: above 0 it is a miss, and no number is one as well. */
static void compare(struct run *run, struct expected *x, pk_real t, pk_real a, pk_real b,
                    pk_real within)
{
    const pk_real d = x->relation == '>' ? b - a : a - b;
    const pk_real off = x->relation == '=' ? PK_F(fabs)(d) - within : d;
    const int met = x->relation == '=' ? off <= 0 : off < 0;
    const int worse = x->count == 0 || !(off <= x->off); /* true of no number */
    x->count++;
    x->missed += !met;
    if (!worse || !(x->off - x->off == PK_C(0.0)))
        return;
    x->off = off;
    x->value = a;
    x->bound = b;
    x->allowed = within;
    x->t = t;
    x->member = run->member;
}

static const pk_real *outputs(struct run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    const struct settings *s = &run->settings;
    if (run_model->n_observed)
        run_model->observe(s->params, t, q, v, s->u, run->expected);
    return run->expected;
}

/* Round-off of a time that a step was to end at. */
static int is_at(const struct run *run, pk_real t, pk_real at)
{
    return PK_F(fabs)(t - at) <= 8 * PK_EPSILON * run->settings.until;
}

pk_real expect_limit(const struct run *run, pk_real t, pk_real limit)
{
    pk_real next = limit;
    for (size_t i = 0; i < run->settings.n_expected; i++) {
        const struct expected *x = &run->settings.expected[i];
        if (x->when == 't' && x->at < next && x->at > t && !is_at(run, t, x->at) &&
            !is_at(run, limit, x->at))
            next = x->at;
    }
    return next;
}

/* Those of a kind, and of that time or event. */
static void compare_all(struct run *run, char when, size_t event, pk_real t, const pk_real *q,
                        const pk_real *v, const pk_real *z)
{
    const pk_real *out = NULL;
    for (size_t i = 0; i < run->settings.n_expected; i++) {
        struct expected *x = &run->settings.expected[i];
        if (x->when != when || (when == 'e' && x->event != event) ||
            (when == 't' && !is_at(run, t, x->at)))
            continue;
        if (!out)
            out = outputs(run, t, q, v);
        compare(run, x, t, output_value(run, &x->a, t, q, v, z, out),
                output_value(run, &x->b, t, q, v, z, out),
                x->has_within ? output_value(run, &x->within, t, q, v, z, out) : 0);
    }
}

void expect_landed(struct run *run, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *z)
{
    compare_all(run, 't', 0, t, q, v, z);
}

void expect_row(struct run *run, pk_real t, const pk_real *q, const pk_real *v, const pk_real *z)
{
    compare_all(run, 'r', 0, t, q, v, z);
}

void expect_landed_at(struct run *run, const struct pk_events *at)
{
    compare_all(run, 'e', at->which, at->t, at->q, at->v, at->z);
}

void expect_sample(struct run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    const pk_real *out = NULL;
    for (size_t i = 0; i < run->settings.n_drifting; i++) {
        struct drifting *d = &run->settings.drifting[i];
        if (d->energy)
            continue;
        if (!out)
            out = outputs(run, t, q, v);
        pk_drift_update(&d->drift, t, out[d->output]);
    }
}

int expect_uses_h(const struct run *run)
{
    for (size_t i = 0; i < run->settings.n_drifting; i++)
        if (run->settings.drifting[i].energy)
            return run_model->energy && run_model->canonical;
    return 0;
}

void expect_member(struct run *run, const struct pk_drift *energy)
{
    for (size_t i = 0; i < run->settings.n_drifting; i++) {
        struct drifting *d = &run->settings.drifting[i];
        const struct pk_drift *drift = d->energy ? energy : &d->drift;
        const pk_real max = drift->samples ? pk_drift_max(drift) : (pk_real)NAN;
        const int worse = !d->members || !(max <= d->max);
        if (worse && d->max - d->max == PK_C(0.0)) {
            d->max = max;
            d->member = run->member;
        }
        d->members++;
        pk_drift_init(&d->drift);
    }
}

void expect_clear(struct settings *s)
{
    for (size_t i = 0; i < s->n_expected; i++)
        s->expected[i].count = s->expected[i].missed = 0, s->expected[i].off = 0;
    for (size_t i = 0; i < s->n_drifting; i++)
        s->drifting[i].members = 0, s->drifting[i].max = 0;
}

static int is_number(pk_real x) { return x - x == PK_C(0.0); }

void expect_merge(struct settings *all, const struct settings *one)
{
    for (size_t i = 0; i < all->n_expected; i++) {
        struct expected *to = &all->expected[i];
        const struct expected *from = &one->expected[i];
        const unsigned long count = to->count + from->count, missed = to->missed + from->missed;
        if (from->count && (to->count == 0 || (is_number(to->off) && !(from->off <= to->off))))
            *to = *from;
        to->count = count;
        to->missed = missed;
    }
    for (size_t i = 0; i < all->n_drifting; i++) {
        struct drifting *to = &all->drifting[i];
        const struct drifting *from = &one->drifting[i];
        const size_t members = to->members + from->members;
        if (from->members && (to->members == 0 || (is_number(to->max) && !(from->max <= to->max))))
            *to = *from;
        to->members = members;
    }
}

/* A zeroed element more, behind the others. */
static void *more(void **list, size_t *count, size_t size)
{
    char *all = (char *)realloc(*list, (*count + 1) * size);
    if (!all) {
        fprintf(stderr, "run: out of memory\n");
        exit(4);
    }
    *list = all;
    return memset(all + size * (*count)++, 0, size);
}

/* expect RELATION A B WITHIN|- rows | t X | event INDEX */
static int read_expected(struct settings *s, const struct pk_system *system, size_t line,
                         char *const word[])
{
    struct expected x = {0};
    if (!word[1] || !strchr("=<>", word[1][0]))
        return words_usage(line, "a relation is =, < or >", word[1]);
    x.relation = word[1][0];
    x.has_within = word[4] && strcmp(word[4], "-") != 0;
    if (!settings_column(s, system, word[2], &x.a) || !settings_column(s, system, word[3], &x.b) ||
        (x.has_within && !settings_column(s, system, word[4], &x.within)))
        return words_usage(line, "no such column", word[2]);
    x.when = word[4] && word[5] ? word[5][0] : '\0';
    if (!x.when || !strchr("rte", x.when) ||
        (x.when == 't' && !words_real(word[6], &x.at)) ||
        (x.when == 'e' && !words_index(word[6], system->n_events, &x.event)))
        return words_usage(line, "expected in rows, t X or event INDEX", word[5]);
    void *list = s->expected;
    *(struct expected *)more(&list, &s->n_expected, sizeof x) = x;
    s->expected = (struct expected *)list;
    return 0;
}

static int read_drifting(struct settings *s, const struct pk_system *system, size_t line,
                         char *const word[])
{
    struct drifting d = {0};
    d.energy = word[1] && strcmp(word[1], "energy") == 0;
    if (!d.energy && !words_index(word[1], system->n_observed, &d.output))
        return words_usage(line, "no such output", word[1]);
    void *list = s->drifting;
    *(struct drifting *)more(&list, &s->n_drifting, sizeof d) = d;
    s->drifting = (struct drifting *)list;
    return 0;
}

int expect_setting(struct settings *s, const struct pk_system *system, size_t line,
                   char *const word[], int *code)
{
    size_t index;
    *code = 0;
    if (strcmp(word[0], "expect") == 0) {
        *code = read_expected(s, system, line, word);
    } else if (strcmp(word[0], "drift") == 0) {
        *code = read_drifting(s, system, line, word);
    } else if (strcmp(word[0], "hidden") == 0) {
        if (!s->hidden)
            s->hidden = (unsigned char *)words_allocate(system->n_observed + 1, 1);
        if (words_index(word[1], system->n_observed, &index))
            s->hidden[index] = 1;
        else
            *code = words_usage(line, "no such output", word[1]);
    } else {
        return 0;
    }
    return 1;
}

void expect_begin(struct run *run)
{
    if (run->settings.n_expected || run->settings.n_drifting)
        run->expected = (pk_real *)words_allocate(run_model->n_observed + 1, sizeof(pk_real));
}

int expect_hides(const struct settings *s, size_t output)
{
    return s->hidden && s->hidden[output];
}

static void named_real(FILE *file, const char *key, pk_real x)
{
    fprintf(file, ", \"%s\": ", key);
    output_real(file, x);
}

void expect_report(const struct run *run, FILE *file)
{
    const struct settings *s = &run->settings;
    fputs("  \"expects\": [", file);
    for (size_t i = 0; i < s->n_expected; i++) {
        const struct expected *x = &s->expected[i];
        fprintf(file, "%s\n    {\"count\": %lu, \"missed\": %lu, \"member\": %ld", i ? "," : "",
                x->count, x->missed, ensemble_number(s, x->member));
        named_real(file, "value", x->value);
        named_real(file, "bound", x->bound);
        named_real(file, "within", x->allowed);
        named_real(file, "t", x->t);
        fputs("}", file);
    }
    fputs("],\n  \"expect_drifts\": [", file);
    for (size_t i = 0; i < s->n_drifting; i++) {
        fprintf(file, "%s{\"member\": %ld", i ? ", " : "",
                ensemble_number(s, s->drifting[i].member));
        named_real(file, "max", s->drifting[i].max);
        fputs("}", file);
    }
    fputs("],\n", file);
}

void expect_free(struct settings *s)
{
    free(s->expected);
    free(s->drifting);
    free(s->hidden);
}
