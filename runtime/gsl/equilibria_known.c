/* The list of known equilibria, lowest energy first, and the test whether a state is a known
 * equilibrium or on the same continuum as one. */
#include <string.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"

double pk_equilibria_energy(const struct search *s, const double *q, const double *v)
{
    const struct pk_system *system = s->problem->system;
    return system->energy ? system->energy(s->problem->params, 0, q, v, NULL) : 0;
}

/* Returns whether the state is on the same continuum of equilibria as known root k. The test
 * compares their energies; with nonholonomic constraints, it also accepts equal eigenvalues. */
static int is_continued(struct search *s, double h, double size, const struct pk_equilibria *found,
                        size_t k)
{
    const struct pk_part_constraints *kept = &s->problem->system->constraints;
    const double *q = found->q + k * s->n, *v = found->v + k * s->n;
    if (fabs(h - pk_equilibria_energy(s, q, v)) <= 1e-9 * size)
        return 1;
    if (kept->n == kept->n_holonomic)
        return 0;
    /* Each array holds 4 n numbers: real and imaginary parts of 2 n eigenvalues. */
    double *const here = s->p_q, *const there = s->F_v, most = 0;
    size_t count, other;
    if (pk_gsl_rates(s->problem, 0, s->q, s->v, here, here + 2 * s->n, &count) != PK_DONE ||
        pk_gsl_rates(s->problem, 0, q, v, there, there + 2 * s->n, &other) != PK_DONE)
        return 0;
    double apart = 0;
    /* compares the sums of |eigenvalue|^power at both states */
    for (size_t power = 2; power <= 8; power += 2) {
        double a = 0, b = 0;
        for (size_t i = 0; i < count; i++)
            a += pow(hypot(here[i], here[2 * s->n + i]), (double)power);
        for (size_t i = 0; i < other; i++)
            b += pow(hypot(there[i], there[2 * s->n + i]), (double)power);
        most = fmax(most, fmax(a, b));
        apart = fmax(apart, fabs(a - b) / fmax(fmax(a, b), 1e-300));
    }
    return apart <= 1e-5 || !(most > 0);
}

int pk_equilibria_known(struct search *s, const struct pk_equilibria *found)
{
    const double h = pk_equilibria_energy(s, s->q, s->v);
    double size = fmax(fabs(h), s->energy);
    for (size_t k = 0; k < found->count; k++)
        size = fmax(size, fabs(pk_equilibria_energy(s, found->q + k * s->n, found->v + k * s->n)));
    for (size_t k = 0; k < found->count; k++) {
        int same = 1;
        if (s->slack && found->slack && found->slack[k] && is_continued(s, h, size, found, k))
            return 1;
        for (size_t r = 0; r < s->problem->system->n_rotations; r++) { /* Q and -Q: same rotation */
            const size_t i = quaternions(s) + 4 * r;
            same = same && turned(s->v + i, found->v + k * s->n + i) <= 1e-8;
        }
        for (size_t i = 0; i < s->n && same; i++) {
            if (i >= quaternions(s) && i < quaternions(s) + 4 * s->problem->system->n_rotations)
                continue;
            const int c = is_by_rate(s, i);
            double d = c ? s->v[i] - found->v[k * s->n + i] : s->q[i] - found->q[k * s->n + i];
            if (!c && s->turns[i])
                d = remainder(d, TWO_PI);
            same = fabs(d) <= 1e-4 * reach(s, i);
        }
        if (same)
            return 1;
    }
    return 0;
}

void pk_equilibria_insert(struct search *s, struct pk_equilibria *found)
{
    const size_t n = s->n;
    for (size_t i = 0; i < n; i++)
        if (s->turns[i] && !is_by_rate(s, i)) {
            s->q[i] = remainder(s->q[i], TWO_PI);
            if (s->q[i] < -TWO_PI / 2 * (1 - 1e-7))
                s->q[i] += TWO_PI;
        }
    for (size_t r = 0; r < s->problem->system->n_rotations; r++) {
        double *Q = s->v + quaternions(s) + 4 * r;
        size_t first = 0;
        while (first < 3 && fabs(Q[first]) < 1e-9)
            first++;
        for (size_t i = 4; i-- > 0;)
            Q[i] *= Q[first] < 0 && i != first ? -1 : 1;
        Q[first] = fabs(Q[first]);
    }
    const double h = pk_equilibria_energy(s, s->q, s->v);
    size_t at = found->count;
    while (at > 0 && h < pk_equilibria_energy(s, found->q + (at - 1) * n, found->v + (at - 1) * n) -
                             1e-9 * fabs(h))
        at--;
    double *const lists[] = {found->q, found->v, found->doubt};
    const double *const one[] = {s->q, s->v, s->step};
    for (size_t k = 0; k < 3; k++)
        if (lists[k]) {
            double *const place = lists[k] + at * n;
            memmove(place + n, place, (found->count - at) * n * sizeof *place);
            memcpy(place, one[k], n * sizeof *place);
        }
    if (found->slack) {
        memmove(found->slack + at + 1, found->slack + at,
                (found->count - at) * sizeof *found->slack);
        found->slack[at] = s->slack;
    }
    found->count++;
}
