/* Settings in the form that the run uses, and values derived from them. */
#ifndef RUN_SETTINGS_H
#define RUN_SETTINGS_H

#include "../base/json.h"
#include "../base/state.h"

/* Converts the caller's settings; computes parameters and initial state. Returns the exit code. */
enum pk_run_code settings_take(struct pk_run *run);
/* Sets `params` from the parameters in the settings, then those in `more`, then derived defaults.
 * `params` is settings->params or a copy of it. Returns 0 if a parameter does not exist. */
int settings_assign(struct settings *s, void *params, const struct pk_run_value *more,
                    size_t n_more);
/* Sets settings->marks. */
void settings_mark(struct settings *s);
/* Writes the current parameters; settings_tell() also writes the initial state. */
void json_parameters_known(struct json *j, const struct pk_system *system, const void *params);
void settings_tell(struct pk_run *run, FILE *file);
/* Adds a message that says why prepare() refused the parameters: it names one with its value and
 * bounds, or all with their values. The message begins with `whose`. */
void settings_refused(struct pk_run *run, const void *params, int outside, const char *whose);

/* Returns the model with the run's parameters; inputs are settings->u or computed by the caller. */
struct pk_problem run_problem(struct pk_run *run);
/* compute_inputs() sets settings->u by the caller's function at a state; refresh_inputs() only does
 * so if inputs change at each evaluation. */
void compute_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v,
                    int stop);
/* The function `replace` of the run's sampler. */
int run_sampled(void *context, size_t block, pk_real t, const pk_real *q, const pk_real *v,
                pk_real *next);
void refresh_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v);
/* Returns a Jacobian that the model was compiled with, or NULL. */
const struct pk_jacobian *run_jacobian_named(const struct pk_system *system, const char *name);
/* Sets the default interval between rows, at most `until`. */
void settle_every(struct settings *s);
/* Names of settings in messages: options of `pkgen run` and of built programs. */
extern const struct pk_words run_options;

const struct pk_method *run_method_find(const struct pk_run_model *model, const char *name);
/* Returns a text that says how to get a method that was not found, or "". */
const char *run_method_lack(const char *name);

/* Returns the number of a member in rows and messages; the index `member` begins at 0. */
long member_number(const struct settings *s, size_t member);
/* Returns whether each member is run with a struct pk_run of its own. This is so if events are
 * watched or the system has switches or sample blocks. */
int member_by_one(const struct settings *s);

#endif
