/* Lobatto IIIA-IIIB pairs of 2, 3 and 4 stages, orders 2, 4 and 6: q by IIIA, p by IIIB, which is
 * its conjugate, a^_ij = b_j (1 - a_ji / b_i): symplectic and symmetric. Nodes are the roots of
 * d^(s-2)/dx^(s-2) (x^(s-1) (x-1)^(s-1)), b_i and a_ij of IIIA the integrals of the Lagrange
 * polynomials, mu_ij = a_ij / b_j, by columns; computed in 60 digits (mpmath). With 2 stages, of a
 * separable system, this is Verlet.
 *
 * References: G. Sun, J. Comput. Math. 11 (1993) 365; L. Jay, SIAM J. Numer. Anal. 33 (1996) 368;
 * E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.4, II.2.2, VI.4.
 */
#include "../core/tableau.h"

/* clang-format off */
static const pk_real lobatto2_c[] = {
    PK_C(0.0), PK_C(1.0),
};
static const pk_real lobatto2_b[] = {
    PK_C(0.5), PK_C(0.5),
};
static const pk_real lobatto2_mu[] = {
    PK_C(0.0), PK_C(1.0), PK_C(0.0), PK_C(1.0),
};
static const pk_real lobatto3_c[] = {
    PK_C(0.0), PK_C(0.5), PK_C(1.0),
};
static const pk_real lobatto3_b[] = {
    PK_C(0.16666666666666666666666666666666666667),
    PK_C(0.66666666666666666666666666666666666667),
    PK_C(0.16666666666666666666666666666666666667),
};
static const pk_real lobatto3_mu[] = {
    PK_C(0.0), PK_C(1.25), PK_C(1.0), PK_C(0.0), PK_C(0.5), PK_C(1.0), PK_C(0.0), PK_C(-0.25),
    PK_C(1.0),
};
static const pk_real lobatto4_c[] = {
    PK_C(0.0), PK_C(0.27639320225002103035908263312687237646),
    PK_C(0.72360679774997896964091736687312762354), PK_C(1.0),
};
static const pk_real lobatto4_b[] = {
    PK_C(0.083333333333333333333333333333333333333),
    PK_C(0.41666666666666666666666666666666666667),
    PK_C(0.41666666666666666666666666666666666667),
    PK_C(0.083333333333333333333333333333333333333),
};
static const pk_real lobatto4_mu[] = {
    PK_C(0.0), PK_C(1.3236067977499789696409173668731276235),
    PK_C(0.87639320225002103035908263312687237646), PK_C(1.0), PK_C(0.0),
    PK_C(0.45527864045000420607181652662537447529), PK_C(1.0813776741499453210663851538701318212),
    PK_C(1.0), PK_C(0.0), PK_C(-0.081377674149945321066385153870131821215),
    PK_C(0.54472135954999579392818347337462552471), PK_C(1.0), PK_C(0.0),
    PK_C(0.12360679774997896964091736687312762354),
    PK_C(-0.32360679774997896964091736687312762354), PK_C(1.0),
};

#define TABLE(s)                                                                       \
    const struct pk_gauss pk_lobatto##s##_table = {s, lobatto##s##_c, lobatto##s##_b, \
                                                   lobatto##s##_mu, 1};
TABLE(2)
TABLE(3)
TABLE(4)
