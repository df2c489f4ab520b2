/* The registry: one row for each method. The code generator also reads this file.
 *
 *     X(A, name, order, stages, dense order, traits, table, text)
 *
 * Order 0 or stages 0: variable; dense order 0: no dense output. `table` names the coefficients in
 * pk/step/tables.h: `rk4` is pk_rk4_table; `none` if the method has no table. PK_NEEDS_FAMILY are
 * the facts that methods of a family require of a system. */
#ifndef PK_METHODS_H
#define PK_METHODS_H

#include <pk/method.h>

/* clang-format off */
#define PK_NEEDS_ERK 0
#define PK_METHODS_ERK(X, A)                                                                       \
    X(A, euler, 1, 1, 0, 0, euler,                                                                 \
      "explicit Euler; HNW I.7")                                                                   \
    X(A, rk2, 2, 2, 0, 0, rk2,                                                                     \
      "the explicit midpoint rule; C. Runge (1895), HNW II.1")                                     \
    X(A, rk3, 3, 3, 0, 0, rk3,                                                                     \
      "Kutta's method of order 3, of Simpson's weights; W. Kutta (1901)")                          \
    X(A, rk4, 4, 4, 0, 0, rk4,                                                                     \
      "the classical Runge-Kutta method; W. Kutta (1901), HNW II.1 Table 1.2")

#define PK_TRAITS_SYMPLECTIC (PK_SYMPLECTIC | PK_SYMMETRIC)
#define PK_NEEDS_SPLITTING (PK_MASS_CONSTANT | PK_LINEAR_DRAG)
#define PK_METHODS_SPLITTING(X, A)                                                                 \
    X(A, symplectic_euler, 1, 1, 0, PK_SYMPLECTIC, symplectic_euler,                               \
      "symplectic Euler, kick first; R. de Vogelaere (1956), GNI I.1.9")                           \
    X(A, verlet, 2, 1, 0, PK_TRAITS_SYMPLECTIC, verlet,                                            \
      "velocity Verlet (Stormer, leapfrog); Phys. Rev. 159 (1967) 98")                             \
    X(A, yoshida4, 4, 3, 0, PK_TRAITS_SYMPLECTIC, yoshida4,                                        \
      "triple jump of Verlet; H. Yoshida, Phys. Lett. A 150 (1990) 262")                           \
    X(A, suzuki4, 4, 5, 0, PK_TRAITS_SYMPLECTIC, suzuki4,                                          \
      "five Verlet steps; M. Suzuki, Phys. Lett. A 146 (1990) 319")                                \
    X(A, mclachlan4, 4, 5, 0, PK_TRAITS_SYMPLECTIC, mclachlan4,                                    \
      "5 stages of least error; R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151")              \
    X(A, blanes_moan4, 4, 6, 0, PK_TRAITS_SYMPLECTIC, blanes_moan4,                                \
      "SRKN_6^b; S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313")                    \
    X(A, yoshida6, 6, 7, 0, PK_TRAITS_SYMPLECTIC, yoshida6,                                        \
      "seven Verlet steps, solution A; H. Yoshida, Phys. Lett. A 150 (1990) 262")                  \
    X(A, kahan_li6, 6, 9, 0, PK_TRAITS_SYMPLECTIC, kahan_li6,                                      \
      "nine Verlet steps, s9odr6a; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089")                \
    X(A, blanes_moan6, 6, 11, 0, PK_TRAITS_SYMPLECTIC, blanes_moan6,                               \
      "SRKN_11^b; S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313")                   \
    X(A, yoshida8, 8, 15, 0, PK_TRAITS_SYMPLECTIC, yoshida8,                                       \
      "fifteen Verlet steps, solution D; H. Yoshida, Phys. Lett. A 150 (1990) 262")                \
    X(A, kahan_li8, 8, 17, 0, PK_TRAITS_SYMPLECTIC, kahan_li8,                                     \
      "seventeen Verlet steps, s17odr8a; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089")

