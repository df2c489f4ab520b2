/* Sums of terms over the members of families, such as sum(f(q[i], q[i+1]), i = 0..N): the values
 * of kernels, for every length of the families.
 *
 * A model has a function for each term, which computes its values for n successive members at
 * once. Tables say what it reads (struct pk_slot), over which members it runs (struct pk_terms),
 * and to what its values are added. A scalar is a family of one member, whose index is 0. An
 * index beyond the ends of a family stands for a member (a free or periodic end) or has a given
 * value.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_H
#define PK_MEMBERS_H

#ifdef __GNUC__
#define PK_PERHAPS __attribute__((unused))
#else
#define PK_PERHAPS
#endif
#define PK_BLOCK 512      /* the most members at a time */
#define PK_MOST_SLOTS 256 /* the most numbers that terms read, and the most values */
#define PK_LANES_IN_A_ROW 64

/* The ends of a family. A ring continues with its own members. A free end repeats the last
 * member, for so many indices. Its range is in the array `at`: the number of its first member in
 * arrays, its least and its greatest index. */
struct pk_family {
    int ring, free_below, free_above;
};

enum pk_array {
    PK_OF_Q,
    PK_OF_V,
    PK_OF_ZERO,
    PK_OF_A,
    PK_OF_RATED,
    PK_OF_P,
    PK_OF_LETS,
    PK_OF_LAMBDA,
    PK_OF_SIDES,
    PK_ARRAYS
};

/* The state and the model that a kernel is called with. */
struct pk_members {
    const void *params;
    const struct pk_family *families;
    const ptrdiff_t *at; /* 3 numbers for each family; ends of ranges; indices */
    /* the value (order 0), rate (1) or acceleration (2) of a given member */
    pk_real (*given)(const struct pk_members *x, int family, int order, ptrdiff_t i);
    pk_real t;
    const pk_real *u;
    const pk_real *arrays[PK_ARRAYS];
};

/* A number that terms read: the member with index of_m * m + of_j * j + shift + at[extra] of a
 * family; `extra` is 0 if there is none. A given member has no place in an array: given() returns
 * its derivative of that order. The order -1 means 0. */
struct pk_slot {
    enum pk_array array;
    int order, family, of_m, of_j;
    ptrdiff_t shift;
    int extra;
};

/* Terms with the indices m = at[over] .. at[over + 1]; those of pairs have j = at[over + 2] +
 * first * m .. at[over + 3] + last * m too. values() writes the values of n successive members,
 * from m on (of pairs: from j on) to o[0], o[1], ... It returns nonzero if they are invalid,
 * since an angle was too large; it is then called again with PK_CAREFULLY. */
typedef pk_bits pk_values(const struct pk_members *x, enum pk_pass pass, ptrdiff_t m, ptrdiff_t j,
                          ptrdiff_t n, const pk_real *const *s, pk_real *const *o);
struct pk_terms {
    pk_values *values;
    const struct pk_slot *slots;
    int n_slots, n_values, over, pairs, first, last;
};

/* PK_TERM(name) begins the function of one member, PK_TERMS(name) defines the loop over it. A
 * PK_SEQUENCE reads what it has written for members before. */
#define PK_TERM(name)                                                                        \
    PK_INLINE static pk_bits name##_at(PK_PERHAPS const struct pk_members *x,                \
                                       PK_PERHAPS enum pk_pass pass, PK_PERHAPS ptrdiff_t m, \
                                       PK_PERHAPS ptrdiff_t j, PK_PERHAPS ptrdiff_t k,       \
                                       PK_PERHAPS const pk_real *const *s, pk_real *const *o)
