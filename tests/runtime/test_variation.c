/* Variational equations against differences of the steps themselves, for every method; what they
 * say of the symplectic form against closed forms; each with a method that fails it.
 */
#include "../../runtime/run/diagnose/motion.h"
#include "fixture.h"

enum { DOUBLES = 1 << 15 };
static double block[DOUBLES];
static struct memory memory;

static struct pk_options one_step(const struct pk_method *method, double h)
{
    struct pk_options options = pk_options_default();
    options.h = h;
    if (method->traits & PK_ADAPTIVE) {
        options.h_max = h;
        options.rtol = options.atol = 1e10;
        options.newton_tol = 1e-15;
    }
    return options;
}

static struct motion motion_from(const struct pk_problem *problem, const struct pk_method *method,
                                 struct pk_options options, const double *q, const double *v)
{
    return (struct motion){.problem = problem,
                           .method = method,
                           .options = options,
                           .q = q,
                           .v = v,
                           .memory = &memory};
}

/* x = (q, v) after two steps. */
static void map(const struct pk_problem *problem, const struct pk_method *method, double h,
                const double *from, double *to)
{
    const size_t n = problem->system->n, n_q = n - problem->system->n_first_order;
    const struct pk_options options = one_step(method, h);
    struct pk_integrator it;
    CU_ASSERT_FATAL(pk_integrator_init(&it, problem, method, &options, 0, from, from + n_q, block,
                                       sizeof block) == PK_DONE);
    CU_ASSERT_FATAL(pk_integrator_to(&it, 2 * h) == PK_DONE);
    memcpy(to, it.q, n_q * sizeof *to);
    memcpy(to + n_q, it.v, n * sizeof *to);
}

/* Number i of (q, v) of displacement j. */
static double *displaced(const struct variation *w, size_t j, size_t i)
{
    return i < w->n_q ? w->Q + (1 + j) * w->n_q + i : w->V + variation_place(w, 1 + j, i - w->n_q);
}

/* max over columns of |displacement - difference of fourth order|, and the largest displacement. */
static double missed(const struct pk_system *system, const struct pk_method *method, double h,
                     double *size)
{
    static struct variation variation;
    const size_t n = system->n, n_q = n - system->n_first_order, m = n_q + n;
    const double e = 2e-3;
    struct test_params params;
    double x[4], q[2], v[2], worst = 0;
    system->defaults(&params);
    system->start(&params, q, v);
    memcpy(x, q, n_q * sizeof *x);
    memcpy(x + n_q, v, n * sizeof *x);
    const struct pk_problem problem = {.system = system, .params = &params};
    const struct motion motion = motion_from(&problem, method, one_step(method, h), q, v);
    CU_ASSERT_FATAL(variation_init(&variation, &motion, m) == PK_DONE);
    CU_ASSERT(variation.system.n == n * (1 + m));
    for (size_t j = 0; j < m; j++)
        *displaced(&variation, j, j) = 1;
    struct pk_integrator *it = &variation.motion.it;
    CU_ASSERT_FATAL(motion_begin(&variation.motion) == PK_DONE);
    CU_ASSERT_FATAL(pk_integrator_to(it, 2 * h) == PK_DONE);
    /* radau halves a step where its iteration, without second derivatives, is slow. */
    CU_ASSERT(it->count.steps == 2 || strcmp(method->name, "radau") == 0);
    memcpy(variation.Q, it->q, (1 + m) * n_q * sizeof *it->q);
    memcpy(variation.V, it->v, (1 + m) * n * sizeof *it->v);
    for (size_t j = 0; j < m; j++) {
        static const double at[] = {-2, -1, 1, 2}, w[] = {1, -8, 8, -1};
        double sum[4] = {0};
        for (int k = 0; k < 4; k++) {
            double from[4], to[4];
            memcpy(from, x, m * sizeof *from);
            from[j] += at[k] * e;
            map(&problem, method, h, from, to);
            for (size_t i = 0; i < m; i++)
                sum[i] += w[k] * to[i] / (12 * e);
        }
        for (size_t i = 0; i < m; i++) {
            const double d = *displaced(&variation, j, i);
            worst = fmax(worst, fabs(d - sum[i]));
            *size = fmax(*size, fabs(d - (i == j ? 1 : 0)));
        }
    }
    pk_integrator_free(it);
    memory_end(&memory);
    return worst;
}

/* Steps whose length depends on the state are not maps of one length: no derivative is asked. */
static int follows_the_motion(const struct pk_method *method)
{
    return strcmp(method->name, "adaptive_verlet") == 0;
}

/* As if nothing depended on q and v. */
static void straight_on(ARGS, const double *a, double *r_q, double *r_v, double *r_t)
{
    (void)params, (void)t, (void)q, (void)v, (void)u, (void)a;
    memset(r_q, 0, 4 * sizeof *r_q);
    memset(r_v, 0, 4 * sizeof *r_v);
    memset(r_t, 0, 2 * sizeof *r_t);
}

