/* Deflation: what the equations of equilibria are multiplied by, so that known roots are none.
 * Reference: P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026.
 */
#include <string.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"

/* How far the state is from root k along unknown i, in reaches: of an angle its sine, so that the
 * root is kept from in every turn. *slope: its derivative. */
static double apart(struct search *s, const struct pk_equilibria *known, size_t k, size_t i,
                    double *slope)
{
    const int c = is_by_rate(s, i);
    const double *root = (c ? known->v : known->q) + k * s->n;
    const double d = *unknown(s, i) - root[i], size = s->box[i];
    if (!c && s->turns[i]) {
        *slope = cos(d / 2) / TWO_PI;
        return 2 * sin(d / 2) / TWO_PI;
    }
    *slope = 1 / size;
    return d / size;
}

double pk_equilibria_deflated(struct search *s)
{
    double product = 1;
    memset(s->slope, 0, s->n * sizeof *s->slope);
    for (size_t k = 0; s->known && k < s->known->count; k++) {
        double square = 0, slope;
        for (size_t i = 0; i < s->n; i++) {
            const double d = apart(s, s->known, k, i, &slope);
            square += d * d;
        }
        if (!(square > 0))
            return HUGE_VAL;
        product *= 1 + 1 / square;
        for (size_t i = 0; i < s->n; i++) {
            const double d = apart(s, s->known, k, i, &slope);
            s->slope[i] -= 2 * d * slope / (square * (1 + square));
        }
    }
    return product;
}
