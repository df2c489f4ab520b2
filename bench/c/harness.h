/* What a contender written in C offers, and the main() around it: requests come as lines on the
 * standard input, "setting t_end seconds y0...", answers are lines "time y...", the time in seconds
 * of one integration alone, the mean over as many as fill `seconds` (at least one). "failed WHY"
 * where it did not get there. Each contender is a program of its own, so each keeps its makers'
 * compiler and flags, and the programs take turns.
 */
#ifndef BENCH_HARNESS_H
#define BENCH_HARNESS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The length of y: q, then q'. */
extern const size_t bench_length;
/* Called once, before all else. NULL, or why the contender cannot run. */
const char *bench_open(int argc, char **argv);
/* Settings of a new request, outside of the time. `setting` is a relative tolerance or a step. */
const char *bench_prepare(double setting, const double *y0, double t_end);
/* One integration from t = 0 to t_end; y holds y0 on entry and the final state on return. */
const char *bench_integrate(double setting, double *y, double t_end);

#ifdef __cplusplus
}
#endif

#endif
