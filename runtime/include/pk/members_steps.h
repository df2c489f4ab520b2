/* Steps of splitting methods with the accelerations of members: kicks v += h a and drifts q += h
 * v. Sums are not compensated.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_STEPS_H
#define PK_MEMBERS_STEPS_H

#define PK_STAGES 32 /* kicks and drifts in one pass over memory */
#define PK_MOST_CARRIED 64

/* Kicks and drifts the rows from .. to - 1, at most a chunk. `carried` has the values of terms
 * before the row `from` (none if `known` is 0), and then those before the row `to`. */
PK_PERHAPS static void pk_stage(const struct pk_members *x, const struct pk_vector *of, pk_real *e,
                                pk_real *carried, int known, ptrdiff_t from, ptrdiff_t to,
                                pk_real kappa, pk_real delta, pk_real *q, pk_real *v)
{
    struct pk_addition added[PK_MOST_ADDITIONS];
    const ptrdiff_t h = of->most - of->least;
    pk_real a[PK_BLOCK], *at = a;
    ptrdiff_t k;
    int g, i, n_added;

    for (i = 0; known && i < of->n_values; i++)
        for (k = 0; k < h; k++)
            e[i * of->width + k] = carried[i * h + k];
    n_added = pk_additions(x, of, e + of->n_values * of->width, added, NULL, from, to);
    pk_fill(x, of, from, to - from, known ? h : 0, e);
    for (g = 0; g < of->n_sets; g++) {
        const struct pk_row_set *set = of->sets + g;
        const ptrdiff_t *range = pk_range_of_family(x, set->family);
        const ptrdiff_t lo = pk_most(from, range[1]), n = pk_least(to, range[2] + 1) - lo;
        pk_real *const own_q = q + range[0] + lo - range[1], *const own_v = v + range[0] + lo -
                                                                            range[1];
        if (n <= 0)
            continue;
        if (!n_added) {
            set->kick(e + of->most + (lo - from), n, kappa, delta, own_q, own_v);
            continue;
        }
        (void)pk_some_rows(of, set, lo, lo + n, e + of->most + (lo - from), added, n_added, &at);
        for (k = 0; k < n; k++) {
            own_v[k] += kappa * a[k];
            own_q[k] += delta * own_v[k];
        }
    }
    for (i = 0; i < of->n_values; i++)
        for (k = 0; k < h; k++)
            carried[i * h + k] = e[i * of->width + (to - from) + k];
}

/* One pass over memory: `count` stages, each a kick by kappa[s] at time[s] and a drift by
 * delta[s]. Stage s follows stage s - 1 at a distance of `lag` rows. */
PK_PERHAPS static void pk_one_pass(struct pk_members *x, const struct pk_vector *of, pk_real *e,
                                   ptrdiff_t lag, int count, const pk_real *time,
                                   const pk_real *delta, const pk_real *kappa, pk_real *q,
                                   pk_real *v)
{
    pk_real carried[PK_STAGES][PK_MOST_CARRIED];
    ptrdiff_t first = PTRDIFF_MAX, end = PTRDIFF_MIN, done[PK_STAGES], begin;
    int g, s;

    for (g = 0; g < of->n_sets; g++) {
        first = pk_least(first, pk_range_of_family(x, of->sets[g].family)[1]);
        end = pk_most(end, pk_range_of_family(x, of->sets[g].family)[2] + 1);
    }
    for (s = 0; s < count; s++)
        done[s] = first;
    for (begin = first; done[count - 1] < end; begin += of->chunk)
        for (s = 0; s < count; s++) {
            const ptrdiff_t ahead = s == 0               ? begin + of->chunk
                                    : done[s - 1] == end ? end
                                                         : done[s - 1] - lag;
            const ptrdiff_t to = pk_least(ahead, end);
            ptrdiff_t from = done[s];
            if (to < end && end - to < lag && to - from > lag)
                /* The last `lag` rows are made in one call: rows beyond the end read them before
                 * they drift. */
                continue;
            x->t = time[s];
            for (; from < to; from = done[s]) {
                done[s] = pk_least(to, from + of->chunk);
                if (done[s] < to && to - done[s] < lag)
                    done[s] = to - lag;
                pk_stage(x, of, e, carried[s], from > first, from, done[s], kappa[s], delta[s], q,
                         v);
            }
        }
}

/* A kick and a drift of a ring. The `trail` rows at both ends, whose terms reach around it, are
 * kicked first and drift last. */
PK_PERHAPS static void pk_around(const struct pk_members *x, const struct pk_vector *of, pk_real *e,
                                 ptrdiff_t trail, pk_real kappa, pk_real delta, pk_real *q,
                                 pk_real *v)
{
    const ptrdiff_t *range = pk_range_of_family(x, of->sets[0].family);
    const ptrdiff_t first = range[1], end = range[2] + 1;
    const ptrdiff_t low = pk_least(first + trail, end), high = pk_most(low, end - trail);
    pk_real carried[PK_MOST_CARRIED];
    ptrdiff_t from, to, k;
    int g;

    if (low > first)
        pk_stage(x, of, e, carried, 0, first, low, kappa, 0, q, v);
    if (end > high)
        pk_stage(x, of, e, carried, 0, high, end, kappa, 0, q, v);
    for (from = low; from < high; from = to) {
        to = pk_least(high, from + of->chunk);
        pk_stage(x, of, e, carried, from > low, from, to, kappa, delta, q, v);
    }
    for (g = 0; g < of->n_sets; g++) {
        const ptrdiff_t place = pk_range_of_family(x, of->sets[g].family)[0] - first;
        for (k = first; k < end; k = k + 1 == low ? high : k + 1)
            q[place + k] += delta * v[place + k];
    }
}

/* Makes `steps` steps of h from time t, in place: kicks v += kick[i] h a(q, t) for i = 0 ..
 * stages, and drifts q += drift[i] h v between them. The last kick of a step and the first of the
 * next are one. e has the room that two of pk_compute() need; n is the number of coordinates.
 * With a lag, terms of rows from m on read no rows before m, and none m + lag or further; the
 * stages of several steps are then made in one pass over memory. Rings of equal length have minus
 * this lag. */
PK_PERHAPS static void pk_advance(struct pk_members *x, const struct pk_vector *of, pk_real *e,
                                  ptrdiff_t lag, int stages, const pk_real *kick,
                                  const pk_real *drift, pk_real t, pk_real h, unsigned long steps,
                                  ptrdiff_t n, pk_real *q, pk_real *v)
{
    const pk_real ends = kick[stages] * h;
    pk_real time[PK_STAGES], delta[PK_STAGES], kappa[PK_STAGES];
    unsigned long k;
    ptrdiff_t j;
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
            if (lag < 0) {
                x->t = time[0];
                pk_around(x, of, e, -lag, kappa[0], delta[0], q, v);
            } else if (!lag) {
                x->t = time[0];
                if (kappa[0] > 0 || kappa[0] < 0)
                    (void)pk_compute(x, of, e, &v, v, kappa[0]);
                for (j = 0; j < n; j++)
                    q[j] += delta[0] * v[j];
            } else if (++count == PK_STAGES) {
                pk_one_pass(x, of, e, lag, count, time, delta, kappa, q, v);
                count = 0;
            }
        }
    }
    if (count)
        pk_one_pass(x, of, e, lag, count, time, delta, kappa, q, v);
}

#endif
