/* Members of an ensemble from their file into memory, and what that takes; see members.h. */
#include "ensemble.h"

#include "../settings/settings.h"

/* A batch is as many members as keep their rows within this; less to test more than one. */
#ifndef RUN_BATCH_BYTES
#define RUN_BATCH_BYTES (1 << 26)
#endif

enum { CHUNK = 64 };

/* Parameters, start and inputs of member i of the batch from a row of the file. */
static enum pk_run_code set_member(struct batch *b, size_t i, size_t member, const double *row,
                                   struct pk_run *run)
{
    const struct settings *s = b->s;
    char *params = b->params + i * b->system->params_size;
    pk_real *q = b->q0 + i * b->n, *v = b->v0 + i * b->n, *u = b->u + i * b->system->n_inputs;
    memcpy(params, s->params, b->system->params_size);
    memcpy(u, s->u, b->system->n_inputs * sizeof *u);
    memcpy(b->given, s->given, b->system->n_parameters);
    for (size_t k = 0; k < s->n_columns; k++)
        if (s->columns[k].kind == 'p') {
            const pk_real x = (pk_real)row[k];
            memcpy(params + b->system->parameters[s->columns[k].index].offset, &x, sizeof x);
            b->given[s->columns[k].index] = 1;
        }
    b->system->derive(params, b->given);
    const int outside = b->system->prepare(params);
    if (outside) {
        char *text = NULL;
        FILE *file = run_text(run, &text);
        parameters_refused(file, b->system, params, outside);
        run_text_end(run);
        run_say(run, "member %ld: %s", member_number(s, member), text);
        free(text);
        return PK_RUN_USAGE;
    }
    b->system->start(params, q, v);
    for (size_t k = 0; k < b->n; k++) {
        if (s->start_given[k])
            q[k] = s->q[k];
        if (s->start_given[b->n + k])
            v[k] = s->v[k];
    }
    if (b->z0)
        settings_z(s, params, b->z0 + i * b->system->quadratures.n);
    for (size_t k = 0; k < s->n_columns; k++) {
        const struct pk_run_column c = s->columns[k];
        pk_real *z = b->z0 ? b->z0 + i * b->system->quadratures.n : NULL;
        if (c.kind != 'p')
            (c.kind == 'i'   ? u
             : c.kind == 'q' ? q
             : c.kind == 'z' ? z
                             : v)[c.index] = (pk_real)row[k];
    }
    return PK_RUN_DONE;
}

enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct pk_run *run)
{
    for (size_t i = 0; i < count; i++) {
        const enum pk_run_code code =
            set_member(b, i, first + i, b->s->values + (first + i) * b->s->n_columns, run);
        if (code)
            return code;
    }
    return PK_RUN_DONE;
}

enum pk_run_code members_check(struct batch *b, struct pk_run *run)
{
    enum pk_run_code code = PK_RUN_DONE;
    for (size_t first = 0; code == PK_RUN_DONE && first < b->s->members; first += b->size) {
        const size_t left = b->s->members - first;
        code = members_set(b, first, left < b->size ? left : b->size, run);
    }
    return code;
}

void members_allocate(struct batch *b, struct pk_run *run, size_t rows)
{
    const struct settings *s = &run->settings;
    struct pk_ensemble *e = &b->e;
    b->s = s;
    struct memory *m = &run->memory;
    b->system = s->system;
    b->n = pk_system_count(b->system, s->params);
    const size_t fit = RUN_BATCH_BYTES / (2 * b->n * rows * sizeof(pk_real)) + 1;
    b->size = fit < s->members ? fit : s->members;
    if (b->size > CHUNK && b->size < s->members)
        b->size -= b->size % CHUNK; /* whole blocks */
    b->params = memory_take(m, b->size, b->system->params_size);
    b->q0 = memory_take(m, b->size * b->n, sizeof *b->q0);
    b->v0 = memory_take(m, b->size * b->n, sizeof *b->v0);
    b->u = memory_take(m, b->size * b->system->n_inputs, sizeof *b->u);
    b->t = memory_take(m, rows, sizeof *b->t);
    b->given = memory_take(m, b->system->n_parameters, 1);
    memcpy(b->params, s->params, b->system->params_size);
    *e = (struct pk_ensemble){.system = b->system,
                              .method = s->method,
                              .options = s->options,
                              .members = b->size,
                              .params = b->params,
                              .q0 = b->q0,
                              .v0 = b->v0,
                              .u = b->u,
                              .rows = rows,
                              .t = b->t};
    e->q = memory_take(m, b->size * rows * b->n, sizeof *e->q);
    e->v = memory_take(m, b->size * rows * b->n, sizeof *e->v);
    if (b->system->quadratures.n) {
        e->z0 = b->z0 = memory_take(m, b->size * b->system->quadratures.n, sizeof *b->z0);
        e->z = memory_take(m, b->size * rows * b->system->quadratures.n, sizeof *e->z);
    }
    e->done = memory_take(m, b->size, sizeof *e->done);
    e->last_t = memory_take(m, b->size, sizeof *e->last_t);
    e->status = memory_take(m, b->size, sizeof *e->status);
    b->threads = pk_ensemble_threads();
    if (s->threads && b->threads > 1)
        b->threads = s->threads;
    b->block_size = b->threads * pk_ensemble_size(e);
    b->block = memory_take(m, b->block_size, 1);
}
