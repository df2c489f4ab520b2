/* Each kernel of a system fails, or writes what is no number, at its k-th call, once or from there
 * on, for each method: there is a status with a reason that names what is there, the state stays
 * finite, and who goes on after a failure that has passed gets to where it leads without.
 */
#include "fixture.h"

#include <pk/step/state.h>

#ifndef DEEP /* calls up to which one fails; make asan: more, of more systems */
#define DEEP 1
#endif

enum { SIZE = 1 << 15, MOST = 16 };

enum kernel {
    ACCELERATION,
    MASS,
    CANONICAL,
    JACOBIAN,
    LINEAR,
    SINGULARITY,
    EVENT,
    CONSTRAINT,
    ROWS,
    TERMS,
    UNCONSTRAINED,
    INERTIA,
    MARKING,
    PREPARE,
    LANES,
    KERNELS
};

static struct {
    const struct pk_system *of;
    enum kernel which;
    int as_number; /* fails by what it writes: 1 NaN, 2 infinity, 3 zero; 0: by what it returns */
    int for_ever;
    long at, calls;
} fault;

static int now(enum kernel which)
{
    if (which != fault.which)
        return 0;
    fault.calls++;
    return fault.for_ever ? fault.calls >= fault.at : fault.calls == fault.at;
}

static void spoil(enum kernel which, pk_real *out, size_t count)
{
    static const pk_real with[] = {0, (pk_real)NAN, (pk_real)INFINITY, 0};
    if (now(which))
        for (size_t i = 0; i < count; i++)
            out[i] = with[fault.as_number];
}

#define WITH params, t, q, v, u

/* Of pivot k of M, or of the constraints behind its n. */
static int some_failure(size_t k, size_t n)
{
    return k < n ? PK_FAILED(PK_FAILURE_MASS, k) : PK_FAILED(PK_FAILURE_CONSTRAINT, k - n);
}
static int acceleration(ARGS, pk_real *a)
{
    const size_t n = fault.of->n;
    const int failed = fault.of->acceleration(WITH, a);
    if (fault.which != ACCELERATION || fault.as_number) {
        if (fault.which == ACCELERATION)
            spoil(ACCELERATION, a, n);
        return failed;
    }
    return now(ACCELERATION) ? some_failure((size_t)fault.calls % (n + fault.of->constraints.n), n)
                             : failed;
}
static unsigned long long lanes(const void *p, const pk_real *t, const pk_real *q, const pk_real *v,
                                const pk_real *u, pk_real *a)
{
    const unsigned long long failed = fault.of->lanes(p, t, q, v, u, a);
    return now(LANES) ? failed | 5 : failed;
}
static void mass(ARGS, pk_real *M)
{
    fault.of->mass(WITH, M);
    spoil(MASS, M, fault.of->n * fault.of->n);
}
static void canonical(ARGS, pk_real *x, pk_real *y)
{
    fault.of->canonical(WITH, x, y);
    spoil(CANONICAL, fault.at % 2 ? x : y, fault.of->n);
}
static void unconstrained(ARGS, pk_real *x, pk_real *y)
{
    fault.of->unconstrained(WITH, x, y);
    spoil(UNCONSTRAINED, fault.at % 2 ? x : y, fault.of->n);
}
static void jacobian(ARGS, pk_real *a, pk_real *b, pk_real *c)
{
    fault.of->jacobian(WITH, a, b, c);
    spoil(JACOBIAN, b, fault.of->n * fault.of->n);
}
static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    fault.of->linear(WITH, a, r_q, r_v, r_t);
    spoil(LINEAR, r_q, fault.of->n * fault.of->n);
}
static void one_singularity(ARGS, pk_real *out)
{
    UNUSED;
    out[0] = 100 + q[0];
    spoil(SINGULARITY, out, 1);
}
static void one_event(ARGS, pk_real *out)
{
    UNUSED;
    out[0] = q[0] - 0.69;
    spoil(EVENT, out, 1);
}
static void constraint(ARGS, pk_real *phi)
{
    fault.of->constraints.values(WITH, phi);
    spoil(CONSTRAINT, phi, fault.of->constraints.n_holonomic);
}
static void rows(ARGS, pk_real *J, pk_real *residual)
{
    fault.of->constraints.jacobian(WITH, J, residual);
    spoil(ROWS, fault.at % 2 ? J : residual, fault.of->constraints.n);
}
static void terms(ARGS, pk_real *x, pk_real *y)
{
    fault.of->constraints.scale(WITH, x, y);
    spoil(TERMS, y, fault.of->constraints.n);
}
static void inertia(ARGS, pk_real *M)
{
    fault.of->inertia(WITH, M);
    spoil(INERTIA, M, fault.of->n * fault.of->n);
}
static void marking(ARGS, pk_real *out)
{
    fault.of->marks.values(WITH, out);
    spoil(MARKING, out, fault.of->marks.n);
}
static int prepare(void *p)
{
    const int outside = fault.of->prepare(p);
    return now(PREPARE) ? PK_FAILED(PK_FAILURE_DERIVED, 0) : outside;
}

