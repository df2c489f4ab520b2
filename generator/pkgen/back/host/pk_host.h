/* The one interface of a model in C, by which all hosts call it: pages, wheels, crates, packages,
 * MEX and units. It is compiled with one model and the runtime's core, to WebAssembly, to a shared
 * library, or into a program. Units are SI.
 *
 *     void *params = pk_host_params(1, 1);
 *     pk_host_given(values);                      change values here
 *     if (!pk_host_set(params, values)) ...       pk_host_why() is the reason
 *     pk_host_start(params, y);
 *     struct pk_host_motion *m = pk_host_motion_new(params, "gauss", 0.01, 1e-9, 0, y, u);
 *     while ((code = pk_host_to(m, t, 1e6)) == 1) ...
 *     pk_host_free(m); pk_host_params_free(params);
 *
 * Parameters are a flat array in the order of the description, a member of a family each. NaN
 * stands for a value that follows from others. A state y is n_q coordinates, then n rates and
 * first-order variables: see pk/system.h. u are the inputs.
 */
#ifndef PK_HOST_H
#define PK_HOST_H

#include <pk/method.h>

#if defined __wasm__
#define EXPORT(name) __attribute__((export_name(#name))) name
#define OF_THREAD
#else /* a shared library exports the names that are defined after this */
#define EXPORT(name) name
#define OF_THREAD _Thread_local /* each thread may have motions of its own */
#if defined __GNUC__
#pragma GCC visibility push(default)
#endif
#endif

enum { PK_HOST_TEXT = 600 }; /* longest reason */

/* The model, generated: data.py. Values that are not there are NaN, arrays of none NULL. */
struct pk_host_model {
    const struct pk_system *system;
    const double *parameters, *lo, *hi, *inputs, *start;
    /* Flags of parameters and starts that follow from parameters until they are set. */
    const unsigned char *follows, *start_follows;
    const char *const *names; /* of parameters */
    size_t n_parameters;
    /* Methods that the model's author defines. */
    const struct pk_method *const *own;
    size_t n_own;
};
extern const struct pk_host_model pk_host_model;

/* The reason of this thread's last refusal. */
const char *EXPORT(pk_host_why)(void);
int pk_host_refuse(const char *text); /* sets the reason and returns 0 */
extern OF_THREAD char pk_host_text[PK_HOST_TEXT];

/* Parameters. */

/* Allocates `count` structs in a row, each with its own memory for families if `own`, otherwise all
 * sharing one. Only the first has its defaults set. Returns NULL without memory. */
void *EXPORT(pk_host_params)(size_t count, int own);
void EXPORT(pk_host_params_free)(void *params);
size_t EXPORT(pk_host_params_size)(void);
size_t EXPORT(pk_host_parameters)(const void *params);  /* their number */
size_t EXPORT(pk_host_n)(const void *params);           /* length of v */
size_t EXPORT(pk_host_coordinates)(const void *params); /* n_q */
/* Writes the values that the model begins with. */
void EXPORT(pk_host_given)(double *values);
void EXPORT(pk_host_inputs)(double *u);
/* Sets the parameters, and writes all that follow back to `values`. Returns 1, or 0 with a reason:
 * one is out of bounds. */
int EXPORT(pk_host_set)(void *params, double *values);
/* Writes the start to y, which has room for 2 n numbers. */
void EXPORT(pk_host_start)(const void *params, double *y);

/* Values at `count` states, one after another; `out` has the values of each, NaN where there are
 * none. Returns how many states have them. */
enum pk_host_kind {
    PK_HOST_ACCELERATIONS, /* n: rates of v */
    PK_HOST_ENERGY,
    PK_HOST_OUTPUTS,
    PK_HOST_CLAIMS, /* constants of the motion that the author claims */
    PK_HOST_MOMENTA /* n */
};
size_t EXPORT(pk_host_values)(const void *params, int kind, size_t count, const double *t,
                              const double *y, const double *u, double *out);

/* Motions: one state, integrated by any method to any time. */
struct pk_host_motion;

const struct pk_method *pk_host_method(const char *name); /* NULL: there is none */
/* Returns a motion, or NULL with a reason. A method that adapts its steps chooses the first one if
 * h is 0. The caller keeps params while it uses the motion; inputs are constant. */
struct pk_host_motion *EXPORT(pk_host_motion_new)(const void *params, const char *method, double h,
                                                  double rtol, double t, const double *y,
                                                  const double *u);
void EXPORT(pk_host_free)(struct pk_host_motion *m);
/* Integrates to t by at most `budget` steps. Returns 0 at t, 1 if more steps are needed, 2 if an
 * event ended the motion before, otherwise another status with a reason. t does not affect the
 * steps: the state at t comes from dense output or a shorter step aside. A time before the last
 * step is refused, since no state is kept there. */
int EXPORT(pk_host_to)(struct pk_host_motion *m, double t, double budget);
/* Writes the states at `times`, each reached by at most `budget` steps. Returns the number of rows
 * written; *status is the result of the last pk_host_to(). */
size_t EXPORT(pk_host_rows)(struct pk_host_motion *m, size_t count, const double *times,
                            double budget, double *rows, int *status);
double EXPORT(pk_host_t)(const struct pk_host_motion *m);
const double *EXPORT(pk_host_y)(const struct pk_host_motion *m);
double EXPORT(pk_host_steps)(const struct pk_host_motion *m);
double EXPORT(pk_host_evaluations)(const struct pk_host_motion *m);
/* Crossings of events since the last call of pk_host_crossed(), which returns their number and has
 * to come first: event, t, y of each. */
size_t EXPORT(pk_host_crossed)(struct pk_host_motion *m);
const double *EXPORT(pk_host_crossings)(const struct pk_host_motion *m);

#endif
