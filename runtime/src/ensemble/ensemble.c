/* Ensembles: chooses how to integrate members, and moves one member from one output row to the
 * next. See also member.c for one member, and block.c for members in lanes. */
#include <stdio.h>

#include <pk/adaptive_lanes.h>

#include "ensemble.h"

/* Returns the stepper of blocks, or NULL if members run one after the other. */
static const struct pk_block_stepper *stepper(const struct pk_ensemble *e)
{
    return e->options.h > 0 && !(e->method->traits & PK_JETS) && !e->system->constraints.n &&
                   !e->system->noise.n
               ? pk_block_stepper_of(e->system, e->method)
               : NULL;
}

int pk_ensemble_fixed(const struct pk_ensemble *e)
{
    return pk_is_fixed(e->method) || stepper(e) != NULL;
}

/* Returns the bytes for the lanes if each member has its own steps, or 0 without lanes. */
static size_t lanes_size(const struct pk_ensemble *e)
{
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    return stepper(e) ? 0 : pk_ensemble_padded(pk_lanes_size(&problem, e->method));
}

static size_t lanes(const struct pk_ensemble *e)
{
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    const struct pk_block_stepper *s = stepper(e);
    return s ? s->lanes : pk_lanes_count(&problem, e->method);
}

/* Returns the number of integrators. If lanes share their steps, this is pk_member_count();
 * otherwise there is one per lane, and one that reaches output rows within steps. */
static size_t integrators(const struct pk_ensemble *e)
{
    return stepper(e) ? pk_member_count(e, lanes(e)) : lanes(e) + 1;
}

size_t pk_ensemble_size(const struct pk_ensemble *e)
{
    if (!e || !e->system || !e->method || !e->params || e->system->abi != PK_ABI)
        return 0;
    return integrators(e) * pk_member_size(e) + (stepper(e) ? pk_block_size(e) : lanes_size(e));
}

/* A member that is integrated from one output row to the next. `kept`: whether it stores rows. */
struct way {
    const struct pk_ensemble *e;
    struct pk_member *m, *aside;
    size_t member, row;
    int kept;
};

static void keep(const struct way *w, const struct pk_integrator *there)
{
    const struct pk_ensemble *e = w->e;
    const size_t n_q = there->n_q, n = there->n, at = w->member * e->rows + w->row;
    pk_copy(e->q + at * n, there->q, n_q);
    pk_copy(e->v + at * n, there->v, n);
    e->done[w->member]++;
}

static int is_ahead(const struct way *w)
{
    const struct pk_ensemble *e = w->e;
    const struct pk_integrator *it = &w->m->it;
    const pk_real t = e->t[w->row], way = e->t[e->rows - 1] < e->t0 ? -1 : 1;
    return way * (t - it->t) > 0 &&
           (e->method->traits & PK_ADAPTIVE || !pk_integrator_is_at(it, t));
}

/* Stores the rows that a fixed step has reached or passed. Returns whether the member continues. */
static int rows(struct way *w)
{
    const struct pk_ensemble *e = w->e;
    struct pk_integrator *it = &w->m->it;
    for (; w->row < e->rows && !is_ahead(w); w->row++) {
        const struct pk_integrator *there = it;
        if (!pk_integrator_is_at(it, e->t[w->row])) {
            there = &w->aside->it;
            if (pk_member_integrator(e, w->member, w->aside) < 0)
                it->status = there->status;
            else
                pk_integrator_aside(it, &w->aside->it, e->t[w->row]);
        }
        if (it->status < 0)
            return 0;
        if (w->kept)
            keep(w, there);
    }
    return w->row < e->rows;
}

static int begin(struct way *w, size_t member)
{
    w->member = member;
    w->row = 0;
    w->m->it.status = pk_member_begin(w->e, member, w->m);
    return w->m->it.status == PK_DONE && rows(w);
}

/* Returns the time at which the next step must end at the latest. */
static pk_real limit(const struct way *w)
{
    const struct pk_ensemble *e = w->e;
    const pk_real t = e->t[w->row];
    return e->method->traits & PK_ADAPTIVE ? t
                                           : pk_integrator_limit(&w->m->it, t, e->t[e->rows - 1]);
}

