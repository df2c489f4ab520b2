/* Tables of the adaptive Gauss-Legendre method with 8 stages, for the lanes of one kernel. Matrices
 * are stored by columns, M[m * 8 + l] for row l, so that lanes are contiguous. Nodes and weights
 * were computed in 60 digits (mpmath); the other tables are computed from them
 * (src/implicit/collocation_tables.c).
 *
 * References: J. C. Butcher, Math. Comp. 18 (1964) 50; E. Hairer, C. Lubich, G. Wanner, Geometric
 * Numerical Integration, 2nd ed., II.1.3, and II.2.3 for Nystrom methods. */
#ifndef PK_STEP_GAUSS_TABLES_H
#define PK_STEP_GAUSS_TABLES_H

#include <pk/real.h>

/* clang-format off */
static const pk_real pk_gauss8_c[] = {
    PK_C(0.019855071751231884158219565715263504786), PK_C(0.10166676129318663020422303176208478158),
    PK_C(0.23723379504183550709113047540537682548), PK_C(0.40828267875217509753026192881990800967),
    PK_C(0.59171732124782490246973807118009199033), PK_C(0.76276620495816449290886952459462317452),
    PK_C(0.89833323870681336979577696823791521842), PK_C(0.98014492824876811584178043428473649521),
};
static const pk_real pk_gauss8_b[] = {
    PK_C(0.050614268145188129576265677154981095058), PK_C(0.11119051722668723527217799721312044222),
    PK_C(0.15685332293894364366898110099330065663), PK_C(0.1813418916891809914825752246385978061),
    PK_C(0.1813418916891809914825752246385978061), PK_C(0.15685332293894364366898110099330065663),
    PK_C(0.11119051722668723527217799721312044222), PK_C(0.050614268145188129576265677154981095058),
};
/* clang-format on */

struct pk_gauss_matrices {
    pk_real A[64], A2[64]; /* coefficients a_ij, and the square of the matrix (a_ij) */
    pk_real taylor[64];    /* maps the values at the stages to the coefficients of (x - 1)^k */
    pk_real powers[64];    /* powers c_l^k of the nodes */
    /* map the values at the stages to the coefficients of the Legendre polynomials P_6 and P_7 */
    pk_real legendre6[8], legendre7[8];
};

#endif
