/* Locates the roots of an event function g within a window, which is the whole step or a part of
 * it. The polynomial through samples of the interpolant only proposes times. Nodes are times at
 * which the method itself gives exact values, and a root is found between two nodes where g has
 * opposite signs (root.c). Where the polynomial has a minimum of |g| near zero, more nodes are
 * computed towards this minimum, so that two close roots are found too. */

#include "events.h"
#include <pk/root.h>

enum { MOST_NODES = PK_MOST_NODES, REFINEMENTS = 96, PIECES = 3 };
#define NEARLY PK_C(1e-3) /* a polynomial with a smaller tail, relative to the range, is accurate */
#define MARGIN PK_C(0.03125) /* error of an interpolant, relative to the range of g */
/* accuracy of the angle, in radians, at which the polynomial is extremal */
#define TURNED PK_C(1e-7)

/* Returns the value of |g| below which g may be 0: the error of the interpolant plus that of the
 * polynomial, which matters at a kink of g. */
static pk_real near_zero(const struct pk_shape *shape)
{
    return MARGIN * shape->range + (pk_real)shape->order / 2 * shape->tail;
}

/* One event function along the window; x is the time from the start of the step. */
struct along {
    struct pk_events *e;
    struct pk_integrator *it;
    const struct pk_shape *shape;
    size_t k;
    pk_real x[MOST_NODES], g[MOST_NODES]; /* nodes: times and exact values, in order */
    int count;
};

/* A point of the polynomial sum c_k cos(k angle), whose angle goes from 0 at the start of the
 * window to pi at its end. `slope` is the derivative of g by the angle up to a positive factor. */
struct point {
    pk_real x, g, slope;
};

static enum pk_status truth(void *context, pk_real x, pk_real *y)
{
    struct along *a = (struct along *)context;
    struct pk_events *e = a->e;
    pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    const pk_real t = pk_events_time(e, a->it, x);
    if (!(x < pk_abs(a->it->t - e->from))) {
        *y = pk_events_end(e, 1)[a->k];
        return PK_DONE;
    }
    PK_TRY(pk_events_reach(e, a->it, t));
    pk_events_functions(e, a->it, t, e->trial, e->trial_v, g);
    *y = g[a->k];
    return pk_finite(*y) ? PK_DONE : pk_events_not_finite(a->it, a->k);
}

static int opposite(pk_real a, pk_real b) { return !((a > 0 && b > 0) || (a < 0 && b < 0)); }

static void append(struct along *a, pk_real x, pk_real g)
{
    if (a->count == MOST_NODES)
        return;
    a->x[a->count] = x;
    a->g[a->count++] = g;
}

/* Gets the exact value of g at x. The values of all functions are cached for two times: the last x,
 * and the time just after the first switch in the list. */
static enum pk_status shared(struct along *a, pk_real x, int first, pk_real *y)
{
    struct pk_events *e = a->e;
    pk_real *const known = first ? e->at_near : e->at_last;
    pk_real *const at = first ? &e->near_known : &e->last;
    if (x < *at || x > *at) {
        *at = -1;
        PK_TRY(truth(a, x, y));
        if (!(x < pk_abs(a->it->t - e->from)))
            return PK_DONE;
        pk_copy(known, pk_events_sample(e, PK_MOST_SAMPLES + 1), pk_events_count(e));
        *at = x;
    }
    *y = known[a->k];
    return pk_finite(*y) ? PK_DONE : pk_events_not_finite(a->it, a->k);
}

/* Adds a node at x, unless x is before the last node. Crossings after the first switch in the list
 * are not searched for, so that the last node is just after this switch. */
static enum pk_status settle(struct along *a, pk_real x)
{
    const int behind = x > a->e->near;
    pk_real g;
    x = behind ? a->e->near : x;
    if (!(x > a->x[a->count - 1]))
        return PK_DONE;
    PK_TRY(shared(a, x, behind, &g));
    append(a, x, g);
    return PK_DONE;
}

static struct point at_angle(const struct along *a, pk_real angle)
{
    const pk_real c = PK_F(cos)(angle);
    struct point found = {a->e->at + a->e->width * (1 - c) / 2, a->shape->c[0], 0};
    pk_real T = c, T_before = 1, U = 1, U_before = 0; /* Chebyshev polynomials */
    for (int i = 1; i <= a->shape->order; i++) {
        const pk_real next_T = 2 * c * T - T_before, next_U = 2 * c * U - U_before;
        found.g += a->shape->c[i] * T;
        found.slope -= (pk_real)i * a->shape->c[i] * U;
        T_before = T, T = next_T;
        U_before = U, U = next_U;
    }
    return found;
}

/* Returns the vertex of the parabola through three points. */
static pk_real vertex(const pk_real *x, const pk_real *g)
{
    const pk_real l = x[1] - x[0], r = x[2] - x[1], below = (g[1] - g[0]) / l;
    const pk_real above = (g[2] - g[1]) / r, bend = (above - below) / (l + r);
    return (x[0] + x[1]) / 2 - below / (2 * bend);
}

