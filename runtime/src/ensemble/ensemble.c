/* Ensembles: which route a member takes, and the way of one member from row to row. One member:
 * member.c; blocks of members in lanes: block.c.
 */
#include <stdio.h>
#include <string.h>

#include "ensemble.h"

static const struct pk_block_stepper *find(const struct pk_block_stepper *list, const char *method)
{
    for (; list && list->method; list++)
        if (strcmp(list->method, method) == 0)
            return list;
    return NULL;
}

/* NULL: one member after the other. */
static const struct pk_block_stepper *stepper(const struct pk_ensemble *e)
{
    const struct pk_block_stepper *own = find(e->system->block_steppers, e->method->name);
    if (e->method->needs & PK_LINEAR_DRAG && !(e->system->facts & PK_SEPARABLE))
        return NULL;
    if (!(e->options.h > 0) || e->system->constraints.n ||
        e->system->families.count) /* its loops are over members of the family */
        return NULL;
    return own ? own : find(pk_block_steppers, e->method->name);
}

int pk_ensemble_fixed(const struct pk_ensemble *e)
{
    return !(e->method->traits & PK_ADAPTIVE) || stepper(e) != NULL;
}

size_t pk_ensemble_size(const struct pk_ensemble *e)
{
    if (!e || !e->system || !e->method || !e->params || e->system->abi != PK_ABI)
        return 0;
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    const struct pk_block_stepper *s = stepper(e);
    const size_t n = pk_system_count(e->system, problem.params);
    return pk_member_count(e, s ? s->lanes : 1) * pk_member_size(e) +
           (s ? pk_block_size(e, n, s->lanes) : 0);
}

static void keep(const struct pk_ensemble *e, size_t member, size_t row,
                 const struct pk_integrator *it)
{
    const size_t at = member * e->rows + row;
    memcpy(e->q + at * it->n, it->q, it->n * sizeof *it->q);
    memcpy(e->v + at * it->n, it->v, it->n * sizeof *it->v);
    e->done[member]++;
}

/* Steps to the row at t, or past it by a fixed step. *there: the integrator that is at t. */
static enum pk_status to_row(const struct pk_ensemble *e, size_t member, struct pk_member *m,
                             pk_real t, const struct pk_integrator **there)
{
    struct pk_integrator *it = &m->it;
    struct pk_member *aside = (struct pk_member *)(void *)((char *)m + pk_member_size(e));
    const pk_real last = e->t[e->rows - 1], way = last < e->t0 ? PK_C(-1.0) : PK_C(1.0);
    const int fixed = !(e->method->traits & PK_ADAPTIVE);
    *there = it;
    while (way * (t - it->t) > 0 && !(fixed && pk_integrator_is_at(it, t))) {
        const pk_real whole = fixed ? way * (t - it->t) / it->options.h : 0;
        if (whole >= 2 && e->system->families.advance) { /* many in one call */
            const pk_real most = PK_C(1e9);
            if (pk_integrator_steps(it, last, (unsigned long)(whole < most ? whole : most)))
                return it->status;
        } else if (pk_integrator_step(it, fixed ? pk_integrator_limit(it, t, last) : t) !=
                   PK_DONE) {
            return it->status;
        }
    }
    if (pk_integrator_is_at(it, t))
        return PK_DONE;
    if (!aside->it.q && pk_member_integrator(e, member, aside) < 0)
        return aside->it.status;
    *there = &aside->it;
    return pk_integrator_aside(it, &aside->it, t);
}

/* From row to row, which are kept or not. */
static enum pk_status go(const struct pk_ensemble *e, size_t member, struct pk_member *m, int kept)
{
    struct pk_member *aside = (struct pk_member *)(void *)((char *)m + pk_member_size(e));
    memset(aside, 0, sizeof *aside);
    enum pk_status status = pk_member_begin(e, member, m);
    for (size_t row = 0; row < e->rows && status == PK_DONE; row++) {
        const struct pk_integrator *there = &m->it;
        status = to_row(e, member, m, e->t[row], &there);
        if (kept)
            e->last_t[member] = m->it.t;
        if (kept && status == PK_DONE)
            keep(e, member, row, there);
    }
    return status;
}

static enum pk_status run_one(const struct pk_ensemble *e, size_t member, void *block)
{
    struct pk_member *m = (struct pk_member *)block;
    e->status[member] = go(e, member, m, 1);
    pk_integrator_free(&m->it);
    return e->status[member];
}

static enum pk_status usable(const struct pk_ensemble *e, size_t first, size_t count,
                             const void *block, size_t size)
{
    if (!e || !e->system || !e->method || !e->params || !e->q0 || !e->v0 || !e->q || !e->v ||
        !e->done || !e->last_t || !e->status || (e->rows && !e->t) || !block ||
        first > e->members || count > e->members - first)
        return PK_BAD_ARGUMENT;
    if (e->system->switches.impulses)
        return PK_REFUSED; /* nobody looks for its switches here */
    return size < pk_ensemble_size(e) || (size_t)block % _Alignof(struct pk_member) ||
                   (size_t)block % _Alignof(pk_real)
               ? PK_BLOCK_TOO_SMALL
               : PK_DONE;
}

int pk_ensemble_reason(const struct pk_ensemble *e, size_t member, void *block, size_t block_size,
                       char *text, size_t size)
{
    const enum pk_status wrong = usable(e, member, 1, block, block_size);
    if (wrong < 0)
        return snprintf(text, size, "%s", pk_status_text(wrong));
    struct pk_member *m = (struct pk_member *)block;
    const enum pk_status status = e->status[member];
    const pk_real last = e->last_t[member];
    const size_t rows = e->done[member];
    int length = -1;
    if (status < 0) {
        if (go(e, member, m, 0) == status && m->it.method)
            length = pk_integrator_reason(&m->it, text, size);
        pk_integrator_free(&m->it);
    }
    e->status[member] = status, e->last_t[member] = last, e->done[member] = rows;
    return length >= 0 ? length
                       : snprintf(text, size, "%s; last valid time %.17g", pk_status_text(status),
                                  (double)last);
}

enum pk_status pk_ensemble_run(const struct pk_ensemble *e, size_t first, size_t count, void *block,
                               size_t size)
{
    const enum pk_status wrong = usable(e, first, count, block, size);
    if (wrong < 0)
        return wrong;
    const struct pk_block_stepper *s = stepper(e);
    const size_t W = s ? s->lanes : 1;
    for (size_t i = 0; i < count; i += W) {
        if (s)
            pk_block_run(e, s, first + i, count - i < W ? count - i : W, (char *)block);
        else
            run_one(e, first + i, block);
    }
    for (size_t i = first; i < first + count; i++)
        if (e->status[i] != PK_DONE)
            return e->status[i];
    return PK_DONE;
}
