/* Systems of systems.h with rotations and no constraints. */
#include "systems_bound.h"

#define OMEGA(k) {"omega(" k ").x", "", ""}, {"omega(" k ").y", "", ""}, {"omega(" k ").z", "", ""}
#define QUATERNION(k) {k ".w", "", ""}, {k ".x", "", ""}, {k ".y", "", ""}, {k ".z", "", ""}

static const pk_real up[] = {PK_C(0.0), PK_C(0.0), PK_C(1.0)};

/* Of one body: M, its momenta, and f or pdot from what of L depends on its attitude. */
static void inertia_of(size_t n, const pk_real *I, size_t at, pk_real *M)
{
    for (size_t i = 0; i < 3; i++)
        M[(at + i) * n + at + i] = I[i];
}
static void momenta_of(const pk_real *I, const pk_real *omega, pk_real *p)
{
    for (int i = 0; i < 3; i++)
        p[i] = I[i] * omega[i];
}
static void torque_of(const pk_real *I, const pk_real *omega, const pk_real *added, pk_real *f)
{
    pk_real p[3];
    momenta_of(I, omega, p);
    cross(p, omega, f);
    for (int i = 0; i < 3; i++)
        f[i] += added ? added[i] : 0;
}
/* A body free to turn, I = (1, 2, 3). */
static const pk_real free_I[] = {PK_C(1.0), PK_C(2.0), PK_C(3.0)};
static const struct pk_quantity free_body_names[] = {OMEGA("R"), QUATERNION("R")};
#define free_body_rows NULL
#define free_body_bias NULL
static void free_body_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(7, free_I, 3, M);
}
static void free_body_drift(ARGS, pk_real *f)
{
    UNUSED;
    torque_of(free_I, v, NULL, f);
}
static void free_body_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    UNUSED;
    momenta_of(free_I, v, p);
    memcpy(p + 3, v + 3, 4 * sizeof *p);
    torque_of(free_I, v, NULL, pdot);
    spin(v + 3, v, pdot + 3);
}
static pk_real free_body_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + 2 * v[1] * v[1] + 3 * v[2] * v[2]) / 2;
}
BOUND(free_body, 7, 0, 1, 0, BOUND_FACTS, PK_C(1.0), 0, LIST(0),
      LIST(PK_C(0.4), PK_C(1.1), PK_C(-0.3), PK_C(0.5), PK_C(0.5), PK_C(-0.5), PK_C(0.5)), );

/* The same and a state that nothing reads, z' = omega.x^2 + w cos t. */
static const struct pk_quantity metered_names[] = {OMEGA("R"), QUATERNION("R"), {"z", "", ""}};
#define metered_rows NULL
#define metered_bias NULL
static void metered_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(8, free_I, 3, M);
}
static void metered_drift(ARGS, pk_real *f)
{
    free_body_drift(params, t, q, v, u, f);
    f[7] = v[0] * v[0] + v[3] * PK_F(cos)(t);
}
static void metered_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    free_body_unconstrained(params, t, q, v, u, p, pdot);
    p[7] = v[7];
    pdot[7] = v[0] * v[0] + v[3] * PK_F(cos)(t);
}
static pk_real metered_energy(ARGS) { return free_body_energy(params, t, q, v, u); }
BOUND(metered, 8, 0, 1, 0, BOUND_FACTS & ~(unsigned)PK_AUTONOMOUS, PK_C(1.0), 0, LIST(0),
      LIST(PK_C(0.4), PK_C(1.1), PK_C(-0.3), PK_C(0.5), PK_C(0.5), PK_C(-0.5), PK_C(0.5)), );

/* A heavy symmetric top about its fixed point, I = (3/2, 3/2, 1/2), V = g cos(theta). */
static const pk_real top_I[] = {PK_C(1.5), PK_C(1.5), PK_C(0.5)};
static const struct pk_quantity top_names[] = {OMEGA("R"), QUATERNION("R")};
#define top_rows NULL
#define top_bias NULL
static void top_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(7, top_I, 3, M);
}
static void top_drift(ARGS, pk_real *f)
{
    pk_real k[3], added[3];
    UNUSED;
    turn(v + 3, 1, up, k);
    cross(k, up, added);
    for (int i = 0; i < 3; i++)
        added[i] *= G(params);
    torque_of(top_I, v, added, f);
}
static void top_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    momenta_of(top_I, v, p);
    memcpy(p + 3, v + 3, 4 * sizeof *p);
    top_drift(params, t, q, v, u, pdot);
    spin(v + 3, v, pdot + 3);
}
static pk_real top_energy(ARGS)
{
    pk_real k[3];
    UNUSED;
    turn(v + 3, 1, up, k);
    return (3 * (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]) / 4 + G(params) * k[2];
}
BOUND(top, 7, 0, 1, 0, BOUND_FACTS, PK_C(2.0), 0, LIST(0),
      LIST(PK_C(0.3), PK_C(-0.2), PK_C(5.0), PK_C(0.8), PK_C(0.6), PK_C(0.0), PK_C(0.0)), );

/* Two bodies in free space, V = g (R1 e1).(R2 e3). */
static const pk_real second_I[] = {PK_C(1.5), PK_C(1.0), PK_C(2.2)};
static const pk_real first_axis[] = {PK_C(1.0), PK_C(0.0), PK_C(0.0)};
static const struct pk_quantity bodies_names[] = {OMEGA("A"), OMEGA("B"), QUATERNION("A"),
                                                  QUATERNION("B")};
