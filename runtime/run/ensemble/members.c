/* Members of an ensemble: memory, and parameters from the settings and the caller's table. */
#include "../settings/settings.h"
#include "ensemble.h"

/* Memory limit for the rows of a batch, in bytes. Tests lower it to get several batches. */
#ifndef RUN_BATCH_BYTES
#define RUN_BATCH_BYTES (1 << 26)
#endif

/* Sets parameters, initial state and inputs of member i of the batch from a row of the table. */
static enum pk_run_code set_member(struct batch *b, size_t i, size_t member, struct pk_run *run)
{
    struct settings *s = &run->settings;
    const struct pk_system *system = b->system;
    const size_t n = b->n, n_columns = s->asked.n_member_columns;
    const double *row = s->asked.member_values + member * n_columns;
    char *params = b->params + i * system->params_size;
    pk_real *q = b->q0 + i * n, *v = b->v0 + i * n, *u = b->u + i * system->n_inputs;
    char who[40];
    memcpy(params, s->params, system->params_size);
    /* gives the member its own memory for families of parameters and factors of M */
    if (b->families_size) {
        char *const own = b->families + i * b->families_size;
        memcpy(own, s->families, b->families_size);
        system->families.attach(params, own);
    }
    memcpy(u, s->u, system->n_inputs * sizeof *u);
    size_t n_own = 0;
    for (size_t k = 0; k < n_columns; k++) {
        const struct pk_run_column c = s->asked.member_columns[k];
        if (c.kind == 'p')
            b->own[n_own++] = (struct pk_run_value){c.index, c.member, row[k]};
    }
    settings_assign(s, params, b->own, n_own);
    const int outside = system->prepare(params);
    /* With `lenient`, the member fails later: its integrator reports the refused parameters. */
    if (outside && !s->asked.lenient) {
        snprintf(who, sizeof who, "member %ld: ", member_number(s, member));
        settings_refused(run, params, outside, who);
        return PK_RUN_USAGE;
    }
    system->start(params, q, v);
    for (size_t k = 0; k < 2 * n; k++)
        if (s->start_given[k]) /* s->v follows s->q in memory */
            *(k < n ? q + k : v + (k - n)) = s->q[k];
    for (size_t k = 0; k < n_columns; k++) {
        const struct pk_run_column c = s->asked.member_columns[k];
        if (c.kind != 'p')
            (c.kind == 'i' ? u : c.kind == 'q' ? q : v)[c.index] = (pk_real)row[k];
    }
    return PK_RUN_DONE;
}

enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct pk_run *run)
{
    enum pk_run_code code = PK_RUN_DONE;
    for (size_t i = 0; i < count && !code; i++)
        code = set_member(b, i, first + i, run);
    return code;
}

enum pk_run_code members_check(struct batch *b, struct pk_run *run)
{
    const size_t all = run->settings.asked.members;
    enum pk_run_code code = PK_RUN_DONE;
    for (size_t first = 0; !code && first < all; first += b->size)
        code = members_set(b, first, all - first < b->size ? all - first : b->size, run);
    return code;
}

char *tally_note(struct tally *tally, size_t member, enum pk_status status, pk_real t, int astray)
{
    tally->done += status == PK_DONE || status == PK_STOPPED_EVENT;
    if (astray && tally->astray++ == 0)
        tally->first_astray = member;
    if (status >= 0)
        return NULL;
    struct failed *of = &tally->failures[-status];
    if (tally->failed++ == 0)
        tally->first_failed = of;
    if (of->count++)
        return NULL;
    of->member = member;
    of->t = t;
    of->status = status;
    return of->reason;
}

void members_allocate(struct batch *b, struct pk_run *run, size_t rows)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = b->system = s->system;
    const size_t n = b->n = s->n, all = s->asked.members;
    const size_t fit = RUN_BATCH_BYTES / (2 * n * rows * sizeof(pk_real)) + 1;
    struct memory *memory = &run->memory;
    struct pk_ensemble *e = &b->e;
    size_t size = fit < all ? fit : all;
    if (size > WHOLE_BLOCKS && size < all)
        size -= size % WHOLE_BLOCKS;
    b->size = size;
    b->params = memory_take(memory, size, system->params_size);
    b->families_size = s->families_size;
    b->families = memory_take(memory, size, s->families_size);
    b->q0 = memory_take(memory, size * n, sizeof *b->q0);
    b->v0 = memory_take(memory, size * n, sizeof *b->v0);
    b->u = memory_take(memory, size * system->n_inputs, sizeof *b->u);
    b->t = memory_take(memory, rows, sizeof *b->t);
    b->own = memory_take(memory, s->asked.n_member_columns, sizeof *b->own);
    memcpy(b->params, s->params, system->params_size);
    *e = (struct pk_ensemble){.system = system,
                              .method = s->method,
                              .options = s->options,
                              .members = size,
                              .params = b->params,
                              .q0 = b->q0,
                              .v0 = b->v0,
                              .u = b->u,
                              .rows = rows,
                              .t = b->t,
                              .q = memory_take(memory, size * rows * n, sizeof *e->q),
                              .v = memory_take(memory, size * rows * n, sizeof *e->v),
                              .done = memory_take(memory, size, sizeof *e->done),
                              .last_t = memory_take(memory, size, sizeof *e->last_t),
                              .status = memory_take(memory, size, sizeof *e->status)};
    b->threads = pk_ensemble_threads();
    if (s->asked.threads && b->threads > 1)
        b->threads = s->asked.threads;
    b->block_size = b->threads * pk_ensemble_size(e);
    b->block = memory_take(memory, b->block_size, 1);
}

int member_fixed(const struct settings *s)
{
    if (member_by_one(s))
        return pk_is_fixed(s->method);
    const struct pk_ensemble e = {.system = s->system, .method = s->method, .options = s->options};
    return pk_ensemble_fixed(&e);
}