/* Compositions of boris steps; `table` is the splitting method with the same composition. */
#define PK_NEEDS_BORIS (PK_MASS_CONSTANT | PK_AFFINE_RATES)
#define PK_METHODS_BORIS(X, A)                                                                     \
    X(A, boris, 2, 1, 0, PK_SYMMETRIC | PK_LINEAR, verlet,                                         \
      "Verlet whose kicks turn v, for magnetic forces; J. P. Boris (1970)")                        \
    X(A, boris4, 4, 5, 0, PK_SYMMETRIC | PK_LINEAR, suzuki4,                                       \
      "five steps of boris; M. Suzuki, Phys. Lett. A 146 (1990) 319")                              \
    X(A, boris6, 6, 9, 0, PK_SYMMETRIC | PK_LINEAR, kahan_li6,                                     \
      "nine steps of boris; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089")

/* Compositions of respa steps; `table` is the splitting method with the same composition. Stages
 * are counted for ten inner steps. */
#define PK_NEEDS_RESPA (PK_MASS_CONSTANT | PK_SEPARABLE | PK_FAST)
#define PK_METHODS_RESPA(X, A)                                                                     \
    X(A, respa, 2, 12, 0, PK_TRAITS_SYMPLECTIC, verlet,                                            \
      "slow kicks around ten fast Verlet steps; M. Tuckerman et al., J. Chem. Phys. 97 (1992) "    \
      "1990")                                                                                      \
    X(A, respa4, 4, 56, 0, PK_TRAITS_SYMPLECTIC, suzuki4,                                          \
      "five steps of respa; M. Suzuki, Phys. Lett. A 146 (1990) 319")

#define PK_NEEDS_ADAPTIVE_VERLET (PK_MASS_CONSTANT | PK_SEPARABLE | PK_AUTONOMOUS)
#define PK_METHODS_ADAPTIVE_VERLET(X, A)                                                           \
    X(A, adaptive_verlet, 2, 1, 2, PK_SYMMETRIC | PK_ADAPTIVE | PK_DENSE | PK_LINEAR, none,        \
      "Verlet with reversible steps that follow ||da/dq||; W. Huang, B. Leimkuhler, "              \
      "SIAM J. Sci. Comput. 18 (1997) 239")