static struct pk_system faulty(void)
{
    static const struct pk_singularity singularity[] = {
        {{"100 + x", "", ""}, PK_SINGULARITY_DIVISOR}};
    static const struct pk_event event[] = {{{"low", "", ""}, 0, 0}};
    const struct pk_system *of = fault.of;
    struct pk_system s = *of;
#define WRAP_AS(field, kernel) s.field = s.field ? kernel : NULL
#define WRAP(kernel) WRAP_AS(kernel, kernel)
    WRAP(acceleration), WRAP(lanes), WRAP(mass), WRAP(canonical), WRAP(unconstrained),
        WRAP(jacobian);
    WRAP(linear), WRAP_AS(constraints.values, constraint), WRAP_AS(constraints.jacobian, rows),
        WRAP_AS(constraints.scale, terms), WRAP(inertia);
    WRAP_AS(marks.values, marking), WRAP(prepare);
    s.steppers = NULL, s.block_steppers = NULL;
    s.singularities.n = 1, s.singularities.table = singularity,
    s.singularities.values = one_singularity;
    s.events.n = 1, s.events.table = event, s.events.values = one_event;
    return s;
}

/* What is said of the status, whole and cut short. */
static int told(const struct pk_integrator *it)
{
    char text[512], cut[8];
    const int length = pk_integrator_reason(it, text, sizeof text);
    return length > 3 && strlen(text) > 3 && !strstr(text, "(null)") &&
           pk_integrator_reason(it, cut, sizeof cut) == length && strncmp(cut, text, 7) == 0 &&
           pk_integrator_reason(it, NULL, 0) == length;
}

static double room[2 * SIZE];
static long failures, survived;

/* From 0 to .1 with the fault, as long as there is one; x: where it leads. The status of the first
 * end. */
