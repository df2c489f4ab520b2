/* Constraints: residuals at round-off by every method, orders, the motion that angles give, closed
 * forms of rolling, the symplectic form; each with what fails it.
 */
#include "fixture.h"

enum { VARIATIONAL = BOUND_VARIATIONAL, FIXED = BOUND_FIXED, NAMES = BOUND_METHODS };
static const char *const *const names = bound_methods;

static const struct pk_system *const systems[] = {&rod_system,     &rods_system,  &wire_system,
                                                  &jointed_system, &swift_system, &sleigh_system,
                                                  &ball_system};
enum { SYSTEMS = 7, ROLLING = 5 };

/* Momenta that a method carries, from those of its rates, beside the largest. */
static double momenta_apart(const struct fixture *f)
{
    const struct pk_system *system = f->problem.system;
    const int own = (f->it.method->traits & PK_HOLONOMIC) != 0;
    double p[FIXTURE_N], pdot[FIXTURE_N], most = 0, worst = 0;
    (own ? system->unconstrained : system->canonical)(&f->params, f->it.t, f->it.q, f->it.v, NULL,
                                                      p, pdot);
    for (size_t i = 0; f->it.p && i < f->it.n; i++) {
        most = fmax(most, fabs(p[i]));
        worst = fmax(worst, fabs(p[i] - f->it.p[i]));
    }
    return worst / (most + 1e-30);
}

/* Beside the terms they are made of, at the end of each of some hundred steps. */
TEST("residuals")
{
    static struct fixture f;
    for (int s = 0; s < SYSTEMS; s++) {
        double position = 0, rate = 0, norm = 0;
        for (int i = 0; i < NAMES; i++) {
            fixture_set(&f, systems[s]);
            const enum pk_status status = fixture_begin(&f, names[i], i < FIXED ? 0.02 : 1e-6);
            if (s >= ROLLING && i < VARIATIONAL) {
                CU_ASSERT(status == PK_REFUSED && says(&f.it, "(rolling): use gauss"));
                continue;
            }
            CU_ASSERT_FATAL(status == PK_DONE);
            while (f.it.t < 5) {
                CU_ASSERT_FATAL(pk_integrator_step(&f.it, 5) == PK_DONE);
                const struct pk_residuals r = fixture_residuals(&f);
                position = fmax(position, r.position_relative);
                rate = fmax(rate, r.rate_relative);
                norm = fmax(norm, r.norm);
                CU_ASSERT(momenta_apart(&f) < 1e-15);
            }
            pk_integrator_free(&f.it);
        }
        printf("\n    %-8s position %.1e, rates %.1e, norm %.1e", systems[s]->name, position, rate,
               norm);
        CU_ASSERT(position < 3e-15 && (position > 0 || s >= ROLLING));
        CU_ASSERT(rate > 0 && rate < 3e-15 && norm < 2e-15);
        struct pk_system loose = *systems[s]; /* the equations alone */
        loose.constraints.n = loose.constraints.n_holonomic = 0;
        CU_ASSERT(fixture_run(&f, &loose, "rk4", 0.02, 5) == PK_DONE);
        f.problem.system = systems[s];
        const struct pk_residuals r = fixture_residuals(&f);
        CU_ASSERT(fmax(r.position_relative, r.rate_relative) > 1e-11 || s == 6);
    }
}

TEST("order on constraints and on SO(3)")
{
    static const struct {
        const struct pk_system *system;
        double t_end;
        int variational;
    } rows[] = {{&rods_system, 2, 1},      {&wire_system, 1, 1},   {&jointed_system, 0.5, 1},
                {&swift_system, 1, 1},     {&sleigh_system, 1, 0}, {&ball_system, 1, 0},
                {&free_body_system, 1, 1}, {&top_system, 0.5, 1},  {&bodies_system, 1, 1},
                {&carriage_system, 1, 1}};
    static const char *const of[] = {"lie_midpoint", "lie_midpoint4", "lie_midpoint6", "rattle",
                                     "rattle4",      "rattle6",       "rk4",           "rkmk4",
                                     "gauss2",       "lobatto3",      "radau5"};
    for (size_t s = 0; s < sizeof rows / sizeof *rows; s++)
        for (int i = rows[s].variational ? 0 : 6; i < 11; i++) {
            const struct pk_method *m = pk_method_find(of[i]);
            const double p =
                fixture_order_beside(rows[s].system, m, rows[s].t_end, 3e-12, "gauss6", 100);
            printf("\n    %-9s %-13s order %d, measured %.3f", rows[s].system->name, of[i],
                   m->order, p);
            CU_ASSERT(fabs(p - m->order) < 0.2);
        }
}

