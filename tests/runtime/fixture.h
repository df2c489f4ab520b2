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

struct fixture {
    struct pk_problem problem;
    struct test_params params;
    struct pk_options options;
    struct pk_integrator it;
    double q0[3], v0[3];
    double block[4096];
};

/* Defaults, start and options; then change what the test is about and call fixture_init(). */
void fixture_set(struct fixture *f, const struct pk_system *system);
enum pk_status fixture_init(struct fixture *f, const char *method);
/* Both, and to t_end in steps of h (fixed) or at rtol = atol = h (adaptive). */
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
int radial_acceleration(const void *p, double t, const double *q, const double *v, const double *u,
                        double *a);
/* The singularity q[0]. */
void first_coordinate(const void *p, double t, const double *q, const double *v, const double *u,
                      double *out);
/* Distance in (q, v), maximum norm. */
double fixture_distance(const struct fixture *f, const double *q, const double *v);
/* Least-squares slope of log y over log x. */
double fit_slope(const double *x, const double *y, int count);
/* Number i of the core's methods and then GSL's; NULL behind them. */
const struct pk_method *fixture_method(size_t i);
/* The order that a method has up to t_end: the slope of the finest errors above rounding, by
 * `off`. */
double fixture_order(const struct pk_system *system, const struct pk_method *method, double t_end,
                     double rounding, double (*off)(const struct fixture *, const double *),
                     const double *exact);

void add_tables(void);
void add_switches(void);
void add_switch_families(void);
void add_order(void);
void add_gauss(void);
void add_dense(void);
void add_memory(void);
void add_memory_blocks(void);
void add_keep(void);
void add_faults(void);
void add_geometry(void);
void add_status(void);
void add_silence(void);
void add_control(void);
void add_scale(void);
void add_marks(void);
void add_limits(void);
void add_equilibria(void);
void add_action(void);
void add_particles(void);
void add_diagnostics(void);
void add_ensemble(void);
void add_advance(void);
void add_adaptive_verlet(void);
void add_linear(void);
void add_band(void);
void add_singularity(void);
void add_singularity_families(void);
void add_singularity_cause(void);
void add_after_failure(void);
void add_events(void);
void add_events_within(void);
void add_events_found(void);
void add_variation(void);
void add_chaos(void);
void add_spectrum(void);
void add_branch(void);
void add_implicit(void);
void add_exponential(void);
void add_linear_drag(void);
void add_unread(void);
void add_subsystems(void);
void add_least_action(void);
void add_states(void);
void add_states_between(void);
void add_rotation(void);
void add_rotation_beside(void);
void add_constraint(void);
void add_constraint_told(void);
void add_variational(void);
void add_variational_end(void);

#endif
