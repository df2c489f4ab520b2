/* Steps of splitting methods with the accelerations of members: kicks v += h a and drifts q += h
 * v. Sums are not compensated.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_STEPS_H
#define PK_MEMBERS_STEPS_H

#include <pk/members_rows.h>

#define PK_STAGES 32 /* kicks and drifts in one pass over memory */
#define PK_MOST_CARRIED 64

/* The rows of an acceleration that depends on coordinates alone. kick() makes v += kappa a and q
 * += delta v for the rows from .. from + n - 1 of all families, n at most `chunk`. The first
 * `known` columns of e have the values of terms already. drift() makes q += delta v alone. */
struct pk_kicks {
    void (*kick)(const struct pk_members *x, ptrdiff_t from, ptrdiff_t n, ptrdiff_t known,
                 pk_real *e, pk_real kappa, pk_real delta, pk_real *q, pk_real *v);
    void (*drift)(const struct pk_members *x, ptrdiff_t from, ptrdiff_t n, pk_real delta,
                  pk_real *q, const pk_real *v);
    ptrdiff_t first, end; /* rows */
    /* e has `values` rows of `width` columns, `halo` of them for terms before the first row. */
    ptrdiff_t chunk, halo, width;
    int values;
};

/* Kicks and drifts the rows from .. to - 1, at most a chunk. `carried` has the values of terms
 * before the row `from` (none if `known` is 0), and then those before the row `to`. */
PK_PERHAPS static void pk_stage(const struct pk_members *x, const struct pk_kicks *of, pk_real *e,
                                pk_real *carried, int known, ptrdiff_t from, ptrdiff_t to,
                                pk_real kappa, pk_real delta, pk_real *q, pk_real *v)
{
    const ptrdiff_t h = of->halo;
    ptrdiff_t k;
    int i;

    for (i = 0; known && i < of->values; i++)
        for (k = 0; k < h; k++)
            e[i * of->width + k] = carried[i * h + k];
    of->kick(x, from, to - from, known ? h : 0, e, kappa, delta, q, v);
    for (i = 0; i < of->values; i++)
        for (k = 0; k < h; k++)
            carried[i * h + k] = e[i * of->width + (to - from) + k];
}

/* One pass over memory: `count` stages, each a kick by kappa[s] at time[s] and a drift by
 * delta[s]. Stage s follows stage s - 1 at a distance of `lag` rows. */
PK_PERHAPS static void pk_one_pass(struct pk_members *x, const struct pk_kicks *of, pk_real *e,
                                   ptrdiff_t lag, int count, const pk_real *time,
                                   const pk_real *delta, const pk_real *kappa, pk_real *q,
                                   pk_real *v)
{
    pk_real carried[PK_STAGES][PK_MOST_CARRIED];
    const ptrdiff_t end = of->end;
    ptrdiff_t done[PK_STAGES], begin;
    int s;

    for (s = 0; s < count; s++)
        done[s] = of->first;
    for (begin = of->first; done[count - 1] < end; begin += of->chunk)
        for (s = 0; s < count; s++) {
            const ptrdiff_t ahead = s == 0               ? begin + of->chunk
                                    : done[s - 1] == end ? end
                                                         : done[s - 1] - lag;
            const ptrdiff_t to = pk_least(ahead, end);
            ptrdiff_t from = done[s];
            if (to < end && end - to < lag && to - from > lag)
                /* One call makes the last `lag` rows. Rows beyond the end then read them before
                 * they drift. */
                continue;
            x->t = time[s];
            for (; from < to; from = done[s]) {
                done[s] = pk_least(to, from + of->chunk);
                if (done[s] < to && to - done[s] < lag)
                    done[s] = to - lag;
                pk_stage(x, of, e, carried[s], from > of->first, from, done[s], kappa[s], delta[s],
                         q, v);
            }
        }
}

/* A kick and a drift of a ring. The `trail` rows at both ends, whose terms reach around it, are
 * kicked first and drift last. */
PK_PERHAPS static void pk_around(const struct pk_members *x, const struct pk_kicks *of, pk_real *e,
                                 ptrdiff_t trail, pk_real kappa, pk_real delta, pk_real *q,
                                 pk_real *v)
{
    const ptrdiff_t first = of->first, end = of->end;
    const ptrdiff_t low = pk_least(first + trail, end), high = pk_most(low, end - trail);
    pk_real carried[PK_MOST_CARRIED];
    ptrdiff_t from, to;

    if (low > first)
        pk_stage(x, of, e, carried, 0, first, low, kappa, 0, q, v);
    if (end > high)
        pk_stage(x, of, e, carried, 0, high, end, kappa, 0, q, v);
    for (from = low; from < high; from = to) {
        to = pk_least(high, from + of->chunk);
        pk_stage(x, of, e, carried, from > low, from, to, kappa, delta, q, v);
    }
    of->drift(x, first, low - first, delta, q, v);
    of->drift(x, high, end - high, delta, q, v);
}

/* Makes `steps` steps of h from time t, in place: kicks v += kick[i] h a(q, t) for i = 0 ..
 * stages, and drifts q += drift[i] h v between them. The last kick of a step and the first of the
 * next are one. lag > 0: the terms of row m read rows m .. m + lag - 1 alone; several stages share
 * a pass over memory. lag < 0: rings of equal length; a stage is a pass. lag = 0: each kick is a
 * pass, and so is each drift. */
PK_PERHAPS static void pk_advance(struct pk_members *x, const struct pk_kicks *of, pk_real *e,
                                  ptrdiff_t lag, int stages, const pk_real *kick,
                                  const pk_real *drift, pk_real t, pk_real h, unsigned long steps,
                                  pk_real *q, pk_real *v)
{
    const pk_real ends = kick[stages] * h;
    pk_real time[PK_STAGES], delta[PK_STAGES], kappa[PK_STAGES];
    ptrdiff_t from, to;
    unsigned long k;
    int i, count = 0;

    for (k = 0; k <= steps && steps; k++) {
        pk_real done = 0; /* fraction of the step drifted so far */
        for (i = 0; i < (k < steps ? stages : ends > 0 || ends < 0); i++) {
            time[count] = t + (pk_real)k * h + done * h;
            kappa[count] = i            ? kick[i] * h
                           : k == steps ? ends
                           : k > 0      ? ends + kick[0] * h
                                        : kick[0] * h;
            delta[count] = k < steps ? drift[i] * h : 0;
            done += k < steps ? drift[i] : 0;
            if (lag > 0) {
                if (++count == PK_STAGES) {
                    pk_one_pass(x, of, e, lag, count, time, delta, kappa, q, v);
                    count = 0;
                }
                continue;
            }
            x->t = time[0];
            if (lag < 0) {
                pk_around(x, of, e, -lag, kappa[0], delta[0], q, v);
                continue;
            }
            for (from = of->first; (kappa[0] > 0 || kappa[0] < 0) && from < of->end; from = to) {
                to = pk_least(of->end, from + of->chunk);
                of->kick(x, from, to - from, 0, e, kappa[0], 0, q, v);
            }
            of->drift(x, of->first, of->end - of->first, delta[0], q, v);
        }
    }
    if (count)
        pk_one_pass(x, of, e, lag, count, time, delta, kappa, q, v);
}

#endif
