/* Where an event's function crosses zero within a step. The interpolant only proposes times; nodes
 * are times with true values, by the method itself, and between two of opposite signs the root is
 * found (root.c). Where three samples lie on a parabola that dips towards zero, true values follow
 * it down, so that two crossings between samples are seen too.
 */
#include <string.h>

#include "events.h"
#include "root.h"

enum { MOST_NODES = PK_MOST_NODES, REFINEMENTS = 4 };

/* One event's function along the step, x from where it began. */
struct along {
    struct pk_events *e;
    struct pk_integrator *it;
    size_t k;
    pk_real x[MOST_NODES], g[MOST_NODES]; /* true values, in order */
    int count;
};

static enum pk_status truth(void *context, pk_real x, pk_real *y)
{
    struct along *a = (struct along *)context;
    struct pk_events *e = a->e;
    pk_real *g = pk_events_sample(e, e->samples + 1);
    const pk_real t = pk_events_time(e, a->it, x);
    if (pk_events_reach(e, a->it, t) < 0)
        return a->it->status;
    pk_events_functions(e, a->it, t, e->trial, e->trial + e->n, g);
    *y = g[a->k];
    return pk_finite(*y) ? PK_DONE : pk_events_not_finite(a->it, a->k);
}

static int opposite(pk_real a, pk_real b) { return !((a > 0 && b > 0) || (a < 0 && b < 0)); }

static void append(struct along *a, pk_real x, pk_real g)
{
    a->x[a->count] = x;
    a->g[a->count++] = g;
}

/* The true value at sample j, unless it is there already. */
static enum pk_status settle(struct along *a, int j)
{
    const pk_real h = pk_abs(a->it->t - a->e->from);
    const pk_real x = j == a->e->samples ? h : h * (pk_real)j / (pk_real)a->e->samples;
    pk_real g = pk_events_sample(a->e, j)[a->k];
    if (!(x > a->x[a->count - 1]))
        return PK_DONE;
    if (j < a->e->samples && truth(a, x, &g) < 0)
        return a->it->status;
    append(a, x, g);
    return PK_DONE;
}

/* Where the parabola through three points has its vertex. */
static pk_real vertex(const pk_real *x, const pk_real *g)
{
    const pk_real l = x[1] - x[0], r = x[2] - x[1], below = (g[1] - g[0]) / l;
    const pk_real above = (g[2] - g[1]) / r, bend = (above - below) / (l + r);
    return (x[0] + x[1]) / 2 - below / (2 * bend);
}

/* How much one function varies over the samples. */
static pk_real range(const struct along *a)
{
    pk_real least = pk_events_sample(a->e, 0)[a->k], most = least;
    for (int j = 1; j <= a->e->samples; j++) {
        const pk_real g = pk_events_sample(a->e, j)[a->k];
        least = pk_min(least, g);
        most = pk_max(most, g);
    }
    return most - least;
}

/* Whether the parabola through samples j - 1, j, j + 1 dips between samples i and i + 1, and where:
 * to less than half of what g has there, or to what the interpolant may hide (its error, of h^4, is
 * a small part of what g varies by, of h^2). */
static int dips(const struct along *a, int j, int i, pk_real *where)
{
    pk_real x[3], g[3];
    if (j < 1 || j >= a->e->samples)
        return 0;
    for (int l = 0; l < 3; l++) {
        x[l] = (pk_real)(j - 1 + l);
        g[l] = pk_events_sample(a->e, j - 1 + l)[a->k];
    }
    const pk_real bend = (g[2] - 2 * g[1] + g[0]) / 2;
    if (!(bend * g[1] > 0))
        return 0;
    const pk_real at = vertex(x, g), sign = g[1] > 0 ? PK_C(1.0) : PK_C(-1.0);
    const pk_real low = sign * (g[1] - bend * (at - x[1]) * (at - x[1]));
    const pk_real left = pk_events_sample(a->e, i)[a->k];
    const pk_real right = pk_events_sample(a->e, i + 1)[a->k];
    if (!(at > (pk_real)i && at < (pk_real)(i + 1)) ||
        !((low < sign * left / 2 && low < sign * right / 2) || low < range(a) / 32))
        return 0;
    *where = pk_abs(a->it->t - a->e->from) * at / (pk_real)a->e->samples;
    return 1;
}

