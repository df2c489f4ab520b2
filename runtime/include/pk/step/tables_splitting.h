/* The tables of splitting methods: kicks and drifts as fractions of a step. The tables of order 6
 * and 8, and of Blanes and Moan, are published with 15 to 26 digits; Newton's method makes them
 * satisfy their order conditions exactly (tools/compositions.py).
 *
 * The methods of Blanes and Moan are Runge-Kutta-Nystrom methods, which require a kinetic energy of
 * second degree in p; separable systems have such a kinetic energy, also if time, like a
 * coordinate, advances in the drift. All other methods have their order for any two flows.
 *
 * Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. ("GNI"),
 * I.1, II.4, V.3. */
#ifndef PK_STEP_TABLES_SPLITTING_H
#define PK_STEP_TABLES_SPLITTING_H

#include <pk/methods.h>
#include <pk/step/tableau.h>

#ifndef PK_SPLITTING_METHODS
#define PK_SPLITTING_METHODS(X) PK_METHODS_SPLITTING(PK_NAME_OF, X)
#endif

/* clang-format off */
/* These macros write a symmetric list, given its first half: PK_MIRROR lists of odd length,
 * PK_TWICE lists of even length. */
#define PK_MIRROR_1(a) a
#define PK_MIRROR_2(a, ...) a, PK_MIRROR_1(__VA_ARGS__), a
#define PK_MIRROR_3(a, ...) a, PK_MIRROR_2(__VA_ARGS__), a
#define PK_MIRROR_4(a, ...) a, PK_MIRROR_3(__VA_ARGS__), a
#define PK_MIRROR_5(a, ...) a, PK_MIRROR_4(__VA_ARGS__), a
#define PK_MIRROR_6(a, ...) a, PK_MIRROR_5(__VA_ARGS__), a
#define PK_MIRROR_7(a, ...) a, PK_MIRROR_6(__VA_ARGS__), a
#define PK_MIRROR_8(a, ...) a, PK_MIRROR_7(__VA_ARGS__), a
#define PK_MIRROR_9(a, ...) a, PK_MIRROR_8(__VA_ARGS__), a
#define PK_TWICE_1(a) a, a
#define PK_TWICE_2(a, ...) a, PK_TWICE_1(__VA_ARGS__), a
#define PK_TWICE_3(a, ...) a, PK_TWICE_2(__VA_ARGS__), a
#define PK_TWICE_4(a, ...) a, PK_TWICE_3(__VA_ARGS__), a
#define PK_TWICE_5(a, ...) a, PK_TWICE_4(__VA_ARGS__), a
#define PK_TWICE_6(a, ...) a, PK_TWICE_5(__VA_ARGS__), a
/* The kicks of a composition of Verlet steps: a kick is the mean of two successive lengths. */
#define PK_HALF(a, ...) (a) / 2
#define PK_KICKS_2(a, b) (a + b) / 2, (a + b) / 2
#define PK_KICKS_3(a, b, ...) (a + b) / 2, PK_KICKS_2(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_4(a, b, ...) (a + b) / 2, PK_KICKS_3(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_5(a, b, ...) (a + b) / 2, PK_KICKS_4(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_6(a, b, ...) (a + b) / 2, PK_KICKS_5(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_7(a, b, ...) (a + b) / 2, PK_KICKS_6(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_8(a, b, ...) (a + b) / 2, PK_KICKS_7(b, __VA_ARGS__), (a + b) / 2
#define PK_KICKS_9(a, b, ...) (a + b) / 2, PK_KICKS_8(b, __VA_ARGS__), (a + b) / 2
#define PK_VERLETS(method, half, ...)                                                              \
    static const pk_real pk_##method##_drift[] = {PK_MIRROR_##half(__VA_ARGS__)};                  \
    static const pk_real pk_##method##_kick[] = {                                                  \
        PK_HALF(__VA_ARGS__), PK_KICKS_##half(__VA_ARGS__), PK_HALF(__VA_ARGS__)};

/* The symplectic Euler method. R. de Vogelaere (1956), GNI I.1.9. */
static const pk_real pk_symplectic_euler_kick[] = {PK_C(1.0), PK_C(0.0)};
static const pk_real pk_symplectic_euler_drift[] = {PK_C(1.0)};
/* The method of L. Verlet, Phys. Rev. 159 (1967) 98. */
static const pk_real pk_verlet_kick[] = {PK_C(0.5), PK_C(0.5)};
static const pk_real pk_verlet_drift[] = {PK_C(1.0)};
/* Triple jump, three Verlet steps: w1 = 1/(2 - 2^(1/3)), w0 = 1 - 2 w1. H. Yoshida, Phys. Lett. A
 * 150 (1990) 262. */
PK_VERLETS(yoshida4, 2, PK_C(1.35120719195965763404768780897146083),
    PK_C(-1.70241438391931526809537561794292165))
/* Five Verlet steps, four of length h/(4 - 4^(1/3)). M. Suzuki, Phys. Lett. A 146 (1990) 319. */
PK_VERLETS(suzuki4, 3, PK_C(0.414490771794375737142354062860761496),
    PK_C(0.414490771794375737142354062860761496), PK_C(-0.657963087177502948569416251443045983))
