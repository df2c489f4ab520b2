/* What each way to an arm's dynamics has: see main.c. C and C++. */
#ifndef ARM_H
#define ARM_H

#ifdef __cplusplus
extern "C" {
#endif

enum arm_what { ARM_ACCELERATION, ARM_MASS, ARM_FORCE };

/* The arm that the file describes, each way in a form of its own; the word is an option of its own.
 * 0, or not: it cannot be had. */
int arm_open(const char *file, const char *word);

/* a with M a = f; M, n rows of n; or f: at q and v, n numbers each. 0, or not: it failed. */
int arm_evaluate(enum arm_what what, const double *q, const double *v, double *out);

#ifdef __cplusplus
}
#endif

#endif
