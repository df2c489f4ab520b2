/* Members of an ensemble from their file into memory, and what that takes; see members.h. */
#include <stdlib.h>
#include <string.h>

#include "ensemble.h"
#include "members.h"

/* A batch is as many members as keep their rows within this; less to test more than one. */
#ifndef RUN_BATCH_BYTES
#define RUN_BATCH_BYTES (1 << 26)
#endif

enum { CHUNK = 64 };

static void *memory(size_t count, size_t size)
{
    void *found = calloc(count ? count : 1, size ? size : 1);
    if (!found) {
        fprintf(stderr, "run: out of memory\n");
        exit(4);
    }
    return found;
}

/* Parameters, start and inputs of member i of the batch from a row of the file. */
static int set_member(struct batch *b, size_t i, size_t member, const double *row)
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
        fprintf(stderr, "run: member %ld: ", ensemble_number(s, member));
        parameters_refused(stderr, b->system, params, outside);
        fputc('\n', stderr);
        return 2;
    }
    b->system->start(params, q, v);
    for (size_t k = 0; k < b->n; k++) {
        if (s->start_given[k])
            q[k] = s->q[k];
        if (s->start_given[b->n + k])
            v[k] = s->v[k];
    }
    if (b->z0)
        settings_z(s, b->system, params, b->z0 + i * b->system->n_quadratures);
    for (size_t k = 0; k < s->n_columns; k++) {
        const struct column c = s->columns[k];
        pk_real *z = b->z0 ? b->z0 + i * b->system->n_quadratures : NULL;
        if (c.kind != 'p')
            (c.kind == 'i' ? u : c.kind == 'q' ? q : c.kind == 'z' ? z : v)[c.index] =
                (pk_real)row[k];
    }
    return 0;
}

int members_read(struct batch *b, size_t first, size_t count)
{
    const size_t columns = b->s->n_columns;
    if (columns && fread(b->values, columns * sizeof(double), count, b->file) != count) {
        fprintf(stderr, "run: %s ends early\n", b->s->ensemble);
        return 2;
    }
    for (size_t i = 0; i < count; i++) {
        const int code = set_member(b, i, first + i, b->values + i * columns);
        if (code)
            return code;
    }
    return 0;
}

int members_check(struct batch *b)
{
    int code = 0;
    for (size_t first = 0; code == 0 && first < b->s->members; first += b->size) {
        const size_t left = b->s->members - first;
        code = members_read(b, first, left < b->size ? left : b->size);
    }
    rewind(b->file);
    return code;
}

void members_allocate(struct batch *b, struct run *run, size_t rows, int (*stop)(void *context))
{
    const struct settings *s = &run->settings;
    struct pk_ensemble *e = &b->e;
    b->s = s;
    b->system = run_model;
    b->n = pk_system_count(b->system, s->params);
    const size_t fit = RUN_BATCH_BYTES / (2 * b->n * rows * sizeof(pk_real)) + 1;
    b->size = fit < s->members ? fit : s->members;
    if (b->size > CHUNK && b->size < s->members)
        b->size -= b->size % CHUNK; /* whole blocks */
    b->params = (char *)memory(b->size, b->system->params_size);
    b->q0 = (pk_real *)memory(b->size * b->n, sizeof *b->q0);
    b->v0 = (pk_real *)memory(b->size * b->n, sizeof *b->v0);
    b->u = (pk_real *)memory(b->size * b->system->n_inputs, sizeof *b->u);
    b->t = (pk_real *)memory(rows, sizeof *b->t);
    b->values = (double *)memory(b->size * s->n_columns, sizeof *b->values);
    b->given = (unsigned char *)memory(b->system->n_parameters, 1);
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
                              .t = b->t,
                              .stop = stop};
    e->q = (pk_real *)memory(b->size * rows * b->n, sizeof *e->q);
    e->v = (pk_real *)memory(b->size * rows * b->n, sizeof *e->v);
    if (b->system->n_quadratures) {
        e->z0 = b->z0 = (pk_real *)memory(b->size * b->system->n_quadratures, sizeof *b->z0);
        e->z = (pk_real *)memory(b->size * rows * b->system->n_quadratures, sizeof *e->z);
    }
    e->done = (size_t *)memory(b->size, sizeof *e->done);
    e->last_t = (pk_real *)memory(b->size, sizeof *e->last_t);
    e->status = (enum pk_status *)memory(b->size, sizeof *e->status);
    b->threads = pk_ensemble_threads();
    if (s->threads && b->threads > 1)
        b->threads = s->threads;
    b->block_size = b->threads * pk_ensemble_size(e);
    b->block = memory(b->block_size, 1);
    run->row = (pk_real *)memory(2 * b->n + b->system->n_observed + 1, sizeof *run->row);
}

void members_release(struct batch *b, struct run *run)
{
    void *const all[] = {b->params,   b->q0,        b->v0, b->u,    b->t,       b->values, b->given,
                         b->e.q,      b->e.v,       b->e.done, b->e.last_t, b->e.status, b->block,
                         run->row, b->z0, b->e.z};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        free(all[i]);
    if (b->file)
        fclose(b->file);
}
