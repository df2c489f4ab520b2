/* An integration method as one const struct: what it is called, what it promises, what it needs
 * of a system, and how it makes a step. Most methods are a table and a family's loop, so a new
 * tableau is one table entry and one row of pk/methods.h.
 */
#ifndef PK_METHOD_H
#define PK_METHOD_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>
#include <pk/system.h>

/* Step lengths come from pow, exp and log of the C library, whose last bits differ from one
 * processor to another. With PK_PORTABLE they are rounded to the 24 bits of a float, which do not.
 */
#ifdef PK_PORTABLE
#define PK_SAME(x) ((pk_real)(float)(x))
#else
#define PK_SAME(x) (x)
#endif

PK_BEGIN

/* What a method promises. Symplectic is meant in (q, p) at a fixed step. */
enum pk_trait {
    PK_SYMPLECTIC = 1u << 0,
    PK_SYMMETRIC = 1u << 1,
    PK_ADAPTIVE = 1u << 2,
    PK_IMPLICIT = 1u << 3,
    PK_DENSE = 1u << 4,     /* pk_integrator_dense() works */
    PK_JACOBIANS = 1u << 5, /* calls the system's mass and jacobian */
    PK_LINEAR = 1u << 6,    /* calls the system's mass and linear */
    PK_NO_INPUTS = 1u << 7, /* needs d/dt of all, which inputs do not give */
    PK_EXACT = 1u << 8,     /* a step of any length errs by rounding alone; its order is 0 */
    PK_HOLONOMIC = 1u << 9, /* ends its steps on holonomic constraints itself, and takes no
                                rolling; calls unconstrained and inertia, or canonical and mass */
    PK_GROUP = 1u << 10     /* turns rotations on SO(3): unit quaternions but for rounding */
};

struct pk_integrator;
struct pk_problem;
struct pk_keep;

struct pk_method {
    const char *name;
    const char *doc; /* one line and the citation */
    int order;       /* 0: variable */
    int stages;      /* evaluations a step, last-is-first-of-next counted once; 0: variable */
    int dense_order; /* local interpolant's order; 0: none */
    unsigned traits; /* of enum pk_trait */
    unsigned needs;  /* of enum pk_fact (`requires` is a keyword of C++20) */
    const void *table;
    const struct pk_method *formula; /* the method of a fixed step that an adaptive one varies, for
                                        pk/limits.h; NULL: itself */

    /* Number of pk_real of work for a problem of n degrees of freedom; NULL: what splitting needs. */
    size_t (*size)(const struct pk_method *method, const struct pk_problem *problem, size_t n);
    enum pk_status (*init)(struct pk_integrator *it); /* NULL: nothing */
    /* One step into it->own->next, to it->own->next_t, not past `limit`. Must leave it->own->state
     * alone. */
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit);
    /* Between the ends of the last step; NULL without PK_DENSE. */
    enum pk_status (*dense)(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
    /* The longest step in which no crossing of an event is missed; NULL: any step it makes. */
    pk_real (*resolved)(const struct pk_integrator *it);
    /* The matrix of its last step's equations, of `stages` times n unknowns, as pk_lu_factor()
     * leaves it; NULL where that step had none. NULL: it has no such equations. */
    const pk_real *(*equations)(struct pk_integrator *it);
    /* Only for methods of foreign libraries that allocate; else NULL. The second is pk/keep.h's of
     * that memory, PK_REFUSED where nobody sees it. */
    void (*release)(struct pk_integrator *it);
    enum pk_status (*keep)(struct pk_integrator *it, struct pk_keep *k);
};

/* NULL where there is none. The core's methods; see pk/gsl.h for GSL's. */
const struct pk_method *pk_method_find(const char *name);
const struct pk_method *pk_method_at(size_t index);

PK_END

#endif
