/* Writes the equilibria of a model as JSON; see pk/stability.h. */
#define _POSIX_C_SOURCE 200809L

#include <pk/stability.h>

#include "../settings/settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>

enum { MOST = 32 };

struct search {
    struct pk_run *run;
    size_t tries;
};

static void write(const struct pk_run *run, const struct pk_equilibria *found,
                  enum pk_status status, struct json *j)
{
    const struct settings *s = &run->settings;
    const size_t n = s->n;
    json_open(j, NULL, '{');
    json_text(j, "status", pk_status_name(status));
    json_counts(j, {"failed", found->failed}, {"singular", found->singular});
    json_flag(j, "more", found->more);
    json_open(j, "turns", '[');
    for (size_t i = 0; i < n; i++)
        json_integer(j, NULL, found->turns[i]);
    json_close(j, ']');
    json_numbers(j, "middle", found->middle, n);
    json_numbers(j, "box", found->box, n);
    json_open(j, "equilibria", '[');
    for (size_t k = 0; k < found->count; k++) {
        const double *q = found->q + k * n, *v = found->v + k * n;
        json_open(j, NULL, '{');
        json_numbers(j, "q", q, n);
        json_numbers(j, "v", v, n);
        json_numbers(j, "doubt", found->doubt + k * n, n);
        json_real(j, "energy", s->system->energy ? s->system->energy(s->params, 0, q, v, s->u) : 0);
        json_integer(j, "slack", found->slack[k]);
        json_close(j, '}');
    }
    json_close(j, ']');
    json_close(j, '}');
}

static void search(void *context)
{
    const struct search *s = context;
    struct pk_run *run = s->run;
    const size_t n = run->settings.n;
    struct memory *memory = &run->memory;
    double *const room = memory_take(memory, (3 * MOST + 2) * n, sizeof *room);
    const struct pk_problem problem = run_problem(run);
    struct pk_equilibria found = {.most = MOST,
                                  .q = room,
                                  .v = room + MOST * n,
                                  .doubt = room + 2 * MOST * n,
                                  .middle = room + 3 * MOST * n,
                                  .box = room + (3 * MOST + 1) * n,
                                  .slack = memory_take(memory, MOST, sizeof(size_t)),
                                  .turns = memory_take(memory, n, 1)};
    const enum pk_status status =
        pk_gsl_equilibria(&problem, run->settings.q, run->settings.v, s->tries, &found);
    free(run->equilibria);
    run->equilibria = NULL;
    struct json json = {.file = run_text(run, &run->equilibria)};
    write(run, &found, status, &json);
    run_text_end(run);
    memory_drop(memory, found.slack);
    memory_drop(memory, found.turns);
    memory_drop(memory, room);
}

const char *pk_stability_equilibria(struct pk_run *run, size_t tries)
{
    struct search s = {run, tries};
    const int room = !run->code && memory_try(&run->memory, search, &s);
    return room ? run->equilibria : NULL;
}

#else
extern int stability_needs_gsl; /* without GSL this file would be empty, which ISO C forbids */
#endif
