/* Angular momentum and the vector of Laplace, Runge and Lenz, on states whose values are plain. */
#include "../../runtime/run/diagnose/bodies.h"

#include "fixture.h"

static int near(double x, double y) { return fabs(x - y) <= 1e-15 * (1 + fabs(y)); }

TEST("angular momentum about two places")
{
    /* Two masses 1 and 3 at the ends of a rod that turns by (0, 0, 2) and is carried along. */
    const double m[] = {1, 3}, r[] = {4, 1, 5, 0, 1, 5}, v[] = {1, 6, 7, 1, -2, 7};
    double L[3], size;
    angular_momentum(2, m, r, v, 1, L, &size);
    CU_ASSERT(near(L[0], 0) && near(L[1], 0) && near(L[2], 2 * 0.75 * 16) && near(size, 24));
    angular_momentum(2, m, r, v, 0, L, &size); /* and of the centre, 4 R x V, R = (1 1 5) */
    CU_ASSERT(near(L[0], 4 * 7) && near(L[1], 4 * (5 - 7)) && near(L[2], 24 - 4));
    CU_ASSERT(size > 24);
}

/* An orbit about the origin of eccentricity e whose pericentre is in the direction of angle w, in a
 * plane that is tilted. */
static struct relative at(double e, double w, double f)
{
    struct relative o;
    const double k = 2, p = 0.7, d = p / (1 + e * cos(f)), s = sqrt(k / p);
    const double x[3] = {d * cos(f + w), d * sin(f + w), 0};
    const double u[3] = {-s * (sin(f + w) + e * sin(w)), s * (cos(f + w) + e * cos(w)), 0};
    for (int i = 0; i < 3; i++) {
        o.r[i] = i == 0 ? x[0] : i == 1 ? 0.6 * x[1] : 0.8 * x[1];
        o.v[i] = i == 0 ? u[0] : i == 1 ? 0.6 * u[1] : 0.8 * u[1];
        o.a[i] = -k * o.r[i] / (d * d * d);
    }
    return o;
}

TEST("Laplace, Runge and Lenz")
{
    struct lrl lrl;
    struct relative o = at(0.3, 0.5, 2);
    CU_ASSERT(lrl_begin(&lrl, &o));
    CU_ASSERT(near(lrl.k, 2) && near(lrl.eccentricity, 0.3) && lrl.rate < 1e-15);
    CU_ASSERT(near(lrl.e[0], 0.3 * cos(0.5)) && near(lrl.e[1], 0.18 * sin(0.5)));
    CU_ASSERT(near(lrl.e[2], 0.24 * sin(0.5)));
    /* It turns with the motion, and more than once. */
    for (double w = 0.5; w < 20; w += 1) {
        o = at(0.3, w, 3 * w);
        lrl_update(&lrl, &o);
        CU_ASSERT(fabs(lrl.angle - (w - 0.5)) < 1e-14 * (1 + w));
    }
    /* Backwards is the other sense. */
    for (int i = 0; i < 3; i++)
        o.v[i] = -o.v[i];
    CU_ASSERT(lrl_begin(&lrl, &o));
    o = at(0.3, 19.4, 1);
    lrl_update(&lrl, &o);
    CU_ASSERT(fabs(lrl.angle - 0.1) < 1e-13);
    for (int i = 0; i < 3; i++)
        o.a[i] = 2 * o.a[i];
    lrl_update(&lrl, &o); /* twice the force: not what k is */
    CU_ASSERT(lrl.rate > 0.1);
    for (int i = 0; i < 3; i++)
        o.a[i] = -o.a[i];
    CU_ASSERT(!lrl_begin(&lrl, &o));
}