#define bodies_rows NULL
#define bodies_bias NULL
static void bodies_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(14, free_I, 3, M);
    inertia_of(14, second_I, 3, M);
}
static void bodies_drift(ARGS, pk_real *f)
{
    pk_real a[3], b[3], seen[3], added[3];
    UNUSED;
    turn(v + 6, 0, first_axis, a);
    turn(v + 10, 0, up, b);
    turn(v + 6, 1, b, seen);
    cross(first_axis, seen, added);
    for (int i = 0; i < 3; i++)
        added[i] *= -G(params);
    torque_of(free_I, v, added, f);
    turn(v + 10, 1, a, seen);
    cross(up, seen, added);
    for (int i = 0; i < 3; i++)
        added[i] *= -G(params);
    torque_of(second_I, v + 3, added, f + 3);
}
static void bodies_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    momenta_of(free_I, v, p);
    momenta_of(second_I, v + 3, p + 3);
    memcpy(p + 6, v + 6, 8 * sizeof *p);
    bodies_drift(params, t, q, v, u, pdot);
    spin(v + 6, v, pdot + 6);
    spin(v + 10, v + 3, pdot + 10);
}
static pk_real bodies_energy(ARGS)
{
    pk_real a[3], b[3], sum = 0;
    UNUSED;
    turn(v + 6, 0, first_axis, a);
    turn(v + 10, 0, up, b);
    for (int i = 0; i < 3; i++)
        sum += (free_I[i] * v[i] * v[i] + second_I[i] * v[3 + i] * v[3 + i]) / 2;
    return sum + G(params) * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}
BOUND(bodies, 14, 0, 2, 0, BOUND_FACTS, PK_C(1.3), 0, LIST(0),
      LIST(PK_C(0.4), PK_C(0.9), PK_C(-0.3), PK_C(-0.2), PK_C(0.5), PK_C(0.7), PK_C(0.5), PK_C(0.5),
           PK_C(-0.5), PK_C(0.5), PK_C(0.6), PK_C(0.0), PK_C(0.8), PK_C(0.0)), );

/* A body that turns about a point r off its centre, which a spring g holds on the x axis:
 *
 *     T = m/2 x'^2 + m x' k.(omega x r) + omega.I omega/2,  k = R^T e_x,
 *     V = g x^2/2 + b e_x.R^T e_z,
 *
 * so M depends on R; with drag on both and forces of time, in the body frame. */
static const pk_real carriage_r[] = {PK_C(0.3), PK_C(0.2), PK_C(-0.1)};
static const pk_real carriage_m = PK_C(1.5), carriage_b = PK_C(0.7);
static const struct pk_quantity carriage_names[] = {{"x", "", ""}, OMEGA("R"), QUATERNION("R")};
#define carriage_rows NULL
#define carriage_bias NULL
/* k, r x k */
static void carriage_arm(const pk_real *v, pk_real *k, pk_real *arm)
{
    turn(v + 4, 1, first_axis, k);
    cross(carriage_r, k, arm);
}
static void carriage_inertia(ARGS, pk_real *M)
{
    pk_real k[3], arm[3];
    UNUSED;
    carriage_arm(v, k, arm);
    constant_inertia(8, &carriage_m, 1, M);
    inertia_of(8, free_I, 1, M);
    for (size_t i = 0; i < 3; i++)
        M[1 + i] = M[(1 + i) * 8] = carriage_m * arm[i];
}
static void carriage_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    pk_real k[3], arm[3], w[3], z[3], of_T[3], of_V[3], gyro[3];
    UNUSED;
    carriage_arm(v, k, arm);
    cross(v + 1, carriage_r, w);
    turn(v + 4, 1, up, z);
    p[0] = carriage_m * (v[0] + (k[0] * w[0] + k[1] * w[1] + k[2] * w[2]));
    for (int i = 0; i < 3; i++)
        p[1 + i] = free_I[i] * v[1 + i] + carriage_m * v[0] * arm[i];
    memcpy(p + 4, v + 4, 4 * sizeof *p);
    pdot[0] = -G(params) * q[0] - PK_C(0.2) * v[0] + PK_C(0.3) * PK_F(sin)(2 * t);
    cross(w, k, of_T);
    cross(first_axis, z, of_V);
    cross(p + 1, v + 1, gyro);
    for (int i = 0; i < 3; i++)
        pdot[1 + i] = carriage_m * v[0] * of_T[i] - carriage_b * of_V[i] + gyro[i] -
                      PK_C(0.1) * v[1 + i] + (i == 1 ? PK_C(0.2) * PK_F(cos)(t) : 0);
    spin(v + 4, v + 1, pdot + 4);
}
static void carriage_drift(ARGS, pk_real *f)
{
    pk_real p[8], pdot[8], k[3], arm[3], w[3], turned[3], moved[3];
    carriage_unconstrained(params, t, q, v, u, p, pdot);
    carriage_arm(v, k, arm);
    cross(v + 1, carriage_r, w);
    cross(k, v + 1, turned); /* k' */
    cross(carriage_r, turned, moved);
    f[0] = pdot[0] - carriage_m * (turned[0] * w[0] + turned[1] * w[1] + turned[2] * w[2]);
    for (int i = 0; i < 3; i++)
        f[1 + i] = pdot[1 + i] - carriage_m * v[0] * moved[i];
}
static pk_real carriage_energy(ARGS)
{
    pk_real p[8], pdot[8], z[3];
    carriage_unconstrained(params, t, q, v, u, p, pdot);
    turn(v + 4, 1, up, z);
    return (p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3] + G(params) * q[0] * q[0]) / 2 +
           carriage_b * z[0];
}
BOUND(carriage, 8, 1, 1, 0, BOUND_OUTSIDE, PK_C(2.5), 0, LIST(PK_C(0.4)),
      LIST(PK_C(0.3), PK_C(0.4), PK_C(1.1), PK_C(-0.3), PK_C(0.5), PK_C(0.5), PK_C(-0.5),
           PK_C(0.5)), );
