/* Systems of systems.h that roll: constraints of the rates alone. */
#include "systems_bound.h"

/* Chaplygin's sleigh: a knife's edge at (x, y), the centre of its unit mass `limit` ahead of it,
 * the moment about that g. */
static const struct pk_quantity sleigh_names[] = {NAMED("x"), NAMED("y"), NAMED("theta")};
static const struct pk_quantity sleigh_constraints[] = {NAMED("lambda_edge")};
#define SIN PK_F(sin)(q[2])
#define COS PK_F(cos)(q[2])
static void sleigh_inertia(ARGS, pk_real *M)
{
    const pk_real a = LIMIT(params);
    UNUSED;
    memset(M, 0, 9 * sizeof *M);
    M[0] = M[4] = 1;
    M[2] = M[6] = -a * SIN;
    M[5] = M[7] = a * COS;
    M[8] = G(params) + a * a;
}
static void sleigh_drift(ARGS, pk_real *f)
{
    const pk_real square = LIMIT(params) * v[2] * v[2];
    UNUSED;
    f[0] = square * COS;
    f[1] = square * SIN;
    f[2] = 0;
}
static void sleigh_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    const pk_real a = LIMIT(params);
    UNUSED;
    p[0] = v[0] - a * v[2] * SIN;
    p[1] = v[1] + a * v[2] * COS;
    p[2] = (G(params) + a * a) * v[2] + a * (v[1] * COS - v[0] * SIN);
    pdot[0] = pdot[1] = 0;
    pdot[2] = -a * v[2] * (v[0] * COS + v[1] * SIN);
}
static void sleigh_rows(ARGS, pk_real *J, pk_real *residual)
{
    UNUSED;
    J[0] = -SIN;
    J[1] = COS;
    J[2] = 0;
    residual[0] = J[0] * v[0] + J[1] * v[1];
}
static void sleigh_bias(ARGS, pk_real *b)
{
    UNUSED;
    b[0] = -v[2] * (v[0] * COS + v[1] * SIN);
}
static pk_real sleigh_energy(ARGS)
{
    pk_real p[3], pdot[3];
    sleigh_unconstrained(params, t, q, v, u, p, pdot);
    return (p[0] * v[0] + p[1] * v[1] + p[2] * v[2]) / 2;
}
BOUND(sleigh, 3, 3, 0, 1, BOUND_FACTS & ~(unsigned)PK_VARIATIONAL, PK_C(0.5), PK_C(0.4), LIST(0),
      LIST(PK_C(-0.7), PK_C(0.0), PK_C(0.9)), .constraints.names = sleigh_constraints,
      .constraints.scale = sleigh_terms);

/* A solid unit sphere that rolls on a table turning at `limit`: its centre goes round at 2/7 of
 * that, wherever it starts. */
static const struct pk_quantity ball_names[] = {
    NAMED("x"),   NAMED("y"),   NAMED("omega(R).x"), NAMED("omega(R).y"), NAMED("omega(R).z"),
    NAMED("R.w"), NAMED("R.x"), NAMED("R.y"),        NAMED("R.z")};
static const struct pk_quantity ball_constraints[] = {NAMED("lambda_contact.x"),
                                                      NAMED("lambda_contact.y")};
static const pk_real ball_M[] = {PK_C(1.0), PK_C(1.0), PK_C(0.4), PK_C(0.4), PK_C(0.4)};
static void ball_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(9, ball_M, 5, M);
}
static void ball_drift(ARGS, pk_real *f)
{
    UNUSED;
    memset(f, 0, 5 * sizeof *f);
}
static void ball_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    for (int i = 0; i < 5; i++)
        p[i] = ball_M[i] * v[i];
    memcpy(p + 5, v + 5, 4 * sizeof *p);
    ball_drift(params, t, q, v, u, pdot);
    spin(v + 5, v + 2, pdot + 5);
}
static void ball_rows(ARGS, pk_real *J, pk_real *residual)
{
    pk_real turning[3];
    UNUSED;
    memset(J, 0, 18 * sizeof *J);
    J[0] = J[10] = 1;
    for (size_t k = 0; k < 3; k++) {
        pk_real axis[3] = {0, 0, 0}, column[3];
        axis[k] = 1;
        turn(v + 5, 0, axis, column);
        J[2 + k] = -column[1];
        J[9 + 2 + k] = column[0];
    }
    turn(v + 5, 0, v + 2, turning);
    residual[0] = v[0] - turning[1] + LIMIT(params) * q[1];
    residual[1] = v[1] + turning[0] - LIMIT(params) * q[0];
}
static void ball_bias(ARGS, pk_real *b)
{
    UNUSED;
    b[0] = LIMIT(params) * v[1];
    b[1] = -LIMIT(params) * v[0];
}
static pk_real ball_energy(ARGS)
{
    pk_real sum = 0;
    UNUSED;
    for (int i = 0; i < 5; i++)
        sum += ball_M[i] * v[i] * v[i] / 2;
    return sum;
}
/* With R = 1: omega_y = x' + limit y, omega_x = limit x - y'. */
BOUND(ball, 9, 2, 1, 2, BOUND_OUTSIDE | PK_AUTONOMOUS, PK_C(1.0), PK_C(1.4),
      LIST(PK_C(0.5), PK_C(0.25)),
      LIST(PK_C(0.3), PK_C(-0.2), PK_C(0.9), PK_C(0.65), PK_C(0.4), PK_C(1.0), PK_C(0.0), PK_C(0.0),
           PK_C(0.0)),
      .constraints.names = ball_constraints, .constraints.scale = ball_terms);