/* Returns whether a convex function through three points, with its least value in the middle, may
 * reach zero. It does not if the two chords, extended beyond the middle, do not reach zero, since
 * the function lies above them. */
static int may_cross(const pk_real *x, const pk_real *g)
{
    const pk_real l = x[1] - x[0], r = x[2] - x[1], sign = g[1] > 0 ? 1 : -1;
    return sign * g[1] <= sign * (g[2] - g[1]) * (l / r) ||
           sign * g[1] <= sign * (g[0] - g[1]) * (r / l);
}

/* Returns whether a point is between x[0] and x[2], and not x[1]. */
static int is_between(const pk_real *x, pk_real at)
{
    return at > x[0] && at < x[2] && (at < x[1] || at > x[1]);
}

/* Searches for the minimum of |g| near `at` until some value of g has the opposite sign. Uses
 * parabolas and, since the minimum may be a kink, golden sections of the longer interval. */
static enum pk_status descend(struct along *a, pk_real left, pk_real at, pk_real right)
{
    pk_real x[3] = {left, at, right}, g[3];
    PK_TRY(settle(a, left));
    x[0] = a->x[a->count - 1];
    g[0] = a->g[a->count - 1];
    if (!(at > x[0]) || !(right > at))
        return PK_DONE;
    PK_TRY(truth(a, at, &g[1]));
    PK_TRY(truth(a, right, &g[2]));
    for (int l = 0; l < REFINEMENTS && !opposite(g[0], g[1]) && may_cross(x, g); l++) {
        const pk_real longer = x[2] - x[1] > x[1] - x[0] ? x[2] : x[0];
        pk_real next = l % 3 < 2 ? vertex(x, g) : x[1] + (longer - x[1]) * PK_C(0.382), y;
        if (!is_between(x, next))
            next = x[1] + (longer - x[1]) * PK_C(0.382);
        if (!is_between(x, next))
            break;
        PK_TRY(truth(a, next, &y));
        const int outer = next < x[1] ? 2 : 0; /* the new point replaces this end */
        if (opposite(y, g[1]) || pk_abs(y) < pk_abs(g[1])) {
            x[outer] = x[1];
            g[outer] = g[1];
            x[1] = next;
            g[1] = y;
        } else {
            x[2 - outer] = next;
            g[2 - outer] = y;
        }
    }
    if (!opposite(g[0], g[1]))
        return PK_DONE;
    if (x[1] > a->x[a->count - 1])
        append(a, x[1], g[1]);
    return settle(a, right);
}

static enum pk_status slope_at(void *context, pk_real angle, pk_real *slope)
{
    *slope = at_angle((const struct along *)context, angle).slope;
    return PK_DONE;
}

/* Returns the extremum of the polynomial between two angles with slopes of opposite signs. */
static struct point turn(struct along *a, pk_real from, pk_real to)
{
    pk_root(slope_at, a, &from, at_angle(a, from).slope, &to, at_angle(a, to).slope, TURNED);
    return at_angle(a, to);
}

/* Adds nodes that separate the crossings between two points of the polynomial. */
static enum pk_status piece(struct along *a, pk_real from, pk_real to, struct point l,
                            struct point r, pk_real bow)
{
    const pk_real sign = l.g > 0 ? 1 : -1, margin = near_zero(a->shape);
    if (opposite(l.g, r.g))
        return settle(a, l.x) < 0 ? a->it->status : settle(a, r.x);
    if (pk_min(sign * l.g, sign * r.g) > bow + margin || sign * l.slope >= 0 || sign * r.slope <= 0)
        return PK_DONE;
    const struct point least = turn(a, from, to);
    if (!(sign * least.g < margin))
        return PK_DONE;
    /* A kink is near the extremum of the polynomial, not exactly there. */
    const struct point before = at_angle(a, pk_max(2 * from - to, 0));
    const struct point behind = at_angle(a, pk_min(2 * to - from, PK_PI));
    return descend(a, sign * before.g > sign * l.g ? before.x : l.x, least.x,
                   sign * behind.g > sign * r.g ? behind.x : r.x);
}

