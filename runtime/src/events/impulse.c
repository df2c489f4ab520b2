/* The motion at a switch across which L or a constraint jumps: whether there is an impulse, whether
 * the motion goes on or back, and several switches at once. See corner.c. */
#include <stdio.h>

#include <pk/constraint.h>

#include "corner.h"

#define SAME (64 * PK_EPS) /* a smaller relative change at a switch is not a jump */
/* two impulses may be applied in either order if the rates differ by less than this fraction */
#define AGREE PK_C(1e-8)

/* Values of `kind` in the reason of PK_NO_IMPULSE. Its `index` is the switch; its `other` is a
 * constraint row or a second switch. */
enum { POSITION, ROLLING, BOTH_JUMP, TURNS, ORDER, NEITHER };

/* Moves switch k to its other side, and moves the switches whose arguments contain switch k if
 * their arguments change sign. */
static void turn(struct corner *x, size_t k, pk_real side)
{
    struct pk_events *e = x->e;
    pk_real *now = x->before + e->n_switches;
    pk_switches_values(e, x->it, e->t, x->q, x->start, x->before);
    e->sides[k] = side;
    for (size_t round = 0; round < e->n_switches; round++) {
        pk_switches_values(e, x->it, e->t, x->q, x->start, now);
        for (size_t j = 0; j < e->n_switches; j++)
            if (j != k && now[j] * x->before[j] < 0)
                e->sides[j] = now[j] < 0 ? -1 : 1;
    }
}

static enum pk_status refuse(struct corner *x, size_t k, int why, size_t other)
{
    return pk_fail_with(x->it, PK_NO_IMPULSE, PK_WHY(.kind = why, .index = k, .other = other));
}

/* Sets *found to the bits of enum pk_impulse for the quantities that jump at switch k, by comparing
 * both sides at the state before the impulse. */
static enum pk_status compare(struct corner *x, size_t k, unsigned *found)
{
    struct pk_projection *w = &x->w;
    const struct pk_system *system = w->system;
    *found = 0;
    pk_corner_momenta(x, x->start);
    for (size_t i = 0; i < w->m; i++)
        if (pk_abs(x->p[i] - x->p0[i]) > SAME * (pk_abs(x->p[i]) + pk_abs(x->p0[i])))
            *found |= PK_IMPULSE_ENERGY;
    const pk_real h = pk_corner_energy(x, x->start), work = pk_abs(pk_dot(x->p, x->start, w->m));
    if (pk_abs(h - x->h0) > SAME * (pk_abs(h) + pk_abs(x->h0) + work))
        *found |= PK_IMPULSE_ENERGY;
    if (!w->c)
        return PK_DONE;
    pk_corner_rows(x, x->start);
    pk_project_terms(w, x->q, x->start);
    for (size_t j = 0; j < w->c; j++) {
        const int holonomic = j < system->constraints.n_holonomic;
        if (holonomic && pk_abs(w->phi[j] - x->phi[j]) > PK_CORNER_WHOLE * w->phi_size[j])
            return refuse(x, k, POSITION, j);
        pk_real change = 0, size = 0;
        for (size_t i = 0; i < w->m; i++) {
            change = pk_max(change, pk_abs(w->J[j * w->n + i] - x->J[j * w->n + i]));
            size = pk_max(size, pk_abs(x->J[j * w->n + i]));
        }
        if (!holonomic && change > PK_CORNER_WHOLE * size)
            return refuse(x, k, ROLLING, j);
        if (pk_abs(w->rate[j]) > PK_CORNER_ALONG * w->rate_size[j] ||
            change > PK_CORNER_WHOLE * size)
            *found |= holonomic ? PK_IMPULSE_ENERGY : PK_IMPULSE_ROLLING;
    }
    return PK_DONE;
}

