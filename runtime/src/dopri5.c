/* DOPRI5, order 5(4) with dense output of order 4. Coefficients: J. R. Dormand, P. J. Prince,
 * J. Comp. Appl. Math. 6 (1980) 19; dense output: L. F. Shampine, as in E. Hairer, S. P. Norsett,
 * G. Wanner, Solving Ordinary Differential Equations I, II.5 Table 5.2 and II.6. Its seventh
 * stage is the derivative at the new point.
 */
#include "tableau.h"

#define R(a, b) (PK_C(a) / PK_C(b))

static const pk_real c[] = {PK_C(0.0), R(1.0, 5.0), R(3.0, 10.0),
                            R(4.0, 5.0), R(8.0, 9.0), PK_C(1.0)};
static const pk_real a[] = {
    R(1.0, 5.0),
    R(3.0, 40.0), R(9.0, 40.0),
    R(44.0, 45.0), R(-56.0, 15.0), R(32.0, 9.0),
    R(19372.0, 6561.0), R(-25360.0, 2187.0), R(64448.0, 6561.0), R(-212.0, 729.0),
    R(9017.0, 3168.0), R(-355.0, 33.0), R(46732.0, 5247.0), R(49.0, 176.0), R(-5103.0, 18656.0),
};
static const pk_real b[] = {R(35.0, 384.0),     PK_C(0.0),           R(500.0, 1113.0),
                            R(125.0, 192.0), R(-2187.0, 6784.0), R(11.0, 84.0)};
static const pk_real e[] = {R(71.0, 57600.0), PK_C(0.0),
                            R(-71.0, 16695.0), R(71.0, 1920.0),
                            R(-17253.0, 339200.0), R(22.0, 525.0),
                            R(-1.0, 40.0)};
static const pk_real d[] = {R(-12715105075.0, 11282082432.0), PK_C(0.0),
                            R(87487479700.0, 32700410799.0), R(-10690763975.0, 1880347072.0),
                            R(701980252875.0, 199316789632.0), R(-1453857185.0, 822651844.0),
                            R(69997945.0, 29380423.0)};

static const struct pk_tableau table = {.stages = 6,
                                        .c = c,
                                        .a = a,
                                        .b = b,
                                        .e = e,
                                        .error_order = 5,
                                        .beta = PK_C(0.04),
                                        .shrink = PK_C(0.2),
                                        .grow = PK_C(10.0),
                                        .rows = 1,
                                        .d = d};

const struct pk_method pk_dopri5 = {
    .name = "dopri5",
    .doc = "Dormand-Prince 5(4), PI control; J. Comp. Appl. Math. 6 (1980) 19, HNW II.5",
    .order = 5,
    .stages = 6,
    .dense_order = 4,
    .traits = PK_ADAPTIVE | PK_DENSE,
    .table = &table,
    .size = pk_embedded_size,
    .init = pk_embedded_init,
    .step = pk_embedded_step,
    .dense = pk_embedded_dense};
