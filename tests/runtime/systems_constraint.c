/* Systems of systems.h with constraints of positions, of time too, and redundant ones. */
#include "systems_bound.h"

/* A unit mass on a unit rod: the pendulum as a particle. */
static const struct pk_quantity rod_names[] = {NAMED("x"), NAMED("y")};
static const struct pk_quantity rod_constraints[] = {NAMED("lambda_rod")};
static void rod_drift(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = 0;
    f[1] = -G(params);
}
UNIT_MASSES(rod, 2)
UNIT_ROD(rod)
static pk_real rod_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1]) / 2 + G(params) * q[1];
}
BOUND(rod, 2, 2, 0, 1, BOUND_FACTS, PK_C(1.0), 0, LIST(PK_C(0.6), PK_C(-0.8)),
      LIST(PK_C(0.8), PK_C(0.6)), .constraints.n_holonomic = 1,
      .constraints.names = rod_constraints, .constraints.values = rod_constraint,
      .constraints.scale = rod_terms);

/* On a circle through 0 about (-3 limit, -4 limit): the numbers of phi are beside small x and y. */
#define circle_names rod_names
#define ACROSS (3 * LIMIT(params))
#define ALONG (4 * LIMIT(params))
#define circle_inertia rod_inertia
#define circle_drift rod_drift
#define circle_unconstrained rod_unconstrained
#define circle_bias rod_bias
#define circle_energy rod_energy
static void circle_constraint(ARGS, pk_real *phi)
{
    const pk_real x = ACROSS + q[0], y = ALONG + q[1];
    UNUSED;
    phi[0] = x * x + y * y - (ACROSS * ACROSS + ALONG * ALONG);
}
static void circle_rows(ARGS, pk_real *J, pk_real *residual)
{
    UNUSED;
    J[0] = 2 * (ACROSS + q[0]);
    J[1] = 2 * (ALONG + q[1]);
    residual[0] = J[0] * v[0] + J[1] * v[1];
}
static void circle_sizes(ARGS, pk_real *phi_size, pk_real *rate_size);
BOUND(circle, 2, 2, 0, 1, BOUND_FACTS, PK_C(1.0), PK_C(100.0), LIST(0), LIST(0),
      .constraints.n_holonomic = 1, .constraints.names = rod_constraints,
      .constraints.values = circle_constraint, .constraints.scale = circle_sizes);
static void circle_sizes(ARGS, pk_real *phi_size, pk_real *rate_size)
{
    circle_terms(params, t, q, v, u, phi_size, rate_size);
    phi_size[0] += 4 * (ACROSS * ACROSS + ALONG * ALONG);
}

/* The same, said twice over. */
#define twice_names rod_names
static const struct pk_quantity twice_constraints[] = {NAMED("lambda_rod"), NAMED("lambda_again")};
#define twice_inertia rod_inertia
#define twice_drift rod_drift
#define twice_unconstrained rod_unconstrained
#define twice_energy rod_energy
static void twice_constraint(ARGS, pk_real *phi)
{
    rod_constraint(params, t, q, v, u, phi);
    phi[1] = 3 * phi[0] + LIMIT(params);
}
static void twice_rows(ARGS, pk_real *J, pk_real *residual)
{
    rod_rows(params, t, q, v, u, J, residual);
    J[2] = 3 * J[0];
    J[3] = 3 * J[1];
    residual[1] = 3 * residual[0];
}
static void twice_bias(ARGS, pk_real *b)
{
    rod_bias(params, t, q, v, u, b);
    b[1] = 3 * b[0];
}
BOUND(twice, 2, 2, 0, 2, BOUND_FACTS, PK_C(1.0), 0, LIST(PK_C(0.6), PK_C(-0.8)),
      LIST(PK_C(0.8), PK_C(0.6)), .constraints.n_holonomic = 2,
      .constraints.names = twice_constraints, .constraints.values = twice_constraint,
      .constraints.scale = twice_terms);

