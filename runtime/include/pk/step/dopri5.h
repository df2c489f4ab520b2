/* DOPRI5, order 5(4) with dense output of order 4. Coefficients: J. R. Dormand, P. J. Prince, J.
 * Comp. Appl. Math. 6 (1980) 19; dense output: L. F. Shampine, as in E. Hairer, S. P. Norsett, G.
 * Wanner, Solving Ordinary Differential Equations I, II.5 Table 5.2 and II.6. The seventh stage is
 * the derivative at the new point. */
#ifndef PK_STEP_DOPRI5_H
#define PK_STEP_DOPRI5_H

#include <pk/step/tableau.h>

#define PK_R(a, b) (PK_C(a) / PK_C(b))

static const pk_real pk_dopri5_c[] = {
    0, PK_R(1.0, 5.0), PK_R(3.0, 10.0), PK_R(4.0, 5.0), PK_R(8.0, 9.0), 1};
static const pk_real pk_dopri5_a[] = {
    PK_R(1.0, 5.0),        PK_R(3.0, 40.0),     PK_R(9.0, 40.0),        PK_R(44.0, 45.0),
    PK_R(-56.0, 15.0),     PK_R(32.0, 9.0),     PK_R(19372.0, 6561.0),  PK_R(-25360.0, 2187.0),
    PK_R(64448.0, 6561.0), PK_R(-212.0, 729.0), PK_R(9017.0, 3168.0),   PK_R(-355.0, 33.0),
    PK_R(46732.0, 5247.0), PK_R(49.0, 176.0),   PK_R(-5103.0, 18656.0),
};
static const pk_real pk_dopri5_b[] = {PK_R(35.0, 384.0),     0,
                                      PK_R(500.0, 1113.0),   PK_R(125.0, 192.0),
                                      PK_R(-2187.0, 6784.0), PK_R(11.0, 84.0)};
static const pk_real pk_dopri5_e[] = {PK_R(71.0, 57600.0),      0,
                                      PK_R(-71.0, 16695.0),     PK_R(71.0, 1920.0),
                                      PK_R(-17253.0, 339200.0), PK_R(22.0, 525.0),
                                      PK_R(-1.0, 40.0)};
static const pk_real pk_dopri5_d[] = {
    PK_R(-12715105075.0, 11282082432.0),  0,
    PK_R(87487479700.0, 32700410799.0),   PK_R(-10690763975.0, 1880347072.0),
    PK_R(701980252875.0, 199316789632.0), PK_R(-1453857185.0, 822651844.0),
    PK_R(69997945.0, 29380423.0)};

static const struct pk_tableau pk_dopri5_table = {.stages = 6,
                                                  .c = pk_dopri5_c,
                                                  .a = pk_dopri5_a,
                                                  .b = pk_dopri5_b,
                                                  .e = pk_dopri5_e,
                                                  .error_order = 5,
                                                  .beta = PK_C(0.04),
                                                  .shrink = PK_C(0.2),
                                                  .grow = PK_C(10.0),
                                                  .rows = 1,
                                                  .d = pk_dopri5_d};
#undef PK_R

#endif
