/* Radau IIA collocation of 3 and 5 stages, orders 5 and 9: L-stable and stiffly accurate (the last
 * stage is the end of the step), for what is stiff and dissipates. Nodes are the roots of
 * d^(s-1)/dx^(s-1) (x^(s-1) (x-1)^s), b_i and a_ij the integrals of the Lagrange polynomials,
 * mu_ij = a_ij / b_j, by columns; computed in 60 digits (mpmath).
 *
 * References: O. Axelsson, BIT 9 (1969) 185; B. L. Ehle (1969); E. Hairer, G. Wanner, Solving
 * Ordinary Differential Equations II, IV.5 (Table 5.6), IV.8; their radau codes, J. Comp. Appl.
 * Math. 111 (1999) 93.
 */
#include "../core/tableau.h"

static const pk_real radau5_c[] = {
    PK_C(0.1550510257216821901802715925294108608), PK_C(0.6449489742783178098197284074705891392),
    PK_C(1.0),
};
static const pk_real radau5_b[] = {
    PK_C(0.37640306270046727505007544236928079467),
    PK_C(0.51248582618842161383881344651960809422),
    PK_C(0.11111111111111111111111111111111111111),
};
static const pk_real radau5_mu[] = {
    PK_C(0.52288489846928149025730607288282344264), PK_C(1.0478775382679627435673481779294139341),
    PK_C(1.0), PK_C(-0.12787753826796274356734817792941393407),
    PK_C(0.56991510153071850974269392711717655736), PK_C(1.0),
    PK_C(0.21393876913398137178367408896470696704),
    PK_C(-0.37393876913398137178367408896470696704), PK_C(1.0),
};
static const pk_real radau9_c[] = {
    PK_C(0.057104196114517682193121192554115621235),
    PK_C(0.27684301363812382768004599768562514111),
    PK_C(0.58359043236891682005669766866291724869),
    PK_C(0.86024013565621944784791291887511976674), PK_C(1.0),
};
static const pk_real radau9_b[] = {
    PK_C(0.14371356079122594132341221985411022716), PK_C(0.2813560151494620601921726503406598912),
    PK_C(0.31182652297574125408185491157664052199),
    PK_C(0.22310390108357074440256021822858935965), PK_C(0.04),
};
static const pk_real radau9_mu[] = {
    PK_C(0.50794694610586867189567956445336843066), PK_C(1.0700119782194612253297733993281092202),
    PK_C(0.97459867331713248774756447735610328097), PK_C(1.008215977057475453478404216678030976),
    PK_C(1.0), PK_C(-0.095023136767640166109417908662714741612),
    PK_C(0.51967919637268527321448254079053504855), PK_C(1.0625937011954979376232579314211682219),
    PK_C(0.98274091852373138437516400643854305163), PK_C(1.0),
    PK_C(0.059895257099208774604202081592870032896),
    PK_C(-0.1168744998255434426988378824917854149),
    PK_C(0.53743045503632913323239285838899272273), PK_C(1.044805040319699456713763558007152412),
    PK_C(1.0), PK_C(-0.057726942607257038898098911702583087163),
    PK_C(0.095171187129315109857426657540582255424),
    PK_C(-0.15225687010239021592482811972456301895),
    PK_C(0.57711565162941627159266674913953872655), PK_C(1.0),
    PK_C(0.12607098084705038016625547912350220389),
    PK_C(-0.19838949756821943831555697603644571424),
    PK_C(0.27360721860480630686248022878795698724),
    PK_C(-0.39272293447013320969473642125163289466), PK_C(1.0),
};

#define RADAU(s, p, text)                                                                   \
    const struct pk_gauss pk_radau##p##_table = {s, radau##p##_c, radau##p##_b, radau##p##_mu, 0}; \
    const struct pk_method pk_radau##p = {.name = "radau" #p,                               \
                                          .doc = text,                                      \
                                          .order = p,                                       \
                                          .stages = s,                                      \
                                          .traits = PK_IMPLICIT | PK_JACOBIANS | PK_QUADRATURE, \
                                          .table = &pk_radau##p##_table,                    \
                                          .size = pk_gauss_size,                            \
                                          .init = pk_gauss_init,                            \
                                          .step = pk_gauss_step,                            \
                                          .stage = pk_gauss_stage}

RADAU(3, 5, "Radau IIA, 3 stages, in (q, p), L-stable; Hairer, Wanner II, IV.5");
RADAU(5, 9, "Radau IIA, 5 stages, in (q, p), L-stable; Hairer, Wanner II, IV.5, IV.8");