#define PK_TERMS_(name, lanes, of_m, of_j)                                                       \
    static pk_bits name(const struct pk_members *x, enum pk_pass pass, ptrdiff_t m, ptrdiff_t j, \
                        ptrdiff_t n, const pk_real *const *s, pk_real *const *o)                 \
    {                                                                                            \
        pk_bits far = 0;                                                                         \
        ptrdiff_t k = 0, l;                                                                      \
        if (pass == PK_CAREFULLY) {                                                              \
            for (; k < n; k++)                                                                   \
                (void)name##_at(x, PK_CAREFULLY, m + (of_m) * k, j + (of_j) * k, k, s, o);       \
            return 0;                                                                            \
        }                                                                                        \
        for (; k + PK_LANES_IN_A_ROW <= n; k += PK_LANES_IN_A_ROW) {                             \
            lanes for (l = k; l < k + PK_LANES_IN_A_ROW; l++)                                    \
                far |= name##_at(x, PK_IN_LANE, m + (of_m) * l, j + (of_j) * l, l, s, o);        \
        }                                                                                        \
        for (; k < n; k++)                                                                       \
            far |= name##_at(x, PK_IN_LANE, m + (of_m) * k, j + (of_j) * k, k, s, o);            \
        return far;                                                                              \
    }
#define PK_TERMS(name) PK_TERMS_(name, PK_LANE_LOOP, 1, 0)
#define PK_PAIRS(name) PK_TERMS_(name, PK_LANE_LOOP, 0, 1)
#define PK_SEQUENCE(name) PK_TERMS_(name, , 1, 0)

static const pk_real pk_zeros[PK_BLOCK] = {0};

PK_INLINE static ptrdiff_t pk_most(ptrdiff_t a, ptrdiff_t b) { return a > b ? a : b; }

PK_INLINE static ptrdiff_t pk_least(ptrdiff_t a, ptrdiff_t b) { return a < b ? a : b; }

/* The range of a family: number of the first member in arrays, least and greatest index. */
PK_INLINE static const ptrdiff_t *pk_range_of_family(const struct pk_members *x, int family)
{
    return x->at + 3 * family;
}

/* The index of the member that index i stands for; one below the least if it is given. */
PK_PERHAPS static ptrdiff_t pk_home(const struct pk_members *x, int family, ptrdiff_t i)
{
    const ptrdiff_t lo = x->at[3 * family + 1], hi = x->at[3 * family + 2];
    const struct pk_family *of = x->families + family;

    if (i >= lo && i <= hi)
        return i;
    if (of->ring) {
        const ptrdiff_t n = hi - lo + 1, r = (i - lo) % n;
        return lo + (r < 0 ? r + n : r);
    }
    if (i < lo)
        return i + of->free_below >= lo ? lo : lo - 1;
    return i - of->free_above <= hi ? hi : lo - 1;
}

PK_PERHAPS static ptrdiff_t pk_index(const struct pk_members *x, const struct pk_slot *of,
                                     ptrdiff_t m, ptrdiff_t j)
{
    return of->of_m * m + of->of_j * j + of->shift + (of->extra ? x->at[of->extra] : 0);
}

/* The value of a slot at m, j. */
PK_PERHAPS static pk_real pk_read(const struct pk_members *x, const struct pk_slot *of, ptrdiff_t m,
                                  ptrdiff_t j)
{
    const ptrdiff_t *range = pk_range_of_family(x, of->family);
    ptrdiff_t i = pk_index(x, of, m, j);

    if (i < range[1] || i > range[2]) {
        const ptrdiff_t home = pk_home(x, of->family, i);
        if (home < range[1])
            return of->order < 0 ? 0 : x->given(x, of->family, of->order, i);
        i = home;
    }
    return of->array == PK_OF_ZERO ? 0 : x->arrays[of->array][range[0] + i - range[1]];
}