/* Two unit masses on unit rods: double_pendulum as particles. */
static const struct pk_quantity rods_names[] = {NAMED("x1"), NAMED("y1"), NAMED("x2"), NAMED("y2")};
static const struct pk_quantity rods_constraints[] = {NAMED("lambda_upper"), NAMED("lambda_lower")};
static void rods_drift(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = f[2] = 0;
    f[1] = f[3] = -G(params);
}
UNIT_MASSES(rods, 4)
static void rods_constraint(ARGS, pk_real *phi)
{
    const pk_real x = q[2] - q[0], y = q[3] - q[1];
    UNUSED;
    phi[0] = q[0] * q[0] + q[1] * q[1] - 1;
    phi[1] = x * x + y * y - 1;
}
static void rods_rows(ARGS, pk_real *J, pk_real *residual)
{
    const pk_real x = q[2] - q[0], y = q[3] - q[1];
    UNUSED;
    J[0] = 2 * q[0], J[1] = 2 * q[1], J[2] = J[3] = 0;
    J[4] = -2 * x, J[5] = -2 * y, J[6] = 2 * x, J[7] = 2 * y;
    residual[0] = J[0] * v[0] + J[1] * v[1];
    residual[1] = 2 * (x * (v[2] - v[0]) + y * (v[3] - v[1]));
}
static void rods_bias(ARGS, pk_real *b)
{
    const pk_real x = v[2] - v[0], y = v[3] - v[1];
    UNUSED;
    b[0] = 2 * (v[0] * v[0] + v[1] * v[1]);
    b[1] = 2 * (x * x + y * y);
}
static pk_real rods_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]) / 2 + G(params) * (q[1] + q[3]);
}
BOUND(rods, 4, 4, 0, 2, BOUND_FACTS, PK_C(1.0), 0,
      LIST(PK_C(0.6), PK_C(-0.8), PK_C(1.4), PK_C(-0.2)),
      LIST(PK_C(0.4), PK_C(0.3), PK_C(0.22), PK_C(0.54)), .constraints.n_holonomic = 2,
      .constraints.names = rods_constraints, .constraints.values = rods_constraint,
      .constraints.scale = rods_terms);

/* A bead on a wire through the origin that turns by A(t) = t + .3 sin 2t, V = g r^2/2 + x^4/4. */
#define wire_names rod_names
static const struct pk_quantity wire_constraints[] = {NAMED("lambda_wire")};
#define ANGLE (t + PK_C(0.3) * PK_F(sin)(2 * t))
#define ANGLE_1 (1 + PK_C(0.6) * PK_F(cos)(2 * t))
#define ANGLE_2 (-PK_C(1.2) * PK_F(sin)(2 * t))
static void wire_drift(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = -G(params) * q[0] - q[0] * q[0] * q[0];
    f[1] = -G(params) * q[1];
}
UNIT_MASSES(wire, 2)
static void wire_constraint(ARGS, pk_real *phi)
{
    UNUSED;
    phi[0] = q[0] * PK_F(sin)(ANGLE) - q[1] * PK_F(cos)(ANGLE);
}
static void wire_rows(ARGS, pk_real *J, pk_real *residual)
{
    const pk_real s = PK_F(sin)(ANGLE), c = PK_F(cos)(ANGLE);
    UNUSED;
    J[0] = s;
    J[1] = -c;
    residual[0] = s * v[0] - c * v[1] + ANGLE_1 * (q[0] * c + q[1] * s);
}
static void wire_bias(ARGS, pk_real *b)
{
    const pk_real s = PK_F(sin)(ANGLE), c = PK_F(cos)(ANGLE), w = ANGLE_1;
    UNUSED;
    b[0] = 2 * w * (v[0] * c + v[1] * s) + ANGLE_2 * (q[0] * c + q[1] * s) +
           w * w * (q[1] * c - q[0] * s);
}
static pk_real wire_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1] + G(params) * (q[0] * q[0] + q[1] * q[1])) / 2 +
           q[0] * q[0] * q[0] * q[0] / 4;
}
BOUND(wire, 2, 2, 0, 1, BOUND_OUTSIDE | PK_VARIATIONAL, PK_C(2.0), 0, LIST(PK_C(0.8), PK_C(0.0)),
      LIST(PK_C(0.1), PK_C(1.28)), .constraints.n_holonomic = 1,
      .constraints.names = wire_constraints, .constraints.values = wire_constraint,
      .constraints.scale = wire_terms);

