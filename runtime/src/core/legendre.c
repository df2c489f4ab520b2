/* Legendre polynomials on [0, 1], and the nodes and weights of Gauss quadrature there, which with s
 * nodes is exact up to degree 2 s - 1. Reference: M. Abramowitz, I. A. Stegun, Handbook of
 * Mathematical Functions, 22.7.10, 22.8.5 and 25.4.29. */
#include "tableau.h"

enum { MOST = 8 }; /* the largest number of corrections of a node; about 5 suffice in __float128 */

/* Computes P_k by adding the differences P_k+1 - P_k, which are small near the ends of [0, 1]. */
void pk_legendre(pk_real x, pk_real rest, int count, pk_real *P, pk_real *integral)
{
    const int mirrored = x < rest; /* P_k(1 - x) = (-1)^k P_k(x) */
    const pk_real t = 2 * pk_min(x, rest);
    pk_real here = 1, rise = 0;
    for (int k = 0; k < count; k++) {
        const pk_real next = ((pk_real)k * rise - (pk_real)(2 * k + 1) * t * here) /
                             (pk_real)(k + 1);
        const pk_real sign = mirrored && k % 2 ? -1 : 1;
        P[k] = sign * here;
        if (integral) /* integral of P_k: (P_k+1 - P_k-1) / (2 (2 k + 1)) */
            integral[k] = k ? (mirrored ? -sign : sign) * (rise + next) / (pk_real)(4 * k + 2) : x;
        rise = next;
        here += next;
    }
}

void pk_gauss_nodes(int s, pk_real *c, pk_real *b)
{
    pk_real P[2 * PK_LANES + 1], integral[2 * PK_LANES + 1];
    for (int i = 0; 2 * i < s; i++) {
        const pk_real root = PK_F(sin)(PK_PI * ((pk_real)i + PK_C(0.75)) / (pk_real)(2 * s + 1));
        pk_real x = root * root, sum = 0;
        for (int count = 0; count <= MOST;
             count++) { /* Newton's method, with x (1 - x) P_s' from the integral of P_s */
            pk_legendre(x, 1 - x, s + 1, P, integral);
            if (count < MOST)
                x += P[s] * x * (1 - x) / ((pk_real)(s * (s + 1)) * integral[s]);
        }
        for (int k = 0; k < s; k++)
            sum += (pk_real)(2 * k + 1) * P[k] * P[k];
        c[i] = x;
        c[s - 1 - i] = 2 * i + 1 < s ? 1 - x : PK_C(0.5);
        b[i] = b[s - 1 - i] = 1 / sum;
    }
}