/* Particles on rods, and angles. */
TEST("the motion of the angles")
{
    static struct fixture f, g;
    static const struct {
        const char *method;
        double h, bound;
    } rows[] = {{"gauss", 1e-13, 1e-11},
                {"lie_midpoint6", 0.01, 1e-8},
                {"rattle6", 0.01, 1e-8},
                {"gauss4", 0.05, 1e-10},
                {"rattle", 0.01, 1e-1}};
    for (int i = 0; i < 5; i++) {
        fixture_set(&f, &rods_system);
        const double a[] = {f.q0[0], -f.q0[1], f.q0[2] - f.q0[0], f.q0[1] - f.q0[3]};
        const double b[] = {f.v0[0], f.v0[1], f.v0[2] - f.v0[0], f.v0[3] - f.v0[1]};
        fixture_start(&f, rows[i].method, rows[i].h);
        CU_ASSERT(pk_integrator_to(&f.it, 10) == PK_DONE);
        fixture_set(&g, &double_pendulum_system);
        g.params.g = f.params.g;
        for (int k = 0; k < 2; k++) { /* theta from the downward vertical, theta' = r x r' */
            g.q0[k] = atan2(a[2 * k], a[2 * k + 1]);
            g.v0[k] = a[2 * k] * b[2 * k + 1] + a[2 * k + 1] * b[2 * k];
        }
        fixture_start(&g, "gauss8", 0.01);
        CU_ASSERT(pk_integrator_to(&g.it, 10) == PK_DONE);
        const double x = sin(g.it.q[0]) + sin(g.it.q[1]), y = -cos(g.it.q[0]) - cos(g.it.q[1]);
        const double apart = fmax(fabs(f.it.q[2] - x), fabs(f.it.q[3] - y));
        fixture_run(&f, &jointed_system, rows[i].method, rows[i].h, 3);
        fixture_run(&g, &top_system, "gauss8", 0.01, 3);
        double turned = 0;
        for (size_t k = 0; k < 7; k++)
            turned = fmax(turned, fabs(f.it.v[3 + k] - g.it.v[k]));
        printf("\n    %-13s from the angles' %.1e, from the top about its point %.1e",
               rows[i].method, apart, turned);
        CU_ASSERT(apart > 0 && apart < rows[i].bound && (i < 4 || apart > 1e-6));
        CU_ASSERT(turned > 0 && turned < 10 * rows[i].bound && (i < 4 || turned > 1e-6));
    }
}

/* The sleigh: u = U tanh s, omega = U/r sech s, s' = a U/r^2, u along the edge, r^2 = g + a^2. The
 * ball's centre: a circle of 2/7 of the table's turns. */
TEST("rolling in closed form")
{
    static struct fixture f;
    static const char *const by[] = {"gauss", "rkmk8", "gauss4", "dop853", "rkmk4"};
    static const double h[] = {1e-13, 0.05, 0.1, 1e-12, 0.05};
    static const double bound[] = {1e-11, 1e-9, 1e-10, 1e-9, 1e-3};
    for (int i = 0; i < 5; i++) {
        const double t = 6;
        CU_ASSERT_FATAL(fixture_run(&f, &sleigh_system, by[i], h[i], t) == PK_DONE);
        const double a = f.params.limit, r = sqrt(f.params.g + a * a);
        const double U = sqrt(f.v0[0] * f.v0[0] + r * r * f.v0[2] * f.v0[2]);
        const double s = atanh(f.v0[0] / U) + a * U / (r * r) * t;
        const double u = f.it.v[0] * cos(f.it.q[2]) + f.it.v[1] * sin(f.it.q[2]);
        const double sleigh = fmax(fabs(u - U * tanh(s)), fabs(f.it.v[2] - U / r / cosh(s)));
        CU_ASSERT(U * tanh(s) > 0 && f.v0[0] < 0); /* it has turned round */
        CU_ASSERT_FATAL(fixture_run(&f, &ball_system, by[i], h[i], t) == PK_DONE);
        const double w = 2 * f.params.limit / 7, c = cos(w * t), sn = sin(w * t);
        /* r' = w e_z x (r - centre) */
        const double x0 = f.q0[0] - f.v0[1] / w, y0 = f.q0[1] + f.v0[0] / w;
        const double x = x0 + c * (f.q0[0] - x0) - sn * (f.q0[1] - y0);
        const double y = y0 + sn * (f.q0[0] - x0) + c * (f.q0[1] - y0);
        const double ball = fmax(fabs(f.it.q[0] - x), fabs(f.it.q[1] - y));
        printf("\n    %-7s sleigh off by %.1e, ball by %.1e", by[i], sleigh, ball);
        CU_ASSERT(sleigh > 0 && sleigh < bound[i] && ball > 0 && ball < bound[i]);
        CU_ASSERT(i < 4 || (sleigh > 1e-9 && ball > 1e-9));
    }
}

