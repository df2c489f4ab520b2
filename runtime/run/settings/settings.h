/* Settings as the run uses them, and values derived from them. */
#ifndef RUN_SETTINGS_H
#define RUN_SETTINGS_H

#include "../base/json.h"
#include "../base/state.h"

/* Converts run->settings.asked, with parameters and start computed. Returns the exit code. */
enum pk_run_code settings_take(struct pk_run *run);
/* Sets in `params` the settings' parameters, then `more`, then derived defaults. `params` is
 * settings->params or a copy of it. Returns 0 if there is no such parameter. */
int settings_assign(struct settings *s, void *params, const struct pk_run_value *more,
                    size_t n_more);
/* Sets settings->marks. */
void settings_mark(struct settings *s);
/* Writes the parameters as they are in memory; settings_tell() writes them with the start. */
void json_parameters_known(struct json *j, const struct pk_system *system, const void *params);
void settings_tell(struct pk_run *run, FILE *file);
/* Adds a message why prepare() refused the parameters: one with its value and bounds, or all with
 * their values. `whose` is the start of the message. */
void settings_refused(struct pk_run *run, const void *params, int outside, const char *whose);

/* Returns the model with the run's parameters; inputs are settings->u or computed by the caller.
 */
struct pk_problem run_problem(struct pk_run *run);
/* compute_inputs() sets settings->u to the inputs that the caller computes at a state;
 * refresh_inputs() does so only if they change at each evaluation. */
void compute_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v,
                    int stop);
void refresh_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v);
/* Sets the default interval of rows; it is at most `until`. */
void settle_every(struct settings *s);
/* Names of settings in messages: the options of `pkgen run` and of built programs. */
extern const struct pk_words run_options;

const struct pk_method *run_method_find(const struct pk_run_model *model, const char *name);
/* Returns the text behind the name of a method that was not found: how to get it, or "". */
const char *run_method_lack(const char *name);

/* Returns the number of a member in rows and messages; `member` counts from 0. */
long member_number(const struct settings *s, size_t member);
/* Returns whether each member has a run of its own: events are watched, or there are switches. */
int member_by_one(const struct settings *s);

#endif