/* Writes the values of the member m, or of the pair m, j, to o[0][k], o[1][k], ... */
PK_PERHAPS static void pk_one(const struct pk_members *x, const struct pk_terms *of, ptrdiff_t m,
                              ptrdiff_t j, ptrdiff_t k, pk_real *const *o)
{
    pk_real read[PK_MOST_SLOTS], *to[PK_MOST_SLOTS];
    const pk_real *s[PK_MOST_SLOTS];
    int i;

    for (i = 0; i < of->n_slots; i++) {
        read[i] = pk_read(x, of->slots + i, m, j);
        s[i] = read + i;
    }
    for (i = 0; i < of->n_values; i++)
        to[i] = o[i] + k;
    if (of->values(x, PK_IN_LANE, m, j, 1, s, to))
        (void)of->values(x, PK_CAREFULLY, m, j, 1, s, to);
}

/* Narrows lo .. hi to the m whose slot is an existing member. */
PK_PERHAPS static void pk_inside(const struct pk_members *x, const struct pk_slot *of,
                                 ptrdiff_t *lo, ptrdiff_t *hi)
{
    const ptrdiff_t *range = pk_range_of_family(x, of->family);
    const ptrdiff_t shift = pk_index(x, of, 0, 0);

    if (of->of_m == 1) {
        *lo = pk_most(*lo, range[1] - shift);
        *hi = pk_least(*hi, range[2] - shift);
    } else if (of->of_m == -1) {
        *lo = pk_most(*lo, shift - range[2]);
        *hi = pk_least(*hi, shift - range[1]);
    } else if (of->of_m || shift < range[1] || shift > range[2]) {
        *hi = *lo - 1; /* read one by one */
    }
}

/* Writes the values of the members from .. to - 1, at most PK_BLOCK, to o[..][0], o[..][1], ... */
PK_PERHAPS static void pk_evaluate(const struct pk_members *x, const struct pk_terms *of,
                                   ptrdiff_t from, ptrdiff_t to, pk_real *const *o)
{
    ptrdiff_t lo = from, hi = to - 1, m;
    pk_real *into[PK_MOST_SLOTS];
    const pk_real *s[PK_MOST_SLOTS];
    int i;

    for (i = 0; i < of->n_slots; i++)
        pk_inside(x, of->slots + i, &lo, &hi);
    for (m = from; m < to && (m < lo || lo > hi); m++)
        pk_one(x, of, m, 0, m - from, o);
    if (m >= to)
        return;
    for (i = 0; i < of->n_slots; i++) {
        const struct pk_slot *slot = of->slots + i;
        const ptrdiff_t *range = pk_range_of_family(x, slot->family);
        s[i] = slot->array == PK_OF_ZERO
                   ? pk_zeros
                   : x->arrays[slot->array] + range[0] + pk_index(x, slot, lo, 0) - range[1];
    }
    for (i = 0; i < of->n_values; i++)
        into[i] = o[i] + (lo - from);
    if (of->values(x, PK_IN_LANE, lo, 0, hi - lo + 1, s, into))
        (void)of->values(x, PK_CAREFULLY, lo, 0, hi - lo + 1, s, into);
    for (m = hi + 1; m < to; m++)
        pk_one(x, of, m, 0, m - from, o);
}

/* -- vectors --------------------------------------------------------------------------------- */

/* The values of members of one family. rows() adds up what terms have for n successive members: e
 * points to row 0: rows() reads e[-most] to e[n - 1 - least] of each value. raw() does the same
 * before a division. rows() returns nonzero where a mass is not positive. */
typedef pk_bits pk_rows(const pk_real *e, ptrdiff_t n, pk_real *const *out);
typedef void pk_kick_rows(const pk_real *e, ptrdiff_t n, pk_real kappa, pk_real delta, pk_real *q,
                          pk_real *v);
struct pk_row_set {
    int family, below, above; /* indices beyond the ends that terms reach */
    pk_rows *rows, *raw;
    pk_kick_rows *kick; /* v += kappa a, q += delta v; NULL: not there */
};

/* Adds sign * value number `value` of terms to one output. Single terms go to a member, sums to a
 * scalar, pairs to the member m or j or to a scalar. */
