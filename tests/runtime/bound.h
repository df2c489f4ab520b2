/* One integration of a system with rotations or constraints, which need more room than fixture.h
 * has, and what is asked of many of them.
 */
#ifndef TEST_BOUND_H
#define TEST_BOUND_H

#include "fixture.h"

enum { BOUND_N = 20 };
/* Variational methods first, then others of fixed step, then adaptive ones, GSL's too. */
enum { BOUND_VARIATIONAL = 6, BOUND_FIXED = 13, BOUND_METHODS = 18, BOUND_GAUSS = 15 };
extern const char *const bound_methods[BOUND_METHODS];

struct bound_run {
    struct pk_problem problem;
    struct test_params params;
    struct pk_options options;
    struct pk_integrator it;
    double q0[BOUND_N], v0[BOUND_N];
    double block[1 << 16];
};

void bound_set(struct bound_run *f, const struct pk_system *system);
/* h: the step, or the tolerance of adaptive methods. */
enum pk_status bound_init(struct bound_run *f, const char *method, double h);
enum pk_status bound_go(struct bound_run *f, const struct pk_system *system, const char *method,
                        double h, double t_end);
/* To v, and to q without the integrals of states; maximum norm. */
double bound_distance(const struct bound_run *f, const double *q, const double *v);
/* Slope of error over step, of the finest five errors above round-off. */
double bound_order(const struct pk_system *system, const char *method, double t_end);
struct pk_residuals bound_residuals(const struct bound_run *f);
double bound_energy(const struct bound_run *f);
/* The reason of the last status has this in it. */
int bound_says(const struct bound_run *f, const char *part);

#endif
