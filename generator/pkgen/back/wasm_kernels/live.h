/* A model as a live page or another language calls it: motions by any method, values at any state,
 * swarms. Compiled with one model and the runtime's core, to WebAssembly, whose one caller is
 * engine.js, to a shared library, that of model.py, or by those of back/bound. Parameters are a flat
 * array in the order of the description, not a number where the default is meant. q has the
 * coordinates, v the rates and behind them the first-order variables. All in SI.
 */
#ifndef LIVE_H
#define LIVE_H

#include <pk/method.h>

#if defined __wasm__
#define EXPORT(name) __attribute__((export_name(#name))) name
#define OF_THREAD
#else /* a shared library shows what is defined behind this */
#define EXPORT(name) name
#define OF_THREAD _Thread_local /* any number of threads, each with motions of its own */
#if defined __GNUC__
#pragma GCC visibility push(default)
#endif
#endif

enum { LONGEST_TEXT = 600 };

extern const struct pk_system *const live_system;
/* Methods that its author brings, beside the runtime's. */
extern const struct pk_method *const *const live_own;
extern const size_t live_own_count;

/* Why the last call was refused. */
extern OF_THREAD char live_reason_text[LONGEST_TEXT];

const struct pk_method *live_method(const char *name); /* NULL: there is none */

int refuse(const char *text); /* 0 */

struct live; /* a motion: see motion.c */
int live_to(struct live *m, double t, double budget);
const double *live_q(const struct live *m), *live_v(const struct live *m);

#endif