/* The kicks are (14 - r)/108, (20 - 7 r)/108, (5 + 2 r)/27, r = sqrt(19). R. I. McLachlan, SIAM J.
 * Sci. Comput. 16 (1995) 151. */
static const pk_real pk_mclachlan4_kick[] = {PK_TWICE_3(
    PK_C(0.0892694542264752448866946112605591143), PK_C(-0.0973360426368955080153599433983084224),
    PK_C(0.508066588410420263128665332137749308))};
static const pk_real pk_mclachlan4_drift[] = {PK_MIRROR_3(PK_C(0.4), PK_C(-0.1), PK_C(0.4))};
/* The method SRKN_6^b of S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313. */
static const pk_real pk_blanes_moan4_kick[] = {PK_MIRROR_4(
    PK_C(0.0829844064174050188383474789422501125), PK_C(0.396309801498368077094911528263686739),
    PK_C(-0.0390563049223484351708652907653792423), PK_C(0.119524194013150678475212567118884781))};
static const pk_real pk_blanes_moan4_drift[] = {PK_TWICE_3(
    PK_C(0.24529895718427116260393242600140088), PK_C(0.604872665711079974960892697643076245),
    PK_C(-0.350171622895351137564825123644477126))};
/* Solution A of 7 Verlet steps. H. Yoshida, Phys. Lett. A 150 (1990) 262, Table 1. */
PK_VERLETS(yoshida6, 4, PK_C(0.784513610477557263819497633866349876),
    PK_C(0.235573213359358133684793182978534602), PK_C(-1.17767998417887100694641568096431573),
    PK_C(1.31518632068391121888424972823886251))
/* The method s9odr6a of W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089. */
PK_VERLETS(kahan_li6, 5, PK_C(0.392161444007314139279250555181182322),
    PK_C(0.332599136789359438599748640320274208), PK_C(-0.706246172557639359809964819474763722),
    PK_C(0.0822135962935508002314904474488281139), PK_C(0.798543990934829963398950353048958155))
/* The method SRKN_11^b of S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313. */
static const pk_real pk_blanes_moan6_kick[] = {PK_TWICE_6(
    PK_C(0.0414649985182628432987781339147049367), PK_C(0.198128671918066541136726473181496961),
    PK_C(-0.0400061921041526868888283635359448394), PK_C(0.0752539843015803411278788785270427555),
    PK_C(-0.0115113874206877700624432015012891996), PK_C(0.236669924786930731387888079413989386))};
static const pk_real pk_blanes_moan6_drift[] = {PK_MIRROR_6(
    PK_C(0.123229775946271151561086380333366753), PK_C(0.290553797799558270366414169327916183),
    PK_C(-0.127049212625416915662505053827485934), PK_C(-0.246331761062075404194973489104062863),
    PK_C(0.357208872795927752619860349619310463), PK_C(0.204777054291470290620235287301910797))};
/* Solution D of 15 Verlet steps. H. Yoshida, Phys. Lett. A 150 (1990) 262, Table 2. */
PK_VERLETS(yoshida8, 8, PK_C(0.914844246229791566748793489847509605),
    PK_C(0.253693336566211354146146020689942076), PK_C(-1.44485223686060515769473065753739035),
    PK_C(-0.158240635368050175204066776759754248), PK_C(1.93813913762252598657918648744364176),
    PK_C(-1.96061023297531080760763337639966364), PK_C(0.102799849391796440698115131601225863),
    PK_C(1.70845307078728158466837936222897788))
/* The method s17odr8a of W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089. */
PK_VERLETS(kahan_li8, 9, PK_C(0.130202483088890080878817632262549105),
    PK_C(0.561162981775108384561964407701586265), PK_C(-0.389474962644847286408078598645940965),
    PK_C(0.158841906555155600896210745630383764), PK_C(-0.395903894133237577336231539022190733),
    PK_C(0.184539640978315707091832541388566593), PK_C(0.258374387686322047293979109860431337),
    PK_C(0.295011723609310298870966240491973928), PK_C(-0.605508533830034511698921079334718588))
/* clang-format on */

#define PK_SPLITTING_TABLE(method, s)                                              \
    static const struct pk_splitting pk_##method##_table = {s, pk_##method##_kick, \
                                                            pk_##method##_drift}
PK_SPLITTING_TABLE(symplectic_euler, 1);
PK_SPLITTING_TABLE(verlet, 1);
PK_SPLITTING_TABLE(yoshida4, 3);
PK_SPLITTING_TABLE(suzuki4, 5);
PK_SPLITTING_TABLE(mclachlan4, 5);
PK_SPLITTING_TABLE(blanes_moan4, 6);
PK_SPLITTING_TABLE(yoshida6, 7);
PK_SPLITTING_TABLE(kahan_li6, 9);
PK_SPLITTING_TABLE(blanes_moan6, 11);
PK_SPLITTING_TABLE(yoshida8, 15);
PK_SPLITTING_TABLE(kahan_li8, 17);
#undef PK_SPLITTING_TABLE

#endif