/* Implicit Runge-Kutta methods in (q, p). */
#define PK_TRAITS_COLLOCATION (PK_IMPLICIT | PK_JACOBIANS)
#define PK_NEEDS_COLLOCATION 0
#define PK_METHODS_COLLOCATION(X, A)                                                               \
    X(A, gauss1, 2, 1, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss1,                    \
      "implicit midpoint rule in (q, p); GNI II.1.3, VI.4")                                        \
    X(A, gauss2, 4, 2, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss2,                    \
      "Gauss-Legendre, 2 stages, in (q, p); P. C. Hammer, J. W. Hollingsworth (1955)")             \
    X(A, gauss3, 6, 3, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss3,                    \
      "Gauss-Legendre, 3 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, gauss4, 8, 4, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss4,                    \
      "Gauss-Legendre, 4 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, gauss5, 10, 5, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss5,                   \
      "Gauss-Legendre, 5 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, gauss6, 12, 6, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss6,                   \
      "Gauss-Legendre, 6 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, gauss7, 14, 7, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss7,                   \
      "Gauss-Legendre, 7 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, gauss8, 16, 8, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, gauss8,                   \
      "Gauss-Legendre, 8 stages, in (q, p); J. C. Butcher, Math. Comp. 18 (1964) 50")              \
    X(A, lobatto2, 2, 2, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, lobatto2,                \
      "Lobatto IIIA-IIIB, 2 stages, in (q, p), Verlet for any L; GNI II.2.2, VI.4")                \
    X(A, lobatto3, 4, 3, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, lobatto3,                \
      "Lobatto IIIA-IIIB, 3 stages, in (q, p); G. Sun (1993), GNI II.2.2, VI.4")                   \
    X(A, lobatto4, 6, 4, 0, PK_TRAITS_SYMPLECTIC | PK_TRAITS_COLLOCATION, lobatto4,                \
      "Lobatto IIIA-IIIB, 4 stages, in (q, p); G. Sun (1993), GNI II.2.2, VI.4")                   \
    X(A, radau5, 5, 3, 0, PK_TRAITS_COLLOCATION, radau5,                                           \
      "Radau IIA, 3 stages, in (q, p), L-stable; Hairer, Wanner II, IV.5")                         \
    X(A, radau9, 9, 5, 0, PK_TRAITS_COLLOCATION, radau9,                                           \
      "Radau IIA, 5 stages, in (q, p), L-stable; Hairer, Wanner II, IV.5, IV.8")

#define PK_NEEDS_EMBEDDED 0
#define PK_METHODS_EMBEDDED(X, A)                                                                  \
    X(A, dopri5, 5, 6, 4, PK_ADAPTIVE | PK_DENSE, dopri5,                                          \
      "Dormand-Prince 5(4), PI control; J. Comp. Appl. Math. 6 (1980) 19, HNW II.5")               \
    X(A, dop853, 8, 12, 7, PK_ADAPTIVE | PK_DENSE, dop853,                                         \
      "Dormand-Prince 8(5,3); Hairer, Norsett, Wanner, HNW II.5 and II.10")

#define PK_NEEDS_GAUSS PK_SMOOTH
#define PK_METHODS_GAUSS(X, A)                                                                     \
    X(A, gauss, 16, 8, 16, PK_SYMMETRIC | PK_ADAPTIVE | PK_IMPLICIT | PK_DENSE,                    \
      gauss8,                                                                                      \
      "adaptive Gauss-Legendre, 8 stages, in (q, q'), symmetric where M varies, symplectic where " \
      "not; after Antonana, Makazaga, Murua (2017) and Rein, Spiegel (2015)")

/* The order follows from the tolerance. */
#define PK_NEEDS_TAYLOR (PK_SERIES | PK_SMOOTH)
#define PK_METHODS_TAYLOR(X, A)                                                                    \
    X(A, taylor, 0, 0, 30, PK_ADAPTIVE | PK_DENSE | PK_JETS, none,                                 \
      "Taylor series of order 1 - ln(rtol)/2 or more; A. Jorba, M. Zou, Exp. Math. 14 (2005) 99")

#define PK_NEEDS_RADAU 0
#define PK_METHODS_RADAU(X, A)                                                                     \
    X(A, radau, 5, 3, 0, PK_ADAPTIVE | PK_TRAITS_COLLOCATION, radau5,                              \
      "adaptive Radau IIA, 3 stages, in (q, p), L-stable, for stiff and dissipative systems; "     \
      "RADAU5, Hairer, Wanner II, IV.8")

#define PK_NEEDS_EXPONENTIAL PK_AFFINE
#define PK_METHODS_EXPONENTIAL(X, A)                                                               \
    X(A, exponential, 0, 0, 0, PK_TRAITS_SYMPLECTIC | PK_DENSE | PK_EXACT, none,                   \
      "the exact flow of an affine system, by the exponential of its matrix, scaled and "          \
      "squared; N. J. Higham, SIAM J. Matrix Anal. Appl. 26 (2005) 1179")

/* Methods for models with noise, at a fixed step; the weak order is given. */
#define PK_NEEDS_HEUN 0
#define PK_METHODS_HEUN(X, A)                                                                      \
    X(A, heun, 2, 2, 0, PK_NOISE, heun,                                                            \
      "stochastic Heun, for noise and any M and f; P. E. Kloeden, E. Platen (1992) 15.1")
#define PK_NEEDS_LANGEVIN (PK_MASS_CONSTANT | PK_LINEAR_DRAG)
#define PK_METHODS_LANGEVIN(X, A)                                                                  \
    X(A, baoab, 2, 1, 0, PK_NOISE, baoab,                                                          \
      "Verlet around the exact flow of friction and noise; B. Leimkuhler, C. Matthews (2013)")     \
    X(A, stochastic_verlet, 2, 1, 0, PK_NOISE, stochastic_verlet,                                  \
      "Verlet with friction and noise; N. Gronbech-Jensen, O. Farago, Mol. Phys. 111 (2013) 983")

/* Methods for rotations and constraints; `table`: the splitting method of that composition. */
#define PK_TRAITS_VARIATIONAL                                                                      \
    (PK_TRAITS_SYMPLECTIC | PK_IMPLICIT | PK_HOLONOMIC | PK_GROUP)
#define PK_NEEDS_LIE_MIDPOINT 0
#define PK_METHODS_LIE_MIDPOINT(X, A)                                                              \
    X(A, lie_midpoint, 2, 1, 0, PK_TRAITS_VARIATIONAL, verlet,                                     \
      "L at the middle, on SO(3) too; Bou-Rabee, Marsden, Found. Comput. Math. 9 (2009) 197")      \
    X(A, lie_midpoint4, 4, 5, 0, PK_TRAITS_VARIATIONAL, suzuki4,                                   \
      "five steps of lie_midpoint; M. Suzuki, Phys. Lett. A 146 (1990) 319")                       \
    X(A, lie_midpoint6, 6, 9, 0, PK_TRAITS_VARIATIONAL, kahan_li6,                                 \
      "nine steps of lie_midpoint; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089")
#define PK_NEEDS_RATTLE 0
#define PK_METHODS_RATTLE(X, A)                                                                    \
    X(A, rattle, 2, 2, 0, PK_TRAITS_VARIATIONAL, verlet,                                           \
      "Verlet for any L, constraints, SO(3); H. C. Andersen, J. Comput. Phys. 52 (1983) 24")       \
    X(A, rattle4, 4, 10, 0, PK_TRAITS_VARIATIONAL, suzuki4,                                        \
      "five steps of rattle; M. Suzuki, Phys. Lett. A 146 (1990) 319")                             \
    X(A, rattle6, 6, 18, 0, PK_TRAITS_VARIATIONAL, kahan_li6,                                      \
      "nine steps of rattle; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089")

#define PK_NEEDS_RKMK 0
#define PK_METHODS_RKMK(X, A)                                                                      \
    X(A, rkmk4, 4, 4, 0, PK_GROUP, rk4,                                                            \
      "rk4 on SO(3); H. Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115")                            \
    X(A, rkmk8, 8, 12, 0, PK_GROUP, dop853,                                                        \
      "dop853 at a fixed step, on SO(3); H. Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115")

/* All methods except GSL's, in the order of listings. */
#define PK_METHODS_CORE(X, A)                                                                      \
    PK_METHODS_ERK(X, A) PK_METHODS_SPLITTING(X, A) PK_METHODS_BORIS(X, A)                         \
    PK_METHODS_RESPA(X, A) PK_METHODS_ADAPTIVE_VERLET(X, A)                                        \
    PK_METHODS_COLLOCATION(X, A) PK_METHODS_EMBEDDED(X, A) PK_METHODS_GAUSS(X, A)                  \
    PK_METHODS_TAYLOR(X, A) PK_METHODS_RADAU(X, A) PK_METHODS_EXPONENTIAL(X, A) PK_METHODS_LIE_MIDPOINT(X, A)              \
    PK_METHODS_RATTLE(X, A) PK_METHODS_RKMK(X, A) PK_METHODS_HEUN(X, A)                           \
    PK_METHODS_LANGEVIN(X, A)

/* Macros for X: PK_NAME_OF expands to A(name), PK_DECLARE_METHOD declares pk_method_NAME, and
 * PK_DEFINE_METHOD defines it, with struct members of the family from A(table). */
#define PK_NAME_OF(A, name, ...) A(name)
#define PK_DECLARE_METHOD(A, name, ...) extern const struct pk_method pk_method_##name;
#define PK_DEFINE_METHOD(A, symbol, p, s, p_dense, flags, of, text)                                \
    const struct pk_method pk_method_##symbol = {.name = #symbol,                                  \
                                                 .doc = text,                                      \
                                                 .order = p,                                       \
                                                 .stages = s,                                      \
                                                 .dense_order = p_dense,                           \
                                                 .traits = flags,                                  \
                                                 A(of)};

/* Declarations of all methods, such as pk_method_rk4. A program that names one method links only
 * its family; pk_method_find() links all families. */
PK_BEGIN
PK_METHODS_CORE(PK_DECLARE_METHOD, )
PK_END

#endif
