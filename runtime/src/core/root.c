/* Finds a root of a function with a sign change, by the ITP method: interpolate (regula falsi),
 * truncate (move the point towards the middle, so that both ends of the interval converge to the
 * root), project (keep the point so near the middle that the method takes at most one step more
 * than bisection). Convergence is superlinear for smooth functions.
 *
 * Reference: I. F. D. Oliveira, R. H. C. Takahashi, An enhancement of the bisection method average
 * performance preserving minmax optimality, ACM Trans. Math. Softw. 47 (2020) 5, algorithm 1;
 * kappa_1 = 0.2/(b - a), kappa_2 = 2, n_0 = 1 as proposed there. */
#include "internal.h"
#include <pk/root.h>

enum pk_status pk_root(pk_function f, void *context, pk_real *a, pk_real fa, pk_real *b, pk_real fb,
                       pk_real width)
{
    const pk_real kappa = PK_C(0.2) / (*b - *a);
    /* the quantity that the reference calls epsilon 2^(n_max - j); `width` may be 0 */
    pk_real reach = pk_max(width, PK_EPSILON * (*b - *a)) / 2;
    while (2 * reach < *b - *a)
        reach *= 2;
    reach *= 2;
    while (*b - *a > width) {
        const pk_real half = (*b - *a) / 2, middle = *a + half;
        const pk_real chord = *a - fa * (*b - *a) / (fb - fa), towards = middle < chord ? -1 : 1;
        const pk_real cut = kappa * (*b - *a) * (*b - *a), most = reach - half;
        pk_real x = cut <= pk_abs(middle - chord) ? chord + towards * cut : middle;
        if (!(pk_abs(x - middle) <= most)) /* `chord` may be NaN if f is tiny at both ends */
            x = middle - towards * most;
        if (!(x > *a && x < *b))
            x = middle;
        if (!(x > *a && x < *b))
            break; /* a and b are adjacent numbers */
        pk_real y;
        PK_TRY(f(context, x, &y));
        if ((y > 0 && fa > 0) || (y < 0 && fa < 0)) {
            *a = x;
            fa = y;
        } else {
            *b = x;
            fb = y;
        }
        if (!(fb < 0 || fb > 0))
            break;
        reach /= 2;
    }
    return PK_DONE;
}
