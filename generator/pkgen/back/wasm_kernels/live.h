/* The functions by which a live page or another language calls a model: motions by any method,
 * values at any state, swarms. They are compiled with one model and the runtime's core, to
 * WebAssembly (called by engine.js) or to a shared library. Parameters are a flat array in the
 * order of the description; NaN stands for the default. q has the coordinates, v the rates and then
 * the first-order variables. All units are SI.
 */
#ifndef LIVE_H
#define LIVE_H

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

enum { LONGEST_TEXT = 600 };

extern const struct pk_system *const live_system;
/* Methods that the model's author defines; they precede the runtime's. */
extern const struct pk_method *const *const live_own;
extern const size_t live_own_count;

/* The reason of the last refusal. */
extern OF_THREAD char live_reason_text[LONGEST_TEXT];

const struct pk_method *live_method(const char *name); /* NULL: there is none */

int refuse(const char *text); /* sets the reason and returns 0 */

struct live; /* a motion: see motion.c */
int live_to(struct live *m, double t, double budget);
const double *live_q(const struct live *m), *live_v(const struct live *m);

#endif