static double drift(const char *method, double h, long count, double *trend, double *broken)
{
    static struct fixture f;
    struct pk_drift drift;
    fixture_set(&f, &rods_system);
    f.q0[0] = 0.6, f.q0[1] = -0.8, f.q0[2] = 1.2, f.q0[3] = -1.6; /* not far from hanging down */
    memset(f.v0, 0, sizeof f.v0);
    fixture_start(&f, method, h);
    pk_drift_init(&drift);
    *broken = 0;
    for (long i = 0; i < count; i++) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
        pk_drift_update(&drift, f.it.t, fixture_energy(&f));
        if (i % 100 == 0)
            *broken = fmax(*broken, fixture_residuals(&f).position_relative);
    }
    *trend = pk_drift_slope(&drift) * f.it.t;
    return pk_drift_max(&drift);
}

TEST("energy over 2e5 steps")
{
    double trend, broken;
    for (int i = 0; i < VARIATIONAL; i++) {
        const double most = drift(names[i], 0.05, i % 3 ? 20000 : 200000, &trend, &broken);
        printf("\n    %-13s energy %.1e, of it trend %.1e, position %.1e", names[i], most, trend,
               broken);
        CU_ASSERT(most > 1e-12 && most < 2e-2 && fabs(trend) < 0.05 * most);
        CU_ASSERT(broken > 0 && broken < 3e-15);
    }
    const double rk4 = drift("rk4", 0.05, 200000, &trend, &broken);
    printf("\n    rk4 %.1e, of it trend %.1e", rk4, trend);
    CU_ASSERT(fabs(trend) > 0.5 * rk4);
}

/* Ends in (r, p) of two steps of the double pendulum as particles from its angles' start z. */
static void mapped(const char *method, const double *z, double h, double *end)
{
    static struct fixture f;
    fixture_set(&f, &rods_system);
    memset(f.q0, 0, sizeof f.q0);
    memset(f.v0, 0, sizeof f.v0);
    for (int k = 0; k < 2; k++) {
        const double s = sin(z[k]), c = cos(z[k]);
        for (int i = k; i < 2; i++) { /* the lower one is carried */
            f.q0[2 * i] += s;
            f.q0[2 * i + 1] -= c;
            f.v0[2 * i] += z[2 + k] * c;
            f.v0[2 * i + 1] += z[2 + k] * s;
        }
    }
    fixture_start(&f, method, h);
    CU_ASSERT_FATAL(pk_integrator_to(&f.it, 2 * h) == PK_DONE);
    memcpy(end, h > 0 ? f.it.q : f.q0, 4 * sizeof *end);
    memcpy(end + 4, h > 0 ? f.it.v : f.v0, 4 * sizeof *end);
}

/* dr1.dp2 - dr2.dp1 of two displacements of the angles' start, by differences of fourth order, at
 * the ends of steps of h. */
static double form(const char *method, double h)
{
    static const double z[] = {1.3, -0.9, 1.1, -0.4}, e = 2e-3;
    static const double way[2][4] = {{0.3, -0.8, 0.4, 0.6}, {-0.5, 0.2, 0.9, 0.1}};
    static const double shift[] = {-2, -1, 1, 2}, weight[] = {1, -8, 8, -1};
    double d[2][8] = {{0}}, sum = 0;
    for (int k = 0; k < 2; k++)
        for (int s = 0; s < 4; s++) {
            double x[4], end[8];
            for (int i = 0; i < 4; i++)
                x[i] = z[i] + shift[s] * e * way[k][i];
            mapped(method, x, h, end);
            for (int i = 0; i < 8; i++)
                d[k][i] += weight[s] * end[i] / (12 * e);
        }
    for (int i = 0; i < 4; i++)
        sum += d[0][i] * d[1][4 + i] - d[1][i] * d[0][4 + i];
    return sum;
}

TEST("the symplectic form on constraints")
{
    const double start = form("rattle", 1e-9); /* as good as none */
    for (int i = 0; i < 8; i++) {
        const double defect = fabs(form(names[i], 0.1) - start);
        printf("\n    %-13s form on the constraints missed by %.1e of %.2f", names[i], defect,
               start);
        CU_ASSERT(i < VARIATIONAL ? defect > 0 && defect < 2e-8 : defect > 1e-6);
    }
}

TEST("there and back on constraints")
{
    static struct fixture f;
    for (int s = 1; s < ROLLING; s++)
        for (int i = 0; i < 7; i++) {
            CU_ASSERT(fixture_run(&f, systems[s], names[i], 0.02, 1) == PK_DONE);
            CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
            const double lost = fixture_distance(&f, f.q0, f.v0);
            if (i == 0 || i == 3 || i == 6)
                printf("\n    %-8s %-13s there and back %.1e", f.it.problem.system->name, names[i],
                       lost);
            CU_ASSERT(i < VARIATIONAL ? lost < 2e-13 : lost > 1e-11);
        }
}
