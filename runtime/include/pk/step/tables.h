/* The tables of explicit methods, and lists of the methods of each family.
 *
 * References: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, I.7
 * and II.1, Table 1.2 (C. Runge 1895, W. Kutta 1901). */
#ifndef PK_STEP_TABLES_H
#define PK_STEP_TABLES_H

#include <pk/methods.h>
#include <pk/step/dop853.h>
#include <pk/step/dopri5.h>
#include <pk/step/tables_splitting.h>
#ifdef PK_OWN_TABLES /* tables of a model's own methods */
#include PK_OWN_TABLES
#endif

#ifndef PK_ERK_METHODS
#define PK_ERK_METHODS(X) PK_METHODS_ERK(PK_NAME_OF, X)
#endif
#ifndef PK_EMBEDDED_METHODS
#define PK_EMBEDDED_METHODS(X) PK_METHODS_EMBEDDED(PK_NAME_OF, X)
#endif

static const pk_real pk_euler_c[] = {0};
static const pk_real pk_euler_b[] = {PK_C(1.0)};
static const struct pk_tableau pk_euler_table = {
    .stages = 1, .c = pk_euler_c, .a = NULL, .b = pk_euler_b};

/* Runge's midpoint rule. */
static const pk_real pk_rk2_c[] = {0, PK_C(0.5)};
static const pk_real pk_rk2_a[] = {PK_C(0.5)};
static const pk_real pk_rk2_b[] = {0, 1};
static const struct pk_tableau pk_rk2_table = {
    .stages = 2, .c = pk_rk2_c, .a = pk_rk2_a, .b = pk_rk2_b};

/* Kutta's method of order 3; the weights are Simpson's. */
static const pk_real pk_rk3_c[] = {0, PK_C(0.5), 1};
static const pk_real pk_rk3_a[] = {PK_C(0.5), PK_C(-1.0), PK_C(2.0)};
static const pk_real pk_rk3_b[] = {PK_C(1.0) / PK_C(6.0), PK_C(2.0) / PK_C(3.0),
                                   PK_C(1.0) / PK_C(6.0)};
static const struct pk_tableau pk_rk3_table = {
    .stages = 3, .c = pk_rk3_c, .a = pk_rk3_a, .b = pk_rk3_b};

/* Kutta's classical method. */
static const pk_real pk_rk4_c[] = {0, PK_C(0.5), PK_C(0.5), 1};
static const pk_real pk_rk4_a[] = {PK_C(0.5), 0, PK_C(0.5), 0, 0, 1};
static const pk_real pk_rk4_b[] = {PK_C(1.0) / PK_C(6.0), PK_C(1.0) / PK_C(3.0),
                                   PK_C(1.0) / PK_C(3.0), PK_C(1.0) / PK_C(6.0)};
static const struct pk_tableau pk_rk4_table = {
    .stages = 4, .c = pk_rk4_c, .a = pk_rk4_a, .b = pk_rk4_b};

#endif