/* Applies one impulse to the rates x->start. */
static enum pk_status one(struct corner *x, size_t k, pk_real side)
{
    struct pk_events *e = x->e;
    struct pk_projection *w = &x->w;
    const pk_real direction = side * (pk_real)x->it->own->direction;
    pk_real *const given = x->sides + e->n_switches;
    unsigned found;
    pk_copy(given, e->sides, e->n_switches);
    w->system->switches.slopes(w->params, w->t, x->q, x->start, w->u, x->slopes,
                               x->slopes + e->n_switches * w->n);
    x->slope = x->slopes + k * w->n;
    x->slope_t = x->slopes[e->n_switches * w->n + k];
    int of_place = 0;
    for (size_t i = 0; i < w->m; i++)
        of_place |= pk_abs(x->slope[i]) > 0;
    pk_copy(x->v, x->start, w->n);
    if (of_place && !(pk_corner_speed(x) * direction > 0))
        return PK_DONE; /* an earlier impulse has turned the motion back */
    pk_corner_momenta(x, x->start);
    pk_copy(x->p0, x->p, w->m);
    x->h0 = pk_corner_energy(x, x->start);
    pk_corner_rows(x, x->start);
    if (w->c) {
        pk_copy(x->J, w->J, w->c * w->n);
        pk_copy(x->phi, w->phi, w->h);
    }
    turn(x, k, side);
    PK_TRY(compare(x, k, &found));
    if (!found)
        return PK_DONE;
    if (of_place && found == (PK_IMPULSE_ENERGY | PK_IMPULSE_ROLLING))
        return refuse(x, k, BOTH_JUMP, 0);
    const int free = of_place && found == PK_IMPULSE_ENERGY;
    int done = pk_corner_leave(x, direction, free);
    if (done == 0) {
        pk_copy(e->sides, given, e->n_switches);
        done = pk_corner_leave(x, -direction, 1);
        if (done == 1 && pk_corner_speed(x) * direction > 0)
            done = 0;
    } else if (done == 1 && of_place && !(pk_corner_speed(x) * direction > 0)) {
        return refuse(x, k, TURNS, 0);
    }
    if (done != 1)
        return refuse(x, k, NEITHER, 0);
    pk_copy(x->start, x->v, w->n);
    return PK_DONE;
}

enum pk_status pk_impulse(struct pk_events *e, struct pk_integrator *it, const size_t *which,
                          const pk_real *side, size_t count)
{
    struct corner x = pk_corner_of(e, it);
    enum pk_status status = PK_DONE;
    x.w.u = pk_eval_input(it, e->t);
    pk_copy(x.first, x.start, e->n);
    pk_copy(x.sides, e->sides, e->n_switches);
    for (size_t i = 0; i < count && count > 1 && status >= 0; i++)
        status = one(&x, which[count - 1 - i], side[count - 1 - i]);
    if (count > 1) { /* repeats the impulses in the other order */
        pk_copy(x.first + e->n, x.start, e->n);
        pk_copy(x.start, x.first, e->n);
        pk_copy(e->sides, x.sides, e->n_switches);
    }
    for (size_t i = 0; i < count && status >= 0; i++)
        status = one(&x, which[i], side[i]);
    pk_real apart = 0, size = 0;
    for (size_t i = 0; count > 1 && i < x.w.m; i++) {
        apart = pk_max(apart, pk_abs(x.start[i] - x.first[e->n + i]));
        size = pk_max(size, pk_abs(x.start[i]));
    }
    if (status >= 0 && apart > AGREE * size)
        status = refuse(&x, which[0], ORDER, which[1]);
    if (status < 0)
        pk_copy(x.start, x.first, e->n);
    return status;
}

static const char *switch_name(const struct pk_system *system, size_t k)
{
    return k < system->switches.n ? system->switches.names[k].name : "x";
}

int pk_impulse_reason(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_system *system = it->problem.system;
    const struct pk_reason *reason = &it->reason;
    const char *name = switch_name(system, reason->index);
    const size_t kind = (size_t)reason->kind;
    char other[128] = "";
    if (kind <= ROLLING)
        pk_constraint_name(system, it->problem.params, reason->other, other, sizeof other);
    else if (kind == ORDER)
        snprintf(other, sizeof other, "%s", switch_name(system, reason->other));
    static const char *const why[] = {
        [POSITION] = "the constraint %s jumps where %s vanishes: no motion follows it",
        [ROLLING] = "what multiplies the rates in %s jumps where %s vanishes: what follows depends "
                    "on how",
        [BOTH_JUMP] = "%.0sa rolling and the energy both jump where %s vanishes: what follows "
                      "depends on how",
        [TURNS] = "%.0sthe impulse where %s vanishes turns the motion back, into the side that has "
                  "none: it would have to stay there",
        [ORDER] = "%s and %s vanish at once, and what follows depends on which does first",
        [NEITHER] = "%.0sno rates are found with which the motion leaves %s = 0",
    };
    return kind <= NEITHER ? pk_say(it, text, size, why[kind], other, name)
                           : pk_say(it, text, size, "%s", pk_status_text(it->status));
}
