/* Deflation: a factor of the equations that removes known roots.
 * Reference: P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026. */
#include <string.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"

/* Returns the contribution of unknown i to the squared distance between the current state and root
 * k, in units of the box. An angle contributes a squared sine, so that the root is also deflated at
 * angles that differ by whole turns. A quaternion contributes the squared sine of half the angle
 * from the root's quaternion, returned for the first of its 4 components; the others return 0. Sets
 * *half to half the derivative of the squared distance with respect to the unknown. */
static double apart(struct search *s, const struct pk_equilibria *known, size_t k, size_t i,
                    double *half)
{
    const int c = is_by_rate(s, i);
    const double *root = (c ? known->v : known->q) + k * s->n;
    const double d = *unknown(s, i) - root[i], size = s->box[i];
    /* i - quaternions(s) is unsigned: it is huge if unknown i comes before the quaternions. */
    const size_t part = i - quaternions(s);
    if (part < 4 * s->problem->system->n_rotations) {
        const double *Q = s->v + (i - part % 4), *R = root + (i - part % 4);
        *half = Q[part % 4] - pk_dot(Q, R, 4) * root[i];
        return part % 4 ? 0 : fmax(turned(Q, R), 0);
    }
    if (!c && s->turns[i]) {
        const double sine = 2 * sin(d / 2) / TWO_PI;
        *half = sine * cos(d / 2) / TWO_PI;
        return sine * sine;
    }
    *half = d / size / size;
    return d / size * (d / size);
}

double pk_equilibria_deflated(struct search *s)
{
    double product = 1;
    memset(s->slope, 0, s->n * sizeof *s->slope);
    for (size_t k = 0; s->known && k < s->known->count; k++) {
        double square = 0, half;
        for (size_t i = 0; i < s->n; i++)
            square += apart(s, s->known, k, i, &half);
        if (!(square > 0))
            return HUGE_VAL;
        product *= 1 + 1 / square;
        for (size_t i = 0; i < s->n; i++) {
            apart(s, s->known, k, i, &half);
            s->slope[i] -= 2 * half / (square * (1 + square));
        }
    }
    return product;
}