struct pk_goal {
    int terms, value, sign, output;
    struct pk_slot to;
};

enum pk_finish { PK_STORE, PK_QUOTIENT, PK_DIVIDE }; /* out = r0; out = r0/r1; out /= r0 */

struct pk_vector {
    const struct pk_terms *terms, *singles, *pairs;
    int n_terms, n_singles, n_pairs, n_values, n_sets, n_scalars, n_goals[3];
    const struct pk_row_set *sets;
    const int *scalars;             /* families of one member */
    const struct pk_goal *goals[3]; /* of terms, of singles, of pairs */
    enum pk_finish finish;
    int outputs;                         /* of raw() */
    ptrdiff_t chunk, least, most, width; /* terms of m reach rows m + least .. m + most */
};

/* What is added to the row of one member apart from terms of successive members. */
struct pk_addition {
    int family, output;
    ptrdiff_t i;
    pk_real value;
};

#define PK_MOST_ADDITIONS 1024
#define PK_MOST_OUTPUTS 8
#define PK_MOST_SCALARS 256

/* Writes the values of all terms for the rows from .. from + n - 1: value r of the terms at m
 * goes to e[r * width + most + m - from]. The caller has kept the first `known` columns. */
PK_PERHAPS static void pk_fill(const struct pk_members *x, const struct pk_vector *of,
                               ptrdiff_t from, ptrdiff_t n, ptrdiff_t known, pk_real *e)
{
    const ptrdiff_t first = from - of->most, begin = first + known, end = from + n - of->least;
    pk_real *o[PK_MOST_SLOTS];
    int g, r, done = 0;

    for (g = 0; g < of->n_terms; g++) {
        const struct pk_terms *terms = of->terms + g;
        const ptrdiff_t lo = pk_least(pk_most(begin, x->at[terms->over]), end);
        const ptrdiff_t hi = pk_most(lo, pk_least(end, x->at[terms->over + 1] + 1));
        ptrdiff_t m;
        for (r = 0; r < terms->n_values; r++) {
            o[r] = e + (done + r) * of->width + (lo - first);
            for (m = begin; m < lo; m++)
                o[r][m - lo] = 0;
            for (m = hi; m < end; m++)
                o[r][m - lo] = 0;
        }
        for (m = lo; m < hi; m += PK_BLOCK) {
            pk_evaluate(x, terms, m, pk_least(hi, m + PK_BLOCK), o);
            for (r = 0; r < terms->n_values; r++)
                o[r] += PK_BLOCK;
        }
        done += terms->n_values;
    }
}

/* Computes one row before a division. */
PK_PERHAPS static void pk_raw_row(const struct pk_members *x, const struct pk_vector *of,
                                  const struct pk_row_set *set, ptrdiff_t i, pk_real *e, pk_real *r)
{
    pk_real *out[PK_MOST_OUTPUTS];
    int k;

    for (k = 0; k < of->outputs; k++)
        out[k] = r + k;
    pk_fill(x, of, i, 1, 0, e);
    (void)set->raw(e + of->most, 1, out);
}

/* Lists what is added to the rows begin .. end - 1, and to scalars, apart from sums: single
 * terms, and rows beyond an end, which are added to the members that they stand for. */