/* Makes a step, or many in one call. Returns whether the member continues. */
static int step(struct way *w)
{
    const struct pk_ensemble *e = w->e;
    struct pk_integrator *it = &w->m->it;
    const int fused = e->system->families.advance && pk_is_fixed(e->method);
    const pk_real whole = fused ? pk_abs(e->t[w->row] - it->t) / it->options.h : 0;
    const pk_real most = PK_C(1e9);
    if (whole >= 2)
        pk_integrator_steps(it, e->t[e->rows - 1], (unsigned long)(whole < most ? whole : most));
    else
        pk_integrator_step(it, limit(w));
    return it->status == PK_DONE && rows(w);
}

static void end(struct way *w)
{
    const struct pk_ensemble *e = w->e;
    e->status[w->member] = w->m->it.status;
    if (w->m->it.own)
        e->last_t[w->member] = w->m->it.t;
    pk_integrator_free(&w->m->it);
}

static void run_one(const struct pk_ensemble *e, size_t member, void *block)
{
    struct way w = {.e = e, .m = pk_member_at(e, block, 0), .aside = pk_member_at(e, block, 1)};
    w.kept = 1;
    for (int goes = begin(&w, member); goes; goes = step(&w))
        ;
    end(&w);
}

/* Runs members in lanes; each lane takes the next member when its own has ended. */
static void run_in_lanes(const struct pk_ensemble *e, size_t first, size_t count, void *block)
{
    const struct pk_problem problem = pk_ensemble_problem(e, first);
    const size_t W = lanes(e), behind = first + count;
    struct way ways[PK_BLOCK_MOST];
    struct pk_lane of[PK_BLOCK_MOST];
    struct pk_lanes a;
    pk_lanes_init(&a, &problem, e->method, pk_member_at(e, block, W + 1), lanes_size(e));
    for (size_t l = 0; l < W; l++) {
        ways[l] = (struct way){
            .e = e, .m = pk_member_at(e, block, l), .aside = pk_member_at(e, block, W)};
        ways[l].kept = 1;
        of[l] = (struct pk_lane){0};
    }
    for (size_t next = first, left = count; left;) {
        for (size_t l = 0; l < W; l++) {
            struct way *w = &ways[l];
            while (!of[l].it && next < behind) {
                if (begin(w, next++))
                    of[l].it = &w->m->it;
                else
                    end(w), left--;
            }
            if (of[l].it)
                of[l].limit = limit(w), of[l].free = w->m->it.t;
        }
        pk_lanes_make(&a, of);
        for (size_t l = 0; l < W; l++)
            if (of[l].it && !step(&ways[l]))
                end(&ways[l]), of[l].it = NULL, left--;
    }
}

static enum pk_status usable(const struct pk_ensemble *e, size_t first, size_t count,
                             const void *block, size_t size)
{
    if (!e || !e->system || !e->method || !e->params || !e->q0 || !e->v0 || !e->q || !e->v ||
        !e->done || !e->last_t || !e->status || (e->rows && !e->t) || !block ||
        first > e->members || count > e->members - first)
        return PK_BAD_ARGUMENT;
    if (e->system->switches.impulses)
        return PK_REFUSED; /* ensembles do not locate switches */
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
    struct way w = {.e = e, .m = pk_member_at(e, block, 0), .aside = pk_member_at(e, block, 1)};
    struct pk_integrator *it = &w.m->it;
    const enum pk_status status = e->status[member];
    const pk_real last = e->last_t[member];
    const size_t rows = e->done[member];
    int length = -1;
    if (status < 0) {
        for (int goes = begin(&w, member); goes; goes = step(&w))
            ;
        if (it->status == status && it->method)
            length = pk_integrator_reason(it, text, size);
        pk_integrator_free(it);
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
    const size_t W = lanes(e);
    if (!s && W > 1)
        run_in_lanes(e, first, count, block);
    for (size_t i = 0; i < count && (s || W == 1); i += W) {
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
