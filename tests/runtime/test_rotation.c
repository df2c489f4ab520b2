/* Rotations (orders: test_constraint.c): what each keeps of a free body over long runs, the
 * symplectic form of T*SO(3), reversal; each with a method that fails it.
 */
#include "attitude_series.h"
#include "fixture.h"

static const char *const steps[] = {"lie_midpoint", "lie_midpoint4", "lie_midpoint6",
                                    "rattle",       "rattle4",       "rattle6",
                                    "rkmk4",        "rk4",           "gauss2"};
enum { STEPS = sizeof steps / sizeof *steps, VARIATIONAL = 6 };

/* R p of the momenta of the body whose rates begin at v[at], its quaternion at v[of]. */
static void in_space(const struct fixture *f, size_t at, size_t of, double *L)
{
    double p[FIXTURE_N], pdot[FIXTURE_N];
    const double *Q = f->it.v + of;
    f->problem.system->unconstrained(&f->params, f->it.t, f->it.q, f->it.v, NULL, p, pdot);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double c[] = {Q[1 + j] * p[at + (size_t)k] - Q[1 + k] * p[at + (size_t)j],
                            Q[1 + k] * p[at + (size_t)i] - Q[1 + i] * p[at + (size_t)k],
                            Q[1 + i] * p[at + (size_t)j] - Q[1 + j] * p[at + (size_t)i]};
        L[i] += p[at + (size_t)i] + 2 * (Q[0] * c[0] + (Q[1 + j] * c[2] - Q[1 + k] * c[1]));
    }
}

struct kept {
    double norm, energy, late, square, vector; /* late: energy at the end, mean of 1000 steps */
};

/* Largest deviations over a run of the free body, or of two: then of their sum. */
static struct kept keeps(const struct pk_system *system, const char *method, double h, long count)
{
    static struct fixture f;
    struct kept k = {0};
    double start[3] = {0}, E0, L2;
    fixture_open(&f, system, method, h);
    const size_t bodies = system->n_rotations;
    for (size_t b = 0; b < bodies; b++)
        in_space(&f, 3 * b, 3 * bodies + 4 * b, start);
    E0 = fixture_energy(&f);
    L2 = start[0] * start[0] + start[1] * start[1] + start[2] * start[2];
    for (long i = 0; i < count; i++) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
        const double E = fabs(fixture_energy(&f) / E0 - 1);
        k.energy = fmax(k.energy, E);
        k.late += i >= count - 1000 ? E / 1000 : 0;
        if (i % 100 && i < count - 100)
            continue;
        double L[3] = {0}, square = 0, apart = 0;
        for (size_t b = 0; b < bodies; b++)
            in_space(&f, 3 * b, 3 * bodies + 4 * b, L);
        for (int j = 0; j < 3; j++) {
            square += L[j] * L[j];
            apart = fmax(apart, fabs(L[j] - start[j]));
        }
        k.square = fmax(k.square, fabs(square / L2 - 1));
        k.vector = fmax(k.vector, apart / sqrt(L2));
        k.norm = fmax(k.norm, fixture_residuals(&f).norm);
    }
    printf("\n    %-13s h = %-4g %7ld steps: norm %.1e, energy %.1e, |L|^2 %.1e, L %.1e", method, h,
           count, k.norm, k.energy, k.square, k.vector);
    return k;
}

TEST("what is kept of a free body")
{
    for (int i = 0; i < VARIATIONAL; i++) {
        const long count = i == 0 ? 1000000 : 30000;
        const struct kept k = keeps(&free_body_system, steps[i], 0.1, count);
        CU_ASSERT(k.norm > 0 && k.norm < 1e-15);
        CU_ASSERT(k.energy > 0 && k.energy < 2e-3 && k.late < k.energy);
        CU_ASSERT(k.square > 0 && k.square < 2e-13 && k.vector > 0 && k.vector < 2e-13);
    }
    /* Gauss: what is quadratic. L in space turns with what R errs by, of round-off too. */
    const struct kept gauss = keeps(&free_body_system, "gauss4", 0.1, 30000);
    CU_ASSERT(gauss.norm < 1e-15 && gauss.energy > 0 && gauss.energy < 1e-14);
    CU_ASSERT(gauss.square > 0 && gauss.square < 1e-14);
    const struct kept rkmk = keeps(&free_body_system, "rkmk4", 0.1, 30000);
    CU_ASSERT(rkmk.norm < 1e-15 && rkmk.energy > 1e-6 && rkmk.vector > 1e-6);
}

TEST("momentum of two bodies")
{
    for (int i = 0; i < VARIATIONAL; i += 3) {
        const struct kept k = keeps(&bodies_system, steps[i], 0.05, 100000);
        CU_ASSERT(k.energy > 1e-8 && k.energy < 2e-3 && k.late < k.energy);
        CU_ASSERT(k.vector > 0 && k.vector < 5e-13);
    }
    const struct kept rk4 = keeps(&bodies_system, "rk4", 0.05, 100000);
    CU_ASSERT(rk4.norm < 1e-15 && rk4.vector > 1e-6);
}

