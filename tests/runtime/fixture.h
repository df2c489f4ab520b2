/* One integration for a test: system, parameters, integrator and its memory. */
#ifndef TEST_FIXTURE_H
#define TEST_FIXTURE_H

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <CUnit/CUnit.h>

#include <pk/gsl.h>
#include <pk/pk.h>

#include "systems.h"

enum { FIXTURE_N = 20 };
struct fixture {
    struct pk_problem problem;
    struct test_params params;
    struct pk_options options;
    struct pk_integrator it;
    double q0[FIXTURE_N], v0[FIXTURE_N];
    double block[1 << 16];
};

/* Defaults, start and options; then change what the test is about and call one of the next. */
void fixture_set(struct fixture *f, const struct pk_system *system);
/* By the options as they are. */
enum pk_status fixture_init(struct fixture *f, const char *method);
/* By steps of h (fixed) or at rtol = atol = h (adaptive); with 0 by the options as they are. */
enum pk_status fixture_begin(struct fixture *f, const char *method, double h);
/* The same, which has to succeed; and all of a system's own. */
void fixture_start(struct fixture *f, const char *method, double h);
void fixture_open(struct fixture *f, const struct pk_system *system, const char *method, double h);
/* And to t_end. */
enum pk_status fixture_run(struct fixture *f, const struct pk_system *system, const char *method,
                           double h, double t_end);
/* A reference: gauss8 at short steps, in (q, p), from a start to t. */
void fixture_exact(struct fixture *f, const struct pk_system *system, const double *q,
                   const double *v, double t, int steps);
typedef int acceleration_function(const void *, pk_real, const pk_real *, const pk_real *,
                                  const pk_real *, pk_real *);
/* The oscillator with another acceleration, all through function pointers; and one singularity. */
struct pk_system free_point(acceleration_function *acceleration);
struct pk_system guarded_point(acceleration_function *acceleration,
                               const struct pk_singularity *what,
                               void (*singularity)(const void *, pk_real, const pk_real *,
                                                   const pk_real *, const pk_real *, pk_real *));
/* r'' = J^2/r^3, the radial equation of a free point: limit is J. */
int radial_acceleration(ARGS, double *a);
/* The singularity q[0]. */
void first_coordinate(ARGS, double *out);
/* Distance to v, and to q without the integrals of states; maximum norm. */
double fixture_distance(const struct fixture *f, const double *q, const double *v);
struct pk_residuals fixture_residuals(const struct fixture *f);
double fixture_energy(const struct fixture *f);
/* The reason of the last status has this in it. */
int says(const struct pk_integrator *it, const char *part);
/* Least-squares slope of log y over log x. */
double fit_slope(const double *x, const double *y, int count);
/* Number i of the core's methods and then GSL's; NULL behind them. */
const struct pk_method *fixture_method(size_t i);
/* The order that a method has up to t_end: the slope of the finest errors above rounding, by
 * `off`. */
double fixture_order(const struct pk_system *system, const struct pk_method *method, double t_end,
                     double rounding, double (*off)(const struct fixture *, const double *),
                     const double *exact);
/* The same by the distance to a run of another method in so many steps. */
double fixture_order_beside(const struct pk_system *system, const struct pk_method *method,
                            double t_end, double rounding, const char *other, int steps);

/* What is asked of methods on groups and on constraints: variational methods first, then others of
 * fixed step, then adaptive ones, GSL's too. */
enum { BOUND_VARIATIONAL = 6, BOUND_FIXED = 13, BOUND_METHODS = 18, BOUND_GAUSS = 15 };
extern const char *const bound_methods[BOUND_METHODS];

/* A test, which main() runs: TEST("what it checks") and its body. The file is its suite. */
struct test {
    const char *file, *title;
    void (*run)(void);
    struct test *next;
};
void add_test(struct test *test);
#define TEST(title) TEST_OF(title, __LINE__)
#define TEST_OF(title, line) TEST_OF_LINE(title, line)
#define TEST_OF_LINE(title, line)                                       \
    static void test_##line(void);                                      \
    __attribute__((constructor)) static void add_##line(void)           \
    {                                                                   \
        static struct test test = {__FILE__, title, test_##line, NULL}; \
        add_test(&test);                                                \
    }                                                                   \
    static void test_##line(void)

#endif
