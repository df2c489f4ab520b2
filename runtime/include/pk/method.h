/* An integration method as one const struct: its name, its traits, the facts that it requires of a
 * system, and its functions. Most methods are a table of coefficients and the code of a family, so
 * a new tableau is one table and one row of pk/methods.h. */
#ifndef PK_METHOD_H
#define PK_METHOD_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>
#include <pk/system.h>

/* Adaptive step sizes are computed with pow, exp and log, whose results differ between processors
 * in the last bits. With PK_PORTABLE step sizes are rounded to float, for the same bits
 * everywhere. */
#ifdef PK_PORTABLE
#define PK_SAME(x) ((pk_real)(float)(x))
#else
#define PK_SAME(x) (x)
#endif

PK_BEGIN

/* Traits of a method. Symplectic: in (q, p), at a fixed step size. */
enum pk_trait {
    PK_SYMPLECTIC = 1u << 0,
    PK_SYMMETRIC = 1u << 1,
    PK_ADAPTIVE = 1u << 2,
    PK_IMPLICIT = 1u << 3,
    PK_DENSE = 1u << 4,     /* the method has dense output */
    PK_JACOBIANS = 1u << 5, /* calls the kernels mass and jacobian */
    PK_LINEAR = 1u << 6,    /* calls the kernels mass and linear */
    PK_NO_INPUTS = 1u << 7, /* needs time derivatives of all terms, so refuses inputs */
    PK_EXACT = 1u << 8,     /* steps of any length are exact but for rounding; order = 0 */
    PK_HOLONOMIC = 1u << 9, /* solves holonomic constraints within its steps, and does not take
                               rolling constraints; calls the kernels unconstrained and inertia,
                               or canonical and mass */
    PK_GROUP = 1u << 10,    /* keeps quaternions of rotations at unit length, to rounding */
    PK_NOISE = 1u << 11,    /* takes models with noise */
    PK_JETS = 1u << 12      /* calls the kernel jet */
};

struct pk_integrator;
struct pk_problem;
struct pk_keep;

/* The stages of a step: Q, n numbers of each stage, V, n numbers; h a_ij for q and for p, and h b_j
 * as a last row. */
struct pk_stages {
    pk_real *c, *Q, *V, *A, *A_p;
};

struct pk_method {
    const char *name;
    const char *doc; /* description in one line, and citation */
    int order;       /* order of the method; 0: variable */
    /* evaluations of the acceleration in a step, without one that the next reuses; 0: variable */
    int stages;
    int dense_order; /* order of the dense output; 0: no dense output */
    unsigned traits; /* bits of enum pk_trait */
    unsigned needs;  /* bits of enum pk_fact (`requires` is a keyword of C++20) */
    const void *table;
    const struct pk_method *formula; /* the method that an adaptive method becomes at a fixed
                                        step size, for pk/limits.h; NULL: the method itself */

    /* Returns the number of pk_real of work memory if v has length n. NULL: it is
     * pk_splitting_size(). */
    size_t (*size)(const struct pk_method *method, const struct pk_problem *problem, size_t n);
    enum pk_status (*init)(struct pk_integrator *it); /* NULL: nothing to initialise */
    /* Computes a step that does not pass `limit`; writes the state to it->own->next, the time to
     * it->own->next_t. Must not change it->own->state. */
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit);
    /* Interpolates within the last step; NULL: the method is not PK_DENSE. */
    enum pk_status (*dense)(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
    /* Returns the longest step in which events are located reliably; NULL: any step. */
    pk_real (*resolved)(const struct pk_integrator *it);
    /* Returns the LU factors (pk_lu_factor()) of the linear equations that the last step solved, in
     * stages * n unknowns; it returns NULL if the step solved none. It is NULL for a method that
     * solves no such equations. */
    const pk_real *(*equations)(struct pk_integrator *it);
    /* For methods of foreign libraries that allocate; NULL for all others. keep() saves or restores
     * their memory (pk/keep.h), or returns PK_REFUSED if that memory is opaque. */
    void (*release)(struct pk_integrator *it);
    enum pk_status (*keep)(struct pk_integrator *it, struct pk_keep *k);
    /* Copies the stages of the last step. NULL: the method is no implicit Runge-Kutta method. */
    void (*last)(struct pk_integrator *it, struct pk_stages *to);
};

/* Returns whether the caller gives the length of steps. */
static inline int pk_is_fixed(const struct pk_method *method)
{
    return !(method->traits & PK_ADAPTIVE);
}

/* Return a method of the core, or NULL. See pk/gsl.h for GSL's methods. */
const struct pk_method *pk_method_find(const char *name);
const struct pk_method *pk_method_at(size_t index);

PK_END

#endif
