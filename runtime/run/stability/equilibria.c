/* Writes the equilibria of a model as JSON; see pk/stability.h. */
#define _POSIX_C_SOURCE 200809L

#include <pk/stability.h>

#include "../settings/settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>

enum { MOST = 32 };

struct search {
    struct pk_run *run;
    struct pk_problem problem;
    size_t n, tries;
    double *work; /* n */
    struct pk_equilibria found;
};

static void tell_one(struct search *s, size_t k, struct json *j)
{
    const struct settings *at = &s->run->settings;
    const size_t n = s->n;
    const double *q = s->found.q + k * n, *v = s->found.v + k * n;
    json_open(j, NULL, '{');
    json_numbers(j, "q", q, n);
    json_numbers(j, "v", v, n);
    json_numbers(j, "doubt", s->found.doubt + k * n, n);
    json_real(j, "energy", at->system->energy ? at->system->energy(at->params, 0, q, v, at->u) : 0);
    json_integer(j, "slack", s->found.slack[k]);
    json_close(j, '}');
}

static void tell(struct search *s, enum pk_status status, struct json *j)
{
    for (size_t i = 0; i < s->n; i++)
        s->work[i] = s->found.turns[i];
    json_open(j, NULL, '{');
    json_text(j, "status", pk_status_name(status));
    json_counts(j, {"failed", s->found.failed}, {"singular", s->found.singular});
    json_flag(j, "more", s->found.more);
    json_numbers(j, "turns", s->work, s->n);
    json_numbers(j, "middle", s->found.middle, s->n);
    json_numbers(j, "box", s->found.box, s->n);
    json_open(j, "equilibria", '[');
    for (size_t k = 0; k < s->found.count; k++)
        tell_one(s, k, j);
    json_close(j, ']');
    json_close(j, '}');
}

static void search(void *context)
{
    struct search *s = context;
    struct pk_run *run = s->run;
    const size_t n = s->n = run->settings.n;
    struct memory *memory = &run->memory;
    double *const room = memory_take(memory, (3 * MOST + 3) * n, sizeof *room);
    s->problem = run_problem(run);
    s->found = (struct pk_equilibria){.most = MOST,
                                      .q = room,
                                      .v = room + MOST * n,
                                      .doubt = room + 2 * MOST * n,
                                      .middle = room + 3 * MOST * n,
                                      .box = room + (3 * MOST + 1) * n,
                                      .slack = memory_take(memory, MOST, sizeof(size_t)),
                                      .turns = memory_take(memory, n, 1)};
    s->work = room + (3 * MOST + 2) * n;
    const enum pk_status status =
        pk_gsl_equilibria(&s->problem, run->settings.q, run->settings.v, s->tries, &s->found);
    free(run->equilibria);
    run->equilibria = NULL;
    struct json json = {.file = run_text(run, &run->equilibria)};
    tell(s, status, &json);
    run_text_end(run);
    memory_drop(memory, s->found.slack);
    memory_drop(memory, s->found.turns);
    memory_drop(memory, room);
}

const char *pk_stability_equilibria(struct pk_run *run, size_t tries)
{
    struct search s = {.run = run, .tries = tries};
    const int room = !run->code && memory_try(&run->memory, search, &s);
    return room && run->equilibria ? run->equilibria : NULL;
}

#else
extern int stability_needs_gsl; /* without GSL this file would be empty, which ISO C forbids */
#endif