PK_PERHAPS static int pk_additions(const struct pk_members *x, const struct pk_vector *of,
                                   pk_real *e, struct pk_addition *found, pk_real *scalars,
                                   ptrdiff_t begin, ptrdiff_t end)
{
    pk_real values[PK_MOST_SLOTS], r[PK_MOST_OUTPUTS], *o[PK_MOST_SLOTS];
    int g, k, n = 0, count = 0;

    for (g = 0; g < of->n_singles; g++) {
        for (k = 0; k < of->singles[g].n_values; k++)
            o[k] = values + k;
        pk_one(x, of->singles + g, 0, 0, 0, o);
        for (; n < of->n_goals[1] && of->goals[1][n].terms == g; n++) {
            const struct pk_goal *goal = of->goals[1] + n;
            const ptrdiff_t lo = pk_range_of_family(x, goal->to.family)[1];
            const ptrdiff_t i = pk_home(x, goal->to.family, pk_index(x, &goal->to, 0, 0));
            const pk_real value = goal->sign < 0 ? -values[goal->value] : values[goal->value];
            int is_scalar = 0;
            for (k = 0; k < of->n_scalars; k++)
                if (of->scalars[k] == goal->to.family) {
                    scalars[k * of->outputs + goal->output] += value;
                    is_scalar = 1;
                }
            if (is_scalar || i < lo || i < begin || i >= end)
                continue;
            found[count].family = goal->to.family;
            found[count].output = goal->output;
            found[count].i = i;
            found[count++].value = value;
        }
    }
    for (g = 0; g < of->n_sets; g++) {
        const struct pk_row_set *set = of->sets + g;
        const ptrdiff_t lo = pk_range_of_family(x, set->family)[1];
        const ptrdiff_t hi = pk_range_of_family(x, set->family)[2];
        ptrdiff_t i;
        for (i = lo - set->below; i <= hi + set->above; i++) {
            ptrdiff_t home;
            if (i == lo)
                i = hi + 1;
            if (i > hi + set->above)
                break;
            home = pk_home(x, set->family, i);
            if (home < lo || home < begin || home >= end)
                continue;
            pk_raw_row(x, of, set, i, e, r);
            for (k = 0; k < of->outputs; k++) {
                found[count].family = set->family;
                found[count].output = k;
                found[count].i = home;
                found[count++].value = r[k];
            }
        }
    }
    return count;
}

PK_PERHAPS static pk_bits pk_finished(enum pk_finish how, const pk_real *r, pk_real *const *out,
                                      int outputs)
{
    int k;

    if (how == PK_STORE)
        for (k = 0; k < outputs; k++)
            *out[k] = r[k];
    else if (how == PK_QUOTIENT)
        *out[0] = r[0] / r[1];
    else
        *out[0] /= r[0];
    return how == PK_STORE ? 0 : !(r[how == PK_QUOTIENT] > 0);
}

/* Adds the sum of n numbers to eight partial sums. */
PK_PERHAPS static void pk_add_up(const pk_real *e, ptrdiff_t n, pk_real sign, pk_real *eight)
{
    ptrdiff_t k, l;

    for (k = 0; k + 8 <= n; k += 8)
        for (l = 0; l < 8; l++)
            eight[l] += sign * e[k + l];
    for (l = 0; k + l < n; l++)
        eight[l] += sign * e[k + l];
}

