/* Tables of collocation methods with s stages: Gauss, order 2 s; Radau IIA, order 2 s - 1, L-stable
 * and stiffly accurate (the last stage is the end of the step); Lobatto IIIA, order 2 s - 2 (for s
 * = 2 the pair IIIA-IIIB is Verlet if the system is separable). Nodes are the roots of the
 * derivatives
 *
 *     Gauss  d^s (x (x-1))^s    Radau  d^(s-1) x^(s-1) (x-1)^s    Lobatto  d^(s-2) (x (x-1))^(s-1)
 *
 * and weights the integrals of the Lagrange polynomials, in 60 digits (mpmath). a_ij are the
 * integrals of these polynomials up to c_i. With Legendre polynomials, which are also orthogonal in
 * sums over the nodes,
 *
 *     mu_ij = a_ij / b_j = sum_k P_k(c_j) int_0^c_i P_k / sum_l b_l P_k(c_l)^2.
 *
 * References: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5 (Table 5.6,
 * W-transformation); J. C. Butcher, Math. Comp. 18 (1964) 50; O. Axelsson, BIT 9 (1969) 185; B. L.
 * Ehle (1969); G. Sun, J. Comput. Math. 11 (1993) 365; L. Jay, SIAM J. Numer. Anal. 33 (1996) 368;
 * E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3-4, II.2.2. */
#include <string.h>

#include "../core/internal.h"
#include "../core/tableau.h"

#include <pk/step/gauss_tables.h>

/* clang-format off */
static const pk_real lobatto2_c[] = {0, 1};
static const pk_real lobatto2_b[] = {PK_C(0.5), PK_C(0.5)};
static const pk_real lobatto3_c[] = {0, PK_C(0.5), 1};
static const pk_real lobatto3_b[] = {PK_C(1.0) / 6, PK_C(2.0) / 3, PK_C(1.0) / 6};
static const pk_real lobatto4_c[] = {
    0, PK_C(0.27639320225002103035908263312687237646),
    PK_C(0.72360679774997896964091736687312762354), 1};
static const pk_real lobatto4_b[] = {PK_C(1.0) / 12, PK_C(5.0) / 12, PK_C(5.0) / 12, PK_C(1.0) / 12};
static const pk_real radau5_c[] = {
    PK_C(0.1550510257216821901802715925294108608), PK_C(0.6449489742783178098197284074705891392),
    1};
static const pk_real radau5_b[] = {
    PK_C(0.37640306270046727505007544236928079467), PK_C(0.51248582618842161383881344651960809422),
    PK_C(1.0) / 9};
static const pk_real radau9_c[] = {
    PK_C(0.057104196114517682193121192554115621235),
    PK_C(0.27684301363812382768004599768562514111),
    PK_C(0.58359043236891682005669766866291724869),
    PK_C(0.86024013565621944784791291887511976674), 1};
static const pk_real radau9_b[] = {
    PK_C(0.14371356079122594132341221985411022716), PK_C(0.2813560151494620601921726503406598912),
    PK_C(0.31182652297574125408185491157664052199),
    PK_C(0.22310390108357074440256021822858935965), PK_C(0.04)};
/* clang-format on */

#define GAUSS(s) const struct pk_gauss pk_gauss##s##_table = {.stages = s};
#define TABLE(name, s, conjugate) \
    const struct pk_gauss pk_##name##_table = {s, name##_c, name##_b, conjugate};
GAUSS(1)
GAUSS(2)
GAUSS(3)
GAUSS(4)
GAUSS(5)
GAUSS(6)
GAUSS(7)
GAUSS(8)
TABLE(lobatto2, 2, 1)
TABLE(lobatto3, 3, 1)
TABLE(lobatto4, 4, 1)
TABLE(radau5, 3, 0)
TABLE(radau9, 5, 0)

void pk_collocation(const struct pk_gauss *table, pk_real *c, pk_real *b, pk_real *mu)
{
    const int s = table->stages, symmetric = !table->c || table->conjugate;
    pk_real P[PK_LANES][PK_LANES], integral[PK_LANES][PK_LANES];
    if (table->c) {
        pk_copy(c, table->c, (size_t)s);
        pk_copy(b, table->b, (size_t)s);
    } else {
        pk_gauss_nodes(s, c, b);
    }
    for (int i = 0; i < s; i++)
        pk_legendre(c[i], symmetric ? c[s - 1 - i] : 1 - c[i], s, P[i], integral[i]);
    pk_zero(mu, (size_t)(s * s));
    for (int k = s - 1; k >= 0; k--) {
        pk_real square = 0;
        for (int l = 0; l < s; l++)
            square += b[l] * P[l][k] * P[l][k];
        for (int i = 0; i < s; i++)
            for (int j = 0; j < s; j++)
                mu[i * s + j] += integral[i][k] * P[j][k] / square;
    }
    /* conjugate numbers, mu_ij and mu_ji, sum to 1 exactly */
    for (int i = 0; i < s && !table->c; i++) {
        mu[i * s + i] = PK_C(0.5);
        for (int j = 0; j < i; j++)
            mu[j * s + i] = 1 - mu[i * s + j];
    }
}

void pk_gauss_make_matrices(struct pk_gauss_matrices *M)
{
    enum { S = PK_LANES };
    const pk_real *c = pk_gauss8_c;
    pk_real P[S], I[S][S + 1];
    memset(M, 0, sizeof *M);
    for (int l = 0; l < S; l++) {
        pk_legendre(c[l], c[S - 1 - l], S, P, I[l]);
        I[l][S] = 0; /* the interpolant has degree 7, so that it has no term P_8 */
        for (int k = 0; k < S; k++)
            M->powers[k * S + l] = k ? M->powers[(k - 1) * S + l] * c[l] : 1;
    }
    for (int j = 0; j < S; j++) {
        pk_legendre(c[j], c[S - 1 - j], S, P, NULL);
        for (int k = S - 1; k >= 0; k--) {
            const pk_real alpha = (pk_real)(2 * k + 1) * pk_gauss8_b[j] * P[k];
            pk_real choose = 1; /* P_k(1 + 2 z) = sum_l C(k, l) C(k + l, l) z^l */
            for (int l = 0; l < S; l++) {
                M->A[j * S + l] += alpha * I[l][k];
                M->A2[j * S + l] += alpha * (k ? (I[l][k + 1] - I[l][k - 1]) / (pk_real)(4 * k + 2)
                                               : c[l] * c[l] / 2);
                M->taylor[j * S + l] += alpha * choose;
                choose *= (pk_real)((k - l) * (k + l + 1)) / (pk_real)((l + 1) * (l + 1));
            }
            if (k >= S - 2)
                (k == S - 1 ? M->legendre7 : M->legendre6)[j] = alpha;
        }
    }
}