static enum pk_status motion(const struct pk_method *method, double h, double *x)
{
    static struct test_params params;
    const struct pk_system system = faulty();
    const struct pk_problem problem = {.system = &system, .params = &params};
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    struct pk_events events;
    double q[MOST], v[MOST];
    const size_t n = system.n, size = pk_integrator_size(&problem, method);
    fault.of->defaults(&params);
    fault.of->start(&params, q, v);
    options.h = h;
    options.rtol = options.atol = 1e-8;
    options.max_steps = 2000;
    CU_ASSERT_FATAL(size <= sizeof room / 2 && n <= MOST);
    fault.calls = 0;
    enum pk_status status =
        pk_integrator_init(&it, &problem, method, &options, 0, q, v, room, size);
    CU_ASSERT(told(&it));
    if (status >= 0) {
        CU_ASSERT_FATAL(pk_events_size(&problem, method) <= sizeof room / 2);
        status = pk_events_init(&events, &it, room + SIZE, sizeof room / 2);
        CU_ASSERT(status >= 0 || it.status < 0 || told(&events.scout));
        if (status >= 0)
            status = pk_events_to(&events, &it, 0.1);
        if (status >= 0) {
            CU_ASSERT(it.t >= 0.1);
            const int here = pk_integrator_dense(&it, (it.last_t + it.t) / 2, q, v) >= 0;
            CU_ASSERT(here || it.status < 0);
            CU_ASSERT(!here || (pk_all_finite(q, n) && pk_all_finite(v, n)));
        }
        CU_ASSERT(told(&it) && it.t >= 0 && it.t <= 0.1);
        pk_events_free(&events);
    }
    if (status < 0 && status != PK_REFUSED && it.own->state && !fault.for_ever) {
        /* It has passed: from the last valid state on, if that is one. */
        CU_ASSERT(!it.own->ready || (pk_all_finite(it.q, n) && pk_all_finite(it.v, n)));
        if (it.own->ready && pk_integrator_to(&it, 0.1) >= 0)
            status = PK_DONE;
        CU_ASSERT(told(&it));
    }
    memset(x, 0, 2 * MOST * sizeof *x);
    if (status >= 0) {
        memcpy(x, it.q, n * sizeof *x);
        memcpy(x + n, it.v, n * sizeof *x);
    }
    pk_integrator_free(&it);
    return status;
}

static void of_system(const struct pk_system *system, double h, long deep)
{
    static const char *const names[] = {
        "acceleration",  "mass",    "canonical",  "jacobian", "linear",
        "singularity",   "event",   "constraint", "rows",     "terms",
        "unconstrained", "inertia", "marking",    "prepare",  "lanes"};
    double right[2 * MOST], x[2 * MOST];
    fault.of = system;
    for (size_t i = 0; fixture_method(i); i++) {
        const struct pk_method *method = fixture_method(i);
        fault.at = 1, fault.for_ever = 0, fault.which = KERNELS;
        if (motion(method, h, right) < 0)
            continue;
        for (int which = 0; which < KERNELS; which++)
            for (int as = which == ACCELERATION || which >= PREPARE ? 0 : 1;
                 as <= (which >= PREPARE ? 0 : 3); as++)
                for (long at = 1; at <= deep; at += 1 + at / 3)
                    for (int ever = 0; ever < 2; ever++) {
                        if (DEEP < 2 && which == CANONICAL && as == 3 && ever)
                            continue; /* nothing converges, for half a minute */
                        fault.which = (enum kernel)which, fault.at = at;
                        fault.as_number = as, fault.for_ever = ever;
                        const enum pk_status status = motion(method, h, x);
                        failures += status < 0;
                        if (fault.calls < at)
                            continue;
                        double off = 0;
                        for (size_t k = 0; k < 2 * MOST && status >= 0; k++)
                            off = fmax(off, fabs(x[k] - right[k]) / (1 + fabs(right[k])));
                        survived += status >= 0;
                        if (!ever && as != 3 && !(off <= 1e-6)) {
                            printf("\n    %s, %s: %s at call %ld, %d: off by %.2g", system->name,
                                   method->name, names[which], at, as, off);
                            CU_FAIL("who goes on gets elsewhere");
                        }
                    }
    }
}

TEST("each kernel")
{
    failures = survived = 0;
    of_system(&double_pendulum_system, 0.01, DEEP);
    of_system(&turning_system, 0.01, DEEP);
    of_system(&rod_system, 0.01, DEEP);
    of_system(&barred_system, 0.01, DEEP);
    for (size_t k = 0; DEEP > 1 && k < 3; k++) {
        const struct pk_system *more[] = {&pendulum_system, &carriage_system, &maxwell_system};
        of_system(more[k], 0.01, DEEP);
    }
    printf("\n    %ld failed, %ld did not", failures, survived);
    CU_ASSERT(failures > 1000 && survived > 1000);
}
