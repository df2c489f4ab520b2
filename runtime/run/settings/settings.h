/* Settings as the run uses them, and what follows from them. */
#ifndef RUN_SETTINGS_H
#define RUN_SETTINGS_H

#include "../base/json.h"
#include "../base/state.h"

/* What was asked for, with parameters and starts computed; a code. */
enum pk_run_code settings_take(struct pk_run *run);
/* Into `params`: those that the settings give, then `more`, then defaults that follow from them.
 * `params` is a copy of the settings' own, or that. 0: there is no such parameter. */
int settings_assign(struct settings *s, void *params, const struct pk_run_value *more,
                    size_t n_more);
/* settings->marks, while its lists are there. */
void settings_mark(struct settings *s);
/* Parameters as they are in memory; with the start, one JSON object. */
void json_parameters_known(struct json *j, const struct pk_system *system, const void *params);
void settings_tell(struct pk_run *run, FILE *file);
/* Says which parameter prepare() refused, its value and bounds; of what follows from all, their
 * values. `whose` stands before. */
void settings_refused(struct pk_run *run, const void *params, int outside, const char *whose);

/* Of the model with these parameters, its inputs constant.
 */
struct pk_problem run_problem(struct pk_run *run);
/* Into settings->u the inputs that the caller computes at a state; and where he does so at each
 * evaluation. */
void compute_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v,
                    int stop);
void refresh_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v);
/* The interval of rows where none was asked for, and at most all. */
void settle_every(struct settings *s);
/* How the options of `pkgen run`, and of a program that it builds, call settings. */
extern const struct pk_words run_options;

const struct pk_method *run_method_find(const struct pk_run_model *model, const char *name);
/* What there would be with more: behind a name that is not found. */
const char *run_method_lack(const char *name);

/* The number under which a member, from 0 on, is spoken of. */
long member_number(const struct settings *s, size_t member);
/* Whether each runs by itself: its events are watched, or there are switches. */
int member_by_one(const struct settings *s);

#endif
