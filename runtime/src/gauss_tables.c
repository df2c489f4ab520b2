/* Gauss-Legendre collocation of s = 1 to 4 stages, order 2 s. Nodes are the roots of the shifted
 * Legendre polynomial, b_i and a_ij the integrals of the Lagrange polynomials, mu_ij = a_ij / b_j;
 * computed in 60 digits (mpmath). The form in mu: M. Antonana, J. Makazaga, A. Murua, Numer.
 * Algorithms 76 (2017) 861. References: J. C. Butcher, Math. Comp. 18 (1964) 50; E. Hairer,
 * C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3.
 */
#include "tableau.h"

static const pk_real gauss1_c[] = {
    PK_C(0.5),
};
static const pk_real gauss1_b[] = {
    PK_C(1.0),
};
static const pk_real gauss1_mu[] = {
    PK_C(0.5),
};
static const pk_real gauss2_c[] = {
    PK_C(0.21132486540518711774542560974902127218),
    PK_C(0.78867513459481288225457439025097872782),
};
static const pk_real gauss2_b[] = {
    PK_C(0.5), PK_C(0.5),
};
static const pk_real gauss2_mu[] = {
    PK_C(0.5), PK_C(-0.077350269189625764509148780501957455648),
    PK_C(1.0773502691896257645091487805019574556), PK_C(0.5),
};
static const pk_real gauss3_c[] = {
    PK_C(0.11270166537925831148207346002176003892), PK_C(0.5),
    PK_C(0.88729833462074168851792653997823996108),
};
static const pk_real gauss3_b[] = {
    PK_C(0.27777777777777777777777777777777777778),
    PK_C(0.44444444444444444444444444444444444444),
    PK_C(0.27777777777777777777777777777777777778),
};
static const pk_real gauss3_mu[] = {
    PK_C(0.5), PK_C(-0.080947501931112532776889809967359941625),
    PK_C(0.0352419984551099737784881520261120467),
    PK_C(1.0809475019311125327768898099673599416), PK_C(0.5),
    PK_C(-0.080947501931112532776889809967359941625),
    PK_C(0.9647580015448900262215118479738879533), PK_C(1.0809475019311125327768898099673599416),
    PK_C(0.5),
};
static const pk_real gauss4_c[] = {
    PK_C(0.069431844202973712388026755553595247452),
    PK_C(0.3300094782075718675986671204483776564), PK_C(0.6699905217924281324013328795516223436),
    PK_C(0.93056815579702628761197324444640475255),
};
static const pk_real gauss4_b[] = {
    PK_C(0.17392742256872692868653197461099970362),
    PK_C(0.32607257743127307131346802538900029638),
    PK_C(0.32607257743127307131346802538900029638),
    PK_C(0.17392742256872692868653197461099970362),
};
static const pk_real gauss4_mu[] = {
    PK_C(0.5), PK_C(-0.08158975003227987255507740190624913153),
    PK_C(0.038725926567885760060911099320643704911),
    PK_C(-0.020440420684040642425067889995634580311),
    PK_C(1.0815897500322798725550774019062491315), PK_C(0.5),
    PK_C(-0.085503751410519351170439432619895239875),
    PK_C(0.038725926567885760060911099320643704911),
    PK_C(0.96127407343211423993908890067935629509), PK_C(1.0855037514105193511704394326198952399),
    PK_C(0.5), PK_C(-0.08158975003227987255507740190624913153),
    PK_C(1.0204404206840406424250678899956345803), PK_C(0.96127407343211423993908890067935629509),
    PK_C(1.0815897500322798725550774019062491315), PK_C(0.5),
};

#define GAUSS(s, p, text)                                                                     \
    static const struct pk_gauss gauss##s = {s, gauss##s##_c, gauss##s##_b, gauss##s##_mu};    \
    const struct pk_method pk_gauss##s = {.name = "gauss" #s,                                  \
                                          .doc = text,                                         \
                                          .order = p,                                          \
                                          .stages = s,                                         \
                                          .traits = PK_SYMPLECTIC | PK_SYMMETRIC | PK_IMPLICIT, \
                                          .table = &gauss##s,                                  \
                                          .size = pk_gauss_size,                               \
                                          .init = pk_gauss_init,                               \
                                          .step = pk_gauss_step}

GAUSS(1, 2, "implicit midpoint rule in (q, p); GNI II.1.3, VI.4");
GAUSS(2, 4, "Gauss-Legendre, 2 stages, in (q, p); P. C. Hammer, J. W. Hollingsworth (1955)");
GAUSS(3, 6, "Gauss-Legendre, 3 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50");
GAUSS(4, 8, "Gauss-Legendre, 4 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50");