/* I = (1, 2, 3): its periods in closed form by elliptic integrals, 4 K(m)/rate (REGIMES T4); and
 * the growth of what is off the middle axis, Omega/sqrt(3). */
TEST("periods in closed form")
{
    static const struct {
        double omega[3], period;
    } rows[] = {{{0.01, 1, 0}, 41.509219529}, {{0, 1, 0.01}, 37.702071587}};
    static struct fixture f;
    for (int r = 0; r < 2; r++) {
        const char *const names[] = {"gauss", "rkmk8", "lie_midpoint6", "lie_midpoint"};
        const double h[] = {1e-13, 0.1, 0.1, 0.1}, bound[] = {1e-9, 1e-9, 1e-6, 1};
        for (int i = 0; i < 4; i++) {
            double worst = 0;
            fixture_set(&f, &free_body_system);
            memcpy(f.v0, rows[r].omega, sizeof rows[r].omega);
            fixture_start(&f, names[i], h[i]);
            CU_ASSERT(pk_integrator_to(&f.it, rows[r].period) == PK_DONE);
            for (int k = 0; k < 3; k++)
                worst = fmax(worst, fabs(f.it.v[k] - rows[r].omega[k]));
            printf("\n    after a period of %.9f s by %s: omega off by %.1e", rows[r].period,
                   names[i], worst);
            CU_ASSERT(worst > 0 && worst < bound[i] && (i < 3 || worst > 1e-6));
        }
    }
    const double off = 1e-6, t = 5;
    fixture_set(&f, &free_body_system); /* along what grows: omega_3 = -omega_1/sqrt(3) */
    f.v0[0] = off, f.v0[1] = 1, f.v0[2] = -off / sqrt(3);
    fixture_start(&f, "gauss", 1e-13);
    CU_ASSERT(pk_integrator_to(&f.it, t) == PK_DONE);
    const double rate = log(fabs(f.it.v[0]) / off) / t;
    printf("\n    growth about the middle axis %.9f, Omega/sqrt(3) = %.9f", rate, 1 / sqrt(3));
    CU_ASSERT(fabs(rate - 1 / sqrt(3)) < 1e-8);
}

/* Body-frame tangent (eta, dP) of the difference of two runs' ends, over d. */
static void tangent(const double *const *ends, const double *weights, double d, const double *Q,
                    double *eta, double *dP)
{
    double dQ[4] = {0};
    for (int i = 0; i < 3; i++)
        dP[i] = 0;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 4; i++)
            dQ[i] += weights[k] * ends[k][i] / d;
        for (int i = 0; i < 3; i++)
            dP[i] += weights[k] * ends[k][4 + i] / d;
    }
    for (int i = 0; i < 3; i++) { /* 2 conj(Q) dQ */
        const int j = 1 + (i + 1) % 3, l = 1 + (i + 2) % 3;
        eta[i] = 2 * (Q[0] * dQ[1 + i] - Q[1 + i] * dQ[0] - (Q[j] * dQ[l] - Q[l] * dQ[j]));
    }
}

/* d(P.eta) on two tangents: dP1.eta2 - dP2.eta1 - P.(eta1 x eta2). */
static double form(const double *P, const double *eta1, const double *dP1, const double *eta2,
                   const double *dP2)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        sum += dP1[i] * eta2[i] - dP2[i] * eta1[i] - P[i] * (eta1[j] * eta2[k] - eta1[k] * eta2[j]);
    }
    return sum;
}

/* The top's (Q, P) after two steps from its start, turned by e xi in the body frame and with e pi
 * more momentum. */
static void mapped(const char *method, double e, const double *xi, const double *pi, double h,
                   double *end)
{
    static struct fixture f;
    static const double I[] = {1.5, 1.5, 0.5};
    fixture_set(&f, &top_system);
    double *Q = f.v0 + 3, Q0[4];
    memcpy(Q0, Q, sizeof Q0);
    const double angle = e * sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
    const double c = cos(angle / 2), s = fabs(angle) > 0 ? sin(angle / 2) / angle * e : 0;
    const double r[] = {c, s * xi[0], s * xi[1], s * xi[2]};
    Q[0] = Q0[0] * r[0] - Q0[1] * r[1] - Q0[2] * r[2] - Q0[3] * r[3];
    for (int i = 0; i < 3; i++) {
        const int j = 1 + (i + 1) % 3, k = 1 + (i + 2) % 3;
        Q[1 + i] = Q0[0] * r[1 + i] + Q0[1 + i] * r[0] + Q0[j] * r[k] - Q0[k] * r[j];
        f.v0[i] += e * pi[i] / I[i];
    }
    fixture_start(&f, method, h);
    CU_ASSERT_FATAL(pk_integrator_to(&f.it, 2 * h) == PK_DONE);
    memcpy(end, f.it.v + 3, 4 * sizeof *end);
    for (int i = 0; i < 3; i++)
        end[4 + i] = I[i] * f.it.v[i];
}