/* True values down a dip that begins at x, by its parabola, until one has crossed. */
static enum pk_status descend(struct along *a, int i, pk_real at)
{
    pk_real x[3], g[3];
    if (settle(a, i) < 0)
        return a->it->status;
    x[0] = a->x[a->count - 1];
    g[0] = a->g[a->count - 1];
    x[1] = at;
    x[2] = pk_abs(a->it->t - a->e->from) * (pk_real)(i + 1) / (pk_real)a->e->samples;
    g[2] = pk_events_sample(a->e, i + 1)[a->k];
    if (truth(a, x[1], &g[1]) < 0)
        return a->it->status;
    for (int l = 0; l < REFINEMENTS && !opposite(g[0], g[1]); l++) {
        const pk_real next = vertex(x, g);
        pk_real y;
        if (!(next > x[0] && next < x[2]) || !(next < x[1] || next > x[1]))
            break;
        if (truth(a, next, &y) < 0)
            return a->it->status;
        const int outer = next < x[1] ? 2 : 0; /* the end that the new point replaces */
        if (pk_abs(y) < pk_abs(g[1])) {
            x[outer] = x[1];
            g[outer] = g[1];
            x[1] = next;
            g[1] = y;
        } else {
            x[2 - outer] = next;
            g[2 - outer] = y;
        }
    }
    if (opposite(g[0], g[1]) && x[1] > a->x[a->count - 1])
        append(a, x[1], g[1]);
    return PK_DONE;
}

/* True values at as many times as show each crossing between two of them. */
static enum pk_status nodes(struct along *a)
{
    const struct pk_events *e = a->e;
    a->count = 0;
    append(a, 0, pk_events_sample(e, 0)[a->k]);
    for (int j = 0; j < e->samples; j++) {
        const pk_real left = pk_events_sample(e, j)[a->k], right = pk_events_sample(e, j + 1)[a->k];
        pk_real x;
        enum pk_status status = PK_DONE;
        if (!pk_finite(left) || !pk_finite(right))
            continue; /* the interpolant is outside of where g has values */
        if (opposite(left, right)) {
            status = settle(a, j);
            if (status >= 0)
                status = settle(a, j + 1);
        } else if (dips(a, j, j, &x) || dips(a, j + 1, j, &x)) {
            status = descend(a, j, x);
        }
        if (status < 0)
            return status;
    }
    return settle(a, e->samples);
}

/* Puts a crossing into the list, behind those that are met before it. */
static void enlist(struct pk_events *e, const struct along *a, pk_real x, int direction)
{
    const struct pk_event *events = a->it->problem.system->events;
    const int asked = a->k < e->n_events ? events[a->k].direction : 0;
    size_t at = PK_EVENT_ENTRY * e->listed++;
    if (asked && asked != direction) {
        e->listed--;
        return;
    }
    for (; at > 0 && e->list[at - PK_EVENT_ENTRY] > x; at -= PK_EVENT_ENTRY)
        memcpy(e->list + at, e->list + at - PK_EVENT_ENTRY, PK_EVENT_ENTRY * sizeof *e->list);
    e->list[at] = x;
    e->list[at + 1] = (pk_real)a->k;
    e->list[at + 2] = (pk_real)direction;
}

enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k)
{
    struct along a = {.e = e, .it = it, .k = k};
    const pk_real width = pk_events_width(e, it);
    if (nodes(&a) < 0)
        return it->status;
    for (int j = 1; j < a.count; j++) {
        pk_real lo = a.x[j - 1], hi = a.x[j];
        const pk_real before = a.g[j - 1], after = a.g[j];
        if (!(before > 0 || before < 0) || !opposite(before, after))
            continue; /* from zero nothing crosses it */
        if ((after > 0 || after < 0) &&
            pk_root(truth, &a, &lo, before, &hi, after, width) < 0)
            return it->status;
        enlist(e, &a, hi, before < 0 ? it->direction : -it->direction);
    }
    return PK_DONE;
}
