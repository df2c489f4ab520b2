/* Elliptic integrals against GSL's (Carlson's forms, another algorithm), against series at the ends
 * of the range, and the pendulum against REGIMES P1 and P2.
 */
#include <pk/elliptic.h>

#include "fixture.h"

/* Of GSL, with which the tests are linked; its headers are runtime/gsl's alone. Mode 0 is double.
 */
double gsl_sf_ellint_Kcomp(double k, unsigned mode);
double gsl_sf_ellint_Ecomp(double k, unsigned mode);

static const double PI = 3.14159265358979323846;
static const double ULP = 2.220446049250313e-16;

static int near(double x, double y, double ulps) { return fabs(x - y) <= ulps * ULP * fabs(y); }

static void against_gsl(void)
{
    /* k itself is what GSL takes: an m that is its square to the last bit. By 30 digits ours are
     * within 1.8 units of 2^-52, GSL's within 2.7 (K) and 6.2 (E). */
    for (int i = -400; i < 1000; i++) {
        const double k = (i < 0 ? 0 : i) / 1024.0, m = k * k;
        CU_ASSERT(near(pk_elliptic_k(m), gsl_sf_ellint_Kcomp(k, 0), 4));
        CU_ASSERT(near(pk_elliptic_e(m), gsl_sf_ellint_Ecomp(k, 0), 8));
        if (i < 0) { /* m < 0: K(m) = K(m/(m - 1))/sqrt(1 - m); A&S 17.4.17 */
            const double of = i / 64.0, root = sqrt(1 - of), modulus = sqrt(of / (of - 1));
            CU_ASSERT(near(pk_elliptic_k(of), gsl_sf_ellint_Kcomp(modulus, 0) / root, 8));
            CU_ASSERT(near(pk_elliptic_e(of), gsl_sf_ellint_Ecomp(modulus, 0) * root, 8));
        }
    }
}

static void at_the_ends(void)
{
    struct pk_elliptic found;
    for (double small = 1e-300; small < 1e-16; small *= 1e3) {
        /* 1 - m by itself has the digits: K -> ln(16/(1 - m))/2, E -> 1 (A&S 17.3.26). */
        pk_elliptic_find(1 - small, small, &found);
        CU_ASSERT(near(found.k, (log(16) - log(small)) / 2, 4));
        CU_ASSERT(near(found.e, 1, 2) && near(found.b, 1, 2));
        /* And K, E -> pi/2, E - (1 - m) K -> pi m/4, where the difference itself has none. */
        pk_elliptic_find(small, 1 - small, &found);
        CU_ASSERT(near(found.k, PI / 2, 2) && near(found.e, PI / 2, 2));
        CU_ASSERT(near(found.b, PI * small / 4, 2));
    }
    /* The two ways to E meet. */
    for (double m1 = 0.124; m1 < 0.126; m1 += 0.0001) {
        pk_elliptic_find(1 - m1, m1, &found);
        CU_ASSERT(near(found.b, found.e - m1 * found.k, 8));
        CU_ASSERT(near(found.e, gsl_sf_ellint_Ecomp(sqrt(1 - m1), 0), 8));
    }
    CU_ASSERT(isinf(pk_elliptic_k(1)) && pk_elliptic_k(1) > 0);
    CU_ASSERT(near(pk_elliptic_e(1), 1, 0));
    CU_ASSERT(isnan(pk_elliptic_k(1.5)) && isnan(pk_elliptic_e(NAN)) && isnan(pk_elliptic_k(NAN)));
}

static void pendulum(void)
{
    /* P1: periods over that of small swings. */
    static const double period[][2] = {
        {90, 1.1803405990}, {170, 2.4393627197}, {179, 3.9010651604}, {179.9, 5.3668671090}};
    for (int i = 0; i < 4; i++)
        CU_ASSERT(fabs(pk_pendulum_period(period[i][0] * PI / 180) / (2 * PI) - period[i][1]) <
                  6e-11);
    /* P2: at m = .5 the action and the frequency, 8/pi at the separatrix. */
    CU_ASSERT(fabs(pk_pendulum_action(PI / 2) - 1.0787052024) < 6e-11);
    CU_ASSERT(fabs(2 * PI / pk_pendulum_period(PI / 2) - .8472130848) < 6e-11);
    CU_ASSERT(near(pk_pendulum_energy_action(0), 8 / PI, 1));
    CU_ASSERT(pk_pendulum_energy_period(0) > 1e300);
    CU_ASSERT(isnan(pk_pendulum_energy_period(-3)) && isnan(pk_pendulum_energy_action(-3)));
    CU_ASSERT(isnan(pk_pendulum_period(3.2)) && isnan(pk_pendulum_action(7)));
    CU_ASSERT(isinf(pk_pendulum_energy_period(0)));
    /* By energy as by amplitude; of small swings amplitude^2/2. */
    for (double amplitude = 0.5; amplitude < 3; amplitude += 0.1) {
        const double above = -1 - cos(amplitude);
        CU_ASSERT(near(pk_pendulum_energy_period(above), pk_pendulum_period(amplitude), 64));
        CU_ASSERT(near(pk_pendulum_energy_action(above), pk_pendulum_action(amplitude), 64));
    }
    CU_ASSERT(near(pk_pendulum_action(1e-9), 0.5e-18, 4));
    /* dJ/dE = period/(2 pi) on both sides of the separatrix, by a central difference. */
    for (double above = -1.5; above < 4; above += 0.35) {
        const double d = 1e-5, slope = (pk_pendulum_energy_action(above + d) -
                                        pk_pendulum_energy_action(above - d)) /
                                       (2 * d);
        CU_ASSERT(fabs(slope * 2 * PI / pk_pendulum_energy_period(above) - 1) < 1e-8);
    }
    /* Turning fast it is free: theta' = sqrt(2 above) (1 + 1/(2 above) ...). */
    CU_ASSERT(near(pk_pendulum_energy_action(1e20), sqrt(2e20), 4));
    CU_ASSERT(near(pk_pendulum_energy_period(1e20), 2 * PI / sqrt(2e20), 4));
}

void add_elliptic(void)
{
    CU_pSuite suite = CU_add_suite("elliptic integrals", NULL, NULL);
    CU_add_test(suite, "against GSL's", against_gsl);
    CU_add_test(suite, "near 0 and 1", at_the_ends);
    CU_add_test(suite, "the pendulum's periods and actions", pendulum);
}