/* Adds nodes that separate the crossings between samples j and j + 1. */
static enum pk_status interval(struct along *a, int j)
{
    const int N = a->shape->order, stride = PK_MOST_SAMPLES / N;
    const pk_real step = PK_PI / (pk_real)N, from = step * (pk_real)j;
    const pk_real left = pk_events_sample(a->e, j * stride)[a->k];
    const pk_real right = pk_events_sample(a->e, (j + 1) * stride)[a->k];
    const pk_real near = pk_min(pk_abs(left), pk_abs(right));
    pk_real bow = 0; /* largest distance of the polynomial from its chord */
    for (int i = 1; i <= N; i++)
        bow += (pk_real)(i * i) * pk_abs(a->shape->c[i]);
    bow *= step * step / 8;
    if (!opposite(left, right) && near > bow + near_zero(a->shape))
        return PK_DONE;
    struct point l = at_angle(a, from);
    l.g = left;
    l.x = pk_events_node(a->e, j * stride);
    for (int i = 0; i < PIECES; i++) {
        const pk_real start = from + step * (pk_real)i / PIECES;
        const pk_real end = from + step * (pk_real)(i + 1) / PIECES;
        struct point r = at_angle(a, end);
        if (i + 1 == PIECES) {
            r.g = right;
            r.x = pk_events_node(a->e, (j + 1) * stride);
        }
        PK_TRY(piece(a, start, end, l, r, bow / (PIECES * PIECES)));
        l = r;
    }
    return PK_DONE;
}

/* Computes nodes such that each crossing is between two of them. */
static enum pk_status nodes(struct along *a)
{
    const struct pk_events *e = a->e;
    const struct pk_shape *shape = a->shape;
    const int stride = PK_MOST_SAMPLES / shape->order;
    const pk_real end = e->at + e->width, h = pk_abs(a->it->t - e->from);
    const pk_real last = pk_events_sample(e, PK_MOST_SAMPLES)[a->k];
    a->count = 0;
    append(a, shape->last_x, shape->last_g);
    for (int j = 0; shape->crosses && j < shape->order; j++) {
        if (pk_events_node(e, j * stride) > e->near)
            break;
        const pk_real left = pk_events_sample(e, j * stride)[a->k];
        const pk_real right = pk_events_sample(e, (j + 1) * stride)[a->k];
        if (!pk_finite(left) || !pk_finite(right))
            continue; /* g is not finite on the interpolant */
        /* a polynomial that is not accurate may cross zero elsewhere than between these samples */
        const int apart = opposite(left, right) && !(shape->tail <= NEARLY * shape->range);
        if (apart)
            PK_TRY(settle(a, pk_events_node(e, j * stride)));
        if (shape->clear)
            PK_TRY(interval(a, j));
        if (apart)
            PK_TRY(settle(a, pk_events_node(e, (j + 1) * stride)));
    }
    if (!(end < h) || (pk_finite(last) && (opposite(last, a->g[a->count - 1]) ||
                                           pk_abs(last) <= MARGIN * shape->range))) {
        PK_TRY(settle(a, end));
        if (end < h && a->count > 1 && !(a->g[a->count - 1] > 0 || a->g[a->count - 1] < 0))
            a->count--; /* leaves a zero at the end of the window to the next window */
    }
    return PK_DONE;
}

/* Inserts a crossing into the list, in the order of the motion, up to the first switch. */
static void enlist(struct pk_events *e, const struct along *a, pk_real x, int direction)
{
    const struct pk_event *events = a->it->problem.system->events.table;
    /* the direction of a limit is along the motion */
    const int limit = a->k < e->n_events && events[a->k].stop > 1;
    const int asked = (a->k < e->n_events ? events[a->k].direction : 0) *
                      (limit ? a->it->own->direction : 1);
    if ((asked && asked != direction) || x > e->near)
        return;
    const pk_real near = x + pk_events_width(e, a->it, x);
    if (a->k >= e->n_events && near < e->near) {
        e->near = near;
        while (e->listed && e->list[PK_EVENT_ENTRY * (e->listed - 1)] > e->near)
            e->listed--;
    }
    if (e->listed == e->most_listed)
        return;
    size_t at = PK_EVENT_ENTRY * e->listed++;
    for (; at > 0 && e->list[at - PK_EVENT_ENTRY] > x; at -= PK_EVENT_ENTRY)
        pk_copy(e->list + at, e->list + at - PK_EVENT_ENTRY, PK_EVENT_ENTRY);
    e->list[at] = x;
    e->list[at + 1] = (pk_real)a->k;
    e->list[at + 2] = (pk_real)direction;
}

enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k)
{
    struct along a = {.e = e, .it = it, .k = k, .shape = &e->shapes[k]};
    PK_TRY(nodes(&a));
    for (int j = 1; j < a.count; j++) {
        pk_real lo = a.x[j - 1], hi = a.x[j];
        const pk_real before = a.g[j - 1], after = a.g[j];
        if (!(before > 0 || before < 0) || !opposite(before, after))
            continue; /* a motion that starts at zero does not cross zero */
        if (!(after > 0 || after < 0) && j + 1 < a.count && !opposite(before, a.g[j + 1]))
            continue; /* g touches zero without changing its sign */
        if (after > 0 || after < 0)
            PK_TRY(pk_root(truth, &a, &lo, before, &hi, after, pk_events_width(e, it, lo)));
        enlist(e, &a, hi, before < 0 ? it->own->direction : -it->own->direction);
    }
    e->shapes[k].last_x = a.x[a.count - 1];
    e->shapes[k].last_g = a.g[a.count - 1];
    return PK_DONE;
}