PK_PERHAPS static pk_real pk_whole(const pk_real *s)
{
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

/* Computes the rows from .. to - 1 of a set, whose values of terms are e (see pk_fill), into
 * out[k] + 0, 1, ... */
PK_PERHAPS static pk_bits pk_some_rows(const struct pk_vector *of, const struct pk_row_set *set,
                                       ptrdiff_t from, ptrdiff_t to, const pk_real *e,
                                       const struct pk_addition *added, int n_added,
                                       pk_real *const *out)
{
    pk_real r[PK_MOST_OUTPUTS], *at[PK_MOST_OUTPUTS];
    const int finished = of->finish == PK_STORE ? of->outputs : 1;
    ptrdiff_t i, next;
    pk_bits bad = 0;
    int b, k;

    for (i = from; i < to; i = next + 1) {
        next = to;
        for (b = 0; b < n_added; b++)
            if (added[b].family == set->family && added[b].i >= i && added[b].i < next)
                next = added[b].i;
        for (k = 0; k < finished; k++)
            at[k] = out[k] + (i - from);
        if (next > i)
            bad |= set->rows(e + (i - from), next - i, at);
        if (next == to)
            break;
        for (k = 0; k < of->outputs; k++)
            at[k] = r + k;
        (void)set->raw(e + (next - from), 1, at);
        for (b = 0; b < n_added; b++)
            if (added[b].family == set->family && added[b].i == next)
                r[added[b].output] += added[b].value;
        for (k = 0; k < finished; k++)
            at[k] = out[k] + (next - from);
        bad |= pk_finished(of->finish, r, at, of->outputs);
    }
    return bad;
}

/* Computes a vector of all members; e has room for n_values * width numbers. Returns nonzero
 * where a mass is not positive. With `v` the vector is an acceleration a, and v += h a. */
PK_PERHAPS static pk_bits pk_compute(const struct pk_members *x, const struct pk_vector *of,
                                     pk_real *e, pk_real *const *out, pk_real *v, pk_real h)
{
    struct pk_addition added[PK_MOST_ADDITIONS];
    pk_real scalars[PK_MOST_SCALARS], sums[PK_MOST_SCALARS][8], a[PK_BLOCK];
    pk_real *at[PK_MOST_OUTPUTS];
    const int finished = of->finish == PK_STORE ? of->outputs : 1;
    ptrdiff_t first = PTRDIFF_MAX, last = PTRDIFF_MIN, from, n, known = 0;
    pk_bits bad = 0;
    int g, k, n_added;

    for (g = 0; g < of->n_scalars * of->outputs; g++) {
        scalars[g] = 0;
        for (k = 0; k < 8; k++)
            sums[g][k] = 0;
    }
    n_added = pk_additions(x, of, e, added, scalars, PTRDIFF_MIN, PTRDIFF_MAX);

    for (g = 0; g < of->n_sets; g++) {
        first = pk_least(first, pk_range_of_family(x, of->sets[g].family)[1]);
        last = pk_most(last, pk_range_of_family(x, of->sets[g].family)[2]);
    }
    for (g = 0; g < of->n_goals[0]; g++) {
        const int over = of->terms[of->goals[0][g].terms].over;
        first = pk_least(first, x->at[over] + of->most);
        last = pk_most(last, x->at[over + 1] + of->least);
    }
    for (from = first; from <= last; from += n) {
        int done = 0, term = 0;
        n = pk_least(of->chunk, last + 1 - from);
        pk_fill(x, of, from, n, known, e);
        for (g = 0; g < of->n_sets; g++) {
            const struct pk_row_set *set = of->sets + g;
            const ptrdiff_t *range = pk_range_of_family(x, set->family);
            const ptrdiff_t lo = pk_most(from, range[1]), hi = pk_least(from + n, range[2] + 1);
            const ptrdiff_t place = range[0] + lo - range[1];
            if (lo >= hi)
                continue;
            for (k = 0; k < finished; k++)
                at[k] = v ? a : out[k] + place;
            bad |= pk_some_rows(of, set, lo, hi, e + of->most + (lo - from), added, n_added, at);
            for (k = 0; v && k < hi - lo; k++)
                v[place + k] += h * a[k];
        }
        for (g = 0; g < of->n_goals[0]; g++) {
            const struct pk_goal *goal = of->goals[0] + g;
            for (; term < goal->terms; term++)
                done += of->terms[term].n_values;
            for (k = 0; of->scalars[k] != goal->to.family; k++)
                ;
            pk_add_up(e + (done + goal->value) * of->width + known,
                      n + of->most - of->least - known, (pk_real)goal->sign,
                      sums[k * of->outputs + goal->output]);
        }
        known = of->most - of->least;
        for (k = 0; k < of->n_values; k++) {
            pk_real *row = e + k * of->width;
            ptrdiff_t i;
            for (i = 0; i < known; i++)
                row[i] = row[i + n];
        }
    }
    for (g = 0; g < of->n_scalars; g++) {
        const ptrdiff_t place = pk_range_of_family(x, of->scalars[g])[0];
        for (k = 0; k < of->outputs; k++)
            scalars[g * of->outputs + k] += pk_whole(sums[g * of->outputs + k]);
        for (k = 0; k < finished; k++)
            at[k] = out[k] + place;
        bad |= pk_finished(of->finish, scalars + g * of->outputs, at, of->outputs);
    }
    return bad;
}

/* -- totals ---------------------------------------------------------------------------------- */

/* Returns how many pairs the member m has, and the least index *j of its partners. */
PK_PERHAPS static ptrdiff_t pk_partners(const struct pk_members *x, const struct pk_terms *of,
                                        ptrdiff_t m, ptrdiff_t *j)
{
    *j = x->at[of->over + 2] + of->first * m;
    return pk_most(0, x->at[of->over + 3] + of->last * m + 1 - *j);
}

/* Writes the values of the pairs m, j .. j + n - 1, n at most PK_BLOCK. All of them are members. */
PK_PERHAPS static void pk_evaluate_pairs(const struct pk_members *x, const struct pk_terms *of,
                                         ptrdiff_t m, ptrdiff_t j, ptrdiff_t n, pk_real *const *o)
{
    const pk_real *s[PK_MOST_SLOTS];
    int i;

    for (i = 0; i < of->n_slots; i++) {
        const struct pk_slot *slot = of->slots + i;
        const ptrdiff_t *range = pk_range_of_family(x, slot->family);
        s[i] = slot->array == PK_OF_ZERO
                   ? pk_zeros
                   : x->arrays[slot->array] + range[0] + pk_index(x, slot, m, j) - range[1];
    }
    if (of->values(x, PK_IN_LANE, m, j, n, s, o))
        (void)of->values(x, PK_CAREFULLY, m, j, n, s, o);
}

/* The sum of all values of some terms, with one value each; e has room for PK_BLOCK numbers. */
PK_PERHAPS static pk_real pk_total(const struct pk_members *x, const struct pk_terms *of, int count,
                                   pk_real *e)
{
    pk_real eight[8] = {0};
    ptrdiff_t m, j, n, left;

    for (; count-- > 0; of++)
        for (m = x->at[of->over]; m <= x->at[of->over + 1]; m += of->pairs ? 1 : n) {
            n = pk_least(PK_BLOCK, x->at[of->over + 1] + 1 - m);
            if (!of->pairs) {
                pk_evaluate(x, of, m, m + n, &e);
                pk_add_up(e, n, 1, eight);
                continue;
            }
            for (left = pk_partners(x, of, m, &j); left > 0; left -= n, j += n) {
                n = pk_least(left, PK_BLOCK);
                pk_evaluate_pairs(x, of, m, j, n, &e);
                pk_add_up(e, n, 1, eight);
            }
        }
    return pk_whole(eight);
}

/* -- pairs ----------------------------------------------------------------------------------- */

/* Adds the values of pairs to a vector; e has room for those of one term, PK_BLOCK pairs each. */
PK_PERHAPS static void pk_add_pairs(const struct pk_members *x, const struct pk_vector *of,
                                    pk_real *e, pk_real *const *out)
{
    pk_real *o[PK_MOST_SLOTS];
    int g, k, first, next = 0;

    for (g = 0; g < of->n_pairs; g++) {
        const struct pk_terms *terms = of->pairs + g;
        ptrdiff_t m, j, n, left, c;
        first = next;
        for (k = 0; k < terms->n_values; k++)
            o[k] = e + k * PK_BLOCK;
        for (m = x->at[terms->over]; m <= x->at[terms->over + 1]; m++)
            for (left = pk_partners(x, terms, m, &j); left > 0; left -= n, j += n) {
                n = pk_least(left, PK_BLOCK);
                pk_evaluate_pairs(x, terms, m, j, n, o);
                for (next = first; next < of->n_goals[2] && of->goals[2][next].terms == g; next++) {
                    const struct pk_goal *goal = of->goals[2] + next;
                    const ptrdiff_t *range = pk_range_of_family(x, goal->to.family);
                    pk_real *to = out[goal->output] + range[0] + pk_index(x, &goal->to, m, j) -
                                  range[1];
                    const pk_real *from = o[goal->value];
                    pk_real eight[8] = {0};
                    if (goal->to.of_j) {
                        for (c = 0; c < n; c++)
                            to[c] += (pk_real)goal->sign * from[c];
                    } else {
                        pk_add_up(from, n, (pk_real)goal->sign, eight);
                        *to += pk_whole(eight);
                    }
                }
            }
        while (next < of->n_goals[2] && of->goals[2][next].terms == g)
            next++;
    }
}

/* -- lists ----------------------------------------------------------------------------------- */

/* Writes the values of some terms, each with one for each member or pair, one behind the other.
 * With `out` NULL it only counts them. */
PK_PERHAPS static size_t pk_list(const struct pk_members *x, const struct pk_terms *of, int count,
                                 pk_real *out)
{
    size_t found = 0;
    ptrdiff_t m, j, n, left;

    for (; count-- > 0; of++)
        for (m = x->at[of->over]; m <= x->at[of->over + 1]; m += of->pairs ? 1 : n) {
            pk_real *to = out ? out + found : NULL;
            n = pk_least(PK_BLOCK, x->at[of->over + 1] + 1 - m);
            if (!of->pairs) {
                if (out)
                    pk_evaluate(x, of, m, m + n, &to);
                found += (size_t)n;
                continue;
            }
            for (left = pk_partners(x, of, m, &j); left > 0; left -= n, j += n) {
                n = pk_least(left, PK_BLOCK);
                to = out ? out + found : NULL;
                if (out)
                    pk_evaluate_pairs(x, of, m, j, n, &to);
                found += (size_t)n;
            }
        }
    return found;
}

/* Which member, or pair, value number k of pk_list() is of. */
PK_PERHAPS static void pk_listed(const struct pk_members *x, const struct pk_terms *of, size_t k,
                                 ptrdiff_t *i, ptrdiff_t *j)
{
    *j = 0;
    *i = x->at[of->over];
    if (!of->pairs) {
        *i += (ptrdiff_t)k;
        return;
    }
    for (;; ++*i) {
        const size_t n = (size_t)pk_partners(x, of, *i, j);
        if (k < n)
            break;
        k -= n;
    }
    *j += (ptrdiff_t)k;
}

/* -- sequences ------------------------------------------------------------------------------- */

/* Writes the values of sequences, from the first member to the last. to[g][r] is where value r of
 * the first member of terms g goes; others follow. Mutual sequences advance one member at a
 * time. */
PK_PERHAPS static void pk_run_along(const struct pk_members *x, const struct pk_terms *of,
                                    int count, pk_real *const *const *to, int mutual)
{
    pk_real *o[PK_MOST_SLOTS];
    ptrdiff_t lo = PTRDIFF_MAX, hi = PTRDIFF_MIN, from, m, n;
    int g, r;

    for (g = 0; g < count; g++) {
        lo = pk_least(lo, x->at[of[g].over]);
        hi = pk_most(hi, x->at[of[g].over + 1]);
    }
    for (from = lo; from <= hi; from = mutual ? from + 1 : hi + 1)
        for (g = 0; g < count; g++) {
            const ptrdiff_t first = x->at[of[g].over];
            const ptrdiff_t last = mutual ? pk_least(from, x->at[of[g].over + 1])
                                          : x->at[of[g].over + 1];
            for (m = pk_most(first, from); m <= last; m += n) {
                n = pk_least(PK_BLOCK, last + 1 - m);
                for (r = 0; r < of[g].n_values; r++)
                    o[r] = to[g][r] + (m - first);
                pk_evaluate(x, of + g, m, m + n, o);
            }
        }
}

#endif