TEST("the derivative of every method's step")
{
    struct pk_system systems[] = {double_pendulum_system, relativistic_system, pendulum_system,
                                  maxwell_system, brusselator_system};
    double worst = 0;
    for (size_t i = 0; pk_method_at(i); i++)
        for (int k = 0; k < 5; k++) {
            const struct pk_method *method = pk_method_at(i);
            double size = 0;
            if (method->needs & (~systems[k].facts | PK_FAST) || follows_the_motion(method))
                continue;
            const double d = missed(&systems[k], method, 0.05, &size);
            CU_ASSERT(d > 0 && d < 3e-9 && size > 0.02);
            if (!(d < 3e-9))
                printf("\n    %s, %s: %.1e of %.1e", method->name, systems[k].name, d, size);
            worst = fmax(worst, d);
        }
    printf("\n    displacements against differences of the steps: %.1e", worst);
    systems[0].linear = straight_on;
    double size = 0;
    CU_ASSERT(missed(&systems[0], pk_method_find("rk4"), 0.05, &size) > 1e-3);
}

static enum pk_status form_of(struct stepmap *found, const struct pk_problem *problem,
                              const char *name, double h, const double *q, const double *v)
{
    const struct motion m = motion_from(problem, pk_method_find(name), pk_options_default(), q, v);
    enum pk_status status = stepmap_begin(found, &m);
    if (status == PK_DONE)
        status = stepmap_find(found, h, 0, q, v);
    pk_integrator_free(&found->variation.motion.it);
    memory_end(&memory);
    return status;
}

static double defect(const struct pk_system *system, const char *name, double h,
                     struct stepmap *found)
{
    struct test_params params;
    double q[2], v[2];
    system->defaults(&params);
    system->start(&params, q, v);
    const struct pk_problem problem = {.system = system, .params = &params};
    CU_ASSERT_FATAL(form_of(found, &problem, name, h, q, v) == PK_DONE);
    return found->defect;
}

TEST("the symplectic form")
{
    struct stepmap m;
    /* One degree of freedom: S^T J S = det S J. RK4: |R|^2 = 1 - y^6/72 + y^8/576 (REGIMES L10). */
    for (double y = 0.05; y < 3; y *= 2.385) {
        const double exact = -pow(y, 6) / 72 + pow(y, 8) / 576;
        CU_ASSERT(fabs(defect(&oscillator_system, "rk4", y, &m) - fabs(exact)) <= m.rounding);
        CU_ASSERT(fabs(m.volume - exact) <= m.rounding && m.rounding < 1e-12 * (1 + pow(y, 8)));
        CU_ASSERT(fabs(defect(&oscillator_system, "euler", y, &m) - y * y) <= m.rounding);
    }
    /* Symplectic methods: rounding alone, be M what it will. */
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *method = pk_method_at(i);
        const struct pk_system *const systems[] = {&double_pendulum_system, &relativistic_system,
                                                   &oscillator_system};
        for (int k = 0; k < 3; k++)
            if (method->traits & PK_SYMPLECTIC &&
                !(method->needs & (~systems[k]->facts | PK_FAST))) {
                CU_ASSERT(defect(systems[k], method->name, 0.2, &m) <= m.rounding);
                CU_ASSERT(m.rounding < 3e-12 && fabs(m.volume) <= m.rounding);
            }
    }
    const double eight = defect(&double_pendulum_system, "gauss8", 0.3, &m);
    const double adaptive = defect(&double_pendulum_system, "gauss", 0.5, &m);
    const double rk4 = defect(&double_pendulum_system, "rk4", 0.2, &m);
    printf("\n    defect of a step of the double pendulum: gauss8 %.1e; gauss, in (q, q'), %.1e; "
           "rk4 %.1e",
           eight, adaptive, rk4);
    CU_ASSERT(eight > 0 && adaptive > 1e-3 && adaptive < 1e-2 && rk4 > 1e-3);
    /* And free of units: q'' = -w^2 q is the oscillator in another unit of time. */
    struct test_params params = {.g = 1};
    double q[] = {0.7}, v[] = {0.2};
    const struct pk_problem problem = {.system = &oscillator_system, .params = &params};
    params.g = 2.385 * 2.385;
    CU_ASSERT(form_of(&m, &problem, "rk4", 0.5 / 2.385, q, v) == PK_DONE);
    CU_ASSERT(fabs(m.defect - (pow(0.5, 6) / 72 - pow(0.5, 8) / 576)) <= m.rounding);
}

TEST("refusals")
{
    struct stepmap m;
    struct test_params params = {.g = 1};
    double q[] = {0.7}, v[] = {0.2};
    struct pk_system oscillator = oscillator_system;
    struct pk_problem problem = {.system = &oscillator, .params = &params};
    oscillator.linear = NULL;
    CU_ASSERT(form_of(&m, &problem, "rk4", 0.1, q, v) == PK_REFUSED);
    oscillator.linear = oscillator_system.linear;
    CU_ASSERT(form_of(&m, &problem, "adaptive_verlet", 0.1, q, v) == PK_REFUSED);
    CU_ASSERT(form_of(&m, &problem, "rk4", 0.1, q, v) == PK_DONE);
}
