/* The tables of every family, and which methods are in it.
 *
 * References: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, I.7
 * and II.1 Table 1.2 (W. Kutta 1901); E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
 * Integration, I.1, II.4; H. Yoshida, Phys. Lett. A 150 (1990) 262.
 */
#ifndef PK_STEP_TABLES_H
#define PK_STEP_TABLES_H

#include <pk/step/dop853.h>
#include <pk/step/dopri5.h>

#define PK_ERK_METHODS(X) X(euler) X(rk4)
#define PK_EMBEDDED_METHODS(X) X(dopri5) X(dop853)
#define PK_SPLITTING_METHODS(X) X(symplectic_euler) X(verlet) X(yoshida4)

static const pk_real pk_euler_c[] = {PK_C(0.0)};
static const pk_real pk_euler_b[] = {PK_C(1.0)};
static const struct pk_tableau pk_euler_table = {
    .stages = 1, .c = pk_euler_c, .a = NULL, .b = pk_euler_b};

static const pk_real pk_rk4_c[] = {PK_C(0.0), PK_C(0.5), PK_C(0.5), PK_C(1.0)};
static const pk_real pk_rk4_a[] = {PK_C(0.5), PK_C(0.0), PK_C(0.5),
                                   PK_C(0.0), PK_C(0.0), PK_C(1.0)};
static const pk_real pk_rk4_b[] = {PK_C(1.0) / PK_C(6.0), PK_C(1.0) / PK_C(3.0),
                                   PK_C(1.0) / PK_C(3.0), PK_C(1.0) / PK_C(6.0)};
static const struct pk_tableau pk_rk4_table = {
    .stages = 4, .c = pk_rk4_c, .a = pk_rk4_a, .b = pk_rk4_b};

static const pk_real pk_symplectic_euler_kick[] = {PK_C(1.0), PK_C(0.0)};
static const pk_real pk_symplectic_euler_drift[] = {PK_C(1.0)};
static const pk_real pk_verlet_kick[] = {PK_C(0.5), PK_C(0.5)};
static const pk_real pk_verlet_drift[] = {PK_C(1.0)};
/* Triple jump: w1 = 1/(2 - 2^(1/3)), w0 = 1 - 2 w1; kicks w1/2, (w1 + w0)/2, .... */
static const pk_real pk_yoshida4_kick[] = {
    PK_C(0.675603595979828817023843904485730413), PK_C(-0.175603595979828817023843904485730413),
    PK_C(-0.175603595979828817023843904485730413), PK_C(0.675603595979828817023843904485730413)};
static const pk_real pk_yoshida4_drift[] = {PK_C(1.35120719195965763404768780897146083),
                                            PK_C(-1.70241438391931526809537561794292165),
                                            PK_C(1.35120719195965763404768780897146083)};

static const struct pk_splitting pk_symplectic_euler_table = {1, pk_symplectic_euler_kick,
                                                              pk_symplectic_euler_drift};
static const struct pk_splitting pk_verlet_table = {1, pk_verlet_kick, pk_verlet_drift};
static const struct pk_splitting pk_yoshida4_table = {3, pk_yoshida4_kick, pk_yoshida4_drift};

#endif
