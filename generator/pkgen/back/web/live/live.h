/* A model as a live page calls it: motions by any method, values at any state, swarms. Compiled with
 * one model and the runtime's core to WebAssembly; engine.js is its one caller. Parameters are a
 * flat array in the order of the description, not a number where the default is meant. q has
 * the coordinates, v the rates and behind them the first-order variables. All in SI.
 */
#ifndef LIVE_H
#define LIVE_H

#include <pk/method.h>

#define EXPORT(name) __attribute__((export_name(#name))) name

enum { LONGEST_TEXT = 600 };

extern const struct pk_system *const live_system;
/* Methods that its author brings, beside the runtime's. */
extern const struct pk_method *const *const live_own;
extern const size_t live_own_count;

/* Why the last call was refused. */
extern char live_reason_text[LONGEST_TEXT];

const struct pk_method *live_method(const char *name); /* NULL: there is none */

int refuse(const char *text); /* 0 */

#endif