static double symplectic_defect(const char *method)
{
    static const double xi[2][3] = {{0.3, -0.8, 0.4}, {-0.5, 0.2, 0.9}};
    static const double pi[2][3] = {{0.7, 0.5, -0.2}, {0.1, -0.6, 0.8}};
    static const double shift[] = {-2, -1, 1, 2}, weights[] = {1, -8, 8, -1};
    const double e = 2e-3, none[3] = {0}, h = 0.1;
    double P0[3], centre[7], eta[2][3], dP[2][3];
    mapped(method, 0, none, none, h, centre);
    for (int k = 0; k < 2; k++) {
        double ends[4][7];
        const double *of[4];
        for (int i = 0; i < 4; i++) {
            mapped(method, shift[i] * e, xi[k], pi[k], h, ends[i]);
            of[i] = ends[i];
        }
        tangent(of, weights, 12 * e, centre, eta[k], dP[k]);
    }
    static struct fixture f;
    fixture_set(&f, &top_system);
    for (int i = 0; i < 3; i++)
        P0[i] = (i < 2 ? 1.5 : 0.5) * f.v0[i];
    const double before = form(P0, xi[0], pi[0], xi[1], pi[1]);
    return fabs(form(centre + 4, eta[0], dP[0], eta[1], dP[1]) - before);
}

TEST("the symplectic form")
{
    for (int i = 0; i < 8; i++) {
        const double defect = symplectic_defect(steps[i]);
        printf("\n    %-13s form of T*SO(3) missed by %.1e", steps[i], defect);
        CU_ASSERT(i < VARIATIONAL ? defect > 0 && defect < 2e-9 : defect > 1e-6);
    }
}

TEST("reversal")
{
    static struct fixture f;
    for (int i = 0; i < 8; i++) {
        CU_ASSERT(fixture_run(&f, &bodies_system, steps[i], 0.05, 2) == PK_DONE);
        CU_ASSERT(fixture_distance(&f, f.q0, f.v0) > 0.1);
        CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
        const double lost = fixture_distance(&f, f.q0, f.v0);
        printf("\n    %-13s there and back %.1e", steps[i], lost);
        CU_ASSERT(i < VARIATIONAL ? lost < 1e-13 : lost > 1e-9);
    }
}

/* On both sides of where a formula gives way to its series. */
TEST("small angles")
{
    double exp_off, dexp_off;
    series_of_attitudes(12, &exp_off, &dexp_off); /* 7/64 */
    printf("\n    small angles: exp off by %.2g eps, the inverse of d(exp) by %.2g", exp_off,
           dexp_off);
    CU_ASSERT(exp_off > 0 && exp_off < 4 && dexp_off > 0 && dexp_off < 3);
}

/* What a sum of quaternions has rounded away goes on to the next one: a turn about an axis, exact.
 */
TEST("what sums of quaternions round away")
{
    static struct fixture f;
    static const char *const names[] = {"rkmk4", "rkmk8"};
    const long double h = 1.0L / 1024;
    for (int k = 0; k < 2; k++) {
        fixture_set(&f, &free_body_system);
        f.v0[0] = 1, f.v0[1] = f.v0[2] = 0;
        f.v0[3] = 1, f.v0[4] = f.v0[5] = f.v0[6] = 0;
        fixture_start(&f, names[k], (double)h);
        long double worst = 0;
        for (int i = 1; i <= 4; i++) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1) == PK_DONE);
            const double *low = pk_state(&f.it, PK_LOW_X);
            worst = fmaxl(worst, fabsl((long double)f.it.v[3] + low[3] - cosl(h * i / 2)));
            worst = fmaxl(worst, fabsl((long double)f.it.v[4] + low[4] - sinl(h * i / 2)));
        }
        printf("\n    %s: quaternion and what it has rounded away off by %.1Le", names[k], worst);
        CU_ASSERT(worst < 1e-18L);
    }
}

TEST("unit length")
{
    double Q[8] = {0, 9, 3, 9, 0, 9, 4, 9}, low[8] = {1, 9, 1, 9, 1, 9, 1, 9};
    CU_ASSERT(pk_normalise(Q, low, 2) == 1);
    const double scaled[] = {0, 9, 0.6, 9, 0, 9, 0.8, 9}, cleared[] = {0, 9, 0, 9, 0, 9, 0, 9};
    for (int i = 0; i < 8; i++)
        CU_ASSERT(fabs(Q[i] - scaled[i]) < 1e-15 && fabs(low[i] - cleared[i]) < 1e-300);
    low[2] = 1e-17;
    CU_ASSERT(pk_normalise(Q, low, 2) == 0 && low[2] > 0);
    CU_ASSERT(pk_normalise(Q, NULL, 2) == 0);
    double none[4] = {0, 1e-200, 0, 0}, wild[4] = {1, INFINITY, 0, 0};
    CU_ASSERT(pk_normalise(none, NULL, 1) == -1 && none[1] > 0);
    CU_ASSERT(pk_normalise(wild, NULL, 1) == -1);
}