/* The top of systems_rotation.c as a body free in space whose point r = -e_z is held: unit mass,
 * I = (1/2, 1/2, 1/2) about its centre. */
static const struct pk_quantity jointed_names[] = {
    NAMED("x"),          NAMED("y"),   NAMED("z"),   NAMED("omega(R).x"), NAMED("omega(R).y"),
    NAMED("omega(R).z"), NAMED("R.w"), NAMED("R.x"), NAMED("R.y"),        NAMED("R.z")};
static const struct pk_quantity jointed_constraints[] = {
    NAMED("lambda_joint.x"), NAMED("lambda_joint.y"), NAMED("lambda_joint.z")};
static const pk_real jointed_M[] = {PK_C(1.0), PK_C(1.0), PK_C(1.0),
                                    PK_C(0.5), PK_C(0.5), PK_C(0.5)};
static const pk_real jointed_r[] = {PK_C(0.0), PK_C(0.0), PK_C(-1.0)};
static void jointed_inertia(ARGS, pk_real *M)
{
    UNUSED;
    constant_inertia(10, jointed_M, 6, M);
}
static void jointed_drift(ARGS, pk_real *f)
{
    UNUSED;
    memset(f, 0, 6 * sizeof *f); /* p x omega = 0 */
    f[2] = -G(params);
}
static void jointed_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    for (int i = 0; i < 6; i++)
        p[i] = jointed_M[i] * v[i];
    memcpy(p + 6, v + 6, 4 * sizeof *p);
    jointed_drift(params, t, q, v, u, pdot);
    spin(v + 6, v + 3, pdot + 6);
}
static void jointed_constraint(ARGS, pk_real *phi)
{
    UNUSED;
    turn(v + 6, 0, jointed_r, phi);
    for (int i = 0; i < 3; i++)
        phi[i] += q[i];
}
static void jointed_rows(ARGS, pk_real *J, pk_real *residual)
{
    UNUSED;
    memset(J, 0, 30 * sizeof *J);
    for (size_t k = 0; k < 3; k++) {
        pk_real axis[3] = {0, 0, 0}, arm[3], column[3];
        axis[k] = 1;
        cross(axis, jointed_r, arm);
        turn(v + 6, 0, arm, column);
        for (size_t i = 0; i < 3; i++)
            J[i * 10 + 3 + k] = column[i];
        J[k * 10 + k] = 1;
    }
    for (size_t i = 0; i < 3; i++) {
        residual[i] = 0;
        for (size_t k = 0; k < 6; k++)
            residual[i] += J[i * 10 + k] * v[k];
    }
}
static void jointed_bias(ARGS, pk_real *b)
{
    pk_real one[3], two[3];
    UNUSED;
    cross(v + 3, jointed_r, one);
    cross(v + 3, one, two);
    turn(v + 6, 0, two, b);
}
static pk_real jointed_energy(ARGS)
{
    pk_real sum = G(params) * q[2];
    UNUSED;
    for (int i = 0; i < 6; i++)
        sum += jointed_M[i] * v[i] * v[i] / 2;
    return sum;
}
/* r = R e_z and r' = R (omega x e_z) at the start of `top`, turned by 2 atan(3/4) about x. */
BOUND(jointed, 10, 3, 1, 3, BOUND_FACTS, PK_C(2.0), 0, LIST(PK_C(0.0), PK_C(-0.96), PK_C(0.28)),
      LIST(PK_C(-0.2), PK_C(-0.084), PK_C(-0.288), PK_C(0.3), PK_C(-0.2), PK_C(5.0), PK_C(0.8),
           PK_C(0.6), PK_C(0.0), PK_C(0.0)),
      .constraints.n_holonomic = 3, .constraints.names = jointed_constraints,
      .constraints.values = jointed_constraint, .constraints.scale = jointed_terms);
