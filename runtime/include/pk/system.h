/* The interface between generated C and the runtime: a mechanical system as a table of kernels
 * (functions) and facts. pkgen emits `const struct pk_system NAME_system` if PK_RUNTIME is defined.
 *
 * A state is n_q coordinates q and n numbers v: the rates of the coordinates, then the first-order
 * variables, which have rates of their own. With time t, inputs u and parameters
 *
 *     q' = v[0 .. n_q)
 *     v' = a(t, q, v, u)   v = [rates of q | body rates of rotations | their quaternions | states]
 *
 * Methods, step control and dense output treat v as one vector; its last three blocks are
 * first-order variables. The rows of a are Q (0, omega)/2 for a quaternion Q with body rates omega,
 * and g for a state x with x' = g(t, q, v, x). The rates of q and the body rates satisfy
 *
 *     p    = dL/dv                        momenta
 *     p'   = dL/dq + Q - dD/dv            pdot: Q generalized forces, D the Rayleigh function
 *     M a  = f                            M = dp/dv,  f = pdot - (dp/dq) v - dp/dt
 *     h    = v.p - L                      energy
 *
 * For the first-order variables in v except body rates, p is the variable itself, the row of M is
 * that of the unit matrix, and f is the rate of the variable. Matrices are n by n, row-major: M[i*n
 * + j]; derivatives by q are 0 in columns j >= n_q. Arrays never alias. Units are SI. Kernels are
 * reentrant and do not allocate. `params` is struct NAME_params. */
#ifndef PK_SYSTEM_H
#define PK_SYSTEM_H

#include <pk/kernel.h>
#include <pk/status.h>
#include <pk/system_constraints.h>
#include <pk/system_families.h>
#include <pk/system_singular.h>
#include <pk/table.h>

PK_BEGIN

/* The version of the structs that a model and the runtime share. A new kernel is appended to struct
 * pk_system and does not change PK_ABI_VERSION; moving a member does. `size` is the number of bytes
 * of a system's struct, so the runtime checks PK_SYSTEM_HAS() before it reads a member that was
 * added after version 1. A system compiled for another scalar type does not link, since it refers
 * to the symbol PK_SCALAR of a library; a system loaded later is refused if its PK_ABI differs. */
#define PK_ABI_VERSION 2u
#if defined PK_FLOAT
#define PK_SCALAR pk_scalar_is_float
#define PK_ABI (4 * PK_ABI_VERSION + 1)
#elif defined PK_LONG_DOUBLE
#define PK_SCALAR pk_scalar_is_long_double
#define PK_ABI (4 * PK_ABI_VERSION + 2)
#elif defined PK_FLOAT128
#define PK_SCALAR pk_scalar_is_float128
#define PK_ABI (4 * PK_ABI_VERSION + 3)
#else
#define PK_SCALAR pk_scalar_is_double
#define PK_ABI (4 * PK_ABI_VERSION)
#endif
#define PK_SYSTEM_HAS(system, member)                                                         \
    (offsetof(struct pk_system, member) + sizeof(system)->member <= (size_t)(system)->size && \
     (system)->member)
extern const char PK_SCALAR[];

/* Facts about a system that methods may require; pkgen derives them from the equations. */
enum pk_fact {
    PK_MASS_CONSTANT = 1u << 0, /* M does not depend on q, v, t, u */
    PK_MASS_DIAGONAL = 1u << 1,
    PK_QUADRATIC = 1u << 2,    /* L is of second degree in v: M does not depend on v */
    PK_SEPARABLE = 1u << 3,    /* M is constant, and f depends only on q, t and u */
    PK_AUTONOMOUS = 1u << 4,   /* nothing depends on t explicitly, and there are no inputs */
    PK_CONSERVATIVE = 1u << 5, /* h is constant: dL/dt = 0, no Q, no D, no inputs */
    PK_VARIATIONAL = 1u << 6,  /* no Q and no D: the flow is symplectic */
    PK_SMOOTH = 1u << 7,       /* no abs, min, max or step in the equations */
    PK_AFFINE = 1u << 8,       /* a = A q + B v + c with constant A, B, c; no inputs */
    /* the equations are smooth as long as the sides of all switches are constant */
    PK_SWITCHED = 1u << 9,
    /* The facts PK_LINEAR_DRAG and PK_AFFINE_RATES also imply that M is constant and that there are
     * no first-order variables and no constraints. */
    PK_LINEAR_DRAG = 1u << 10,  /* f = g(q, t, u) + C v with constant C */
    PK_AFFINE_RATES = 1u << 11, /* f = g(q, t, u) + C(q, t, u) v */
    /* the system is separable, and some forces are declared fast (see the kernel `fast`) */
    PK_FAST = 1u << 12,
    PK_SERIES = 1u << 13 /* the kernel `jet` can be written */
};

/* A parameter: its byte offset in struct NAME_params, and the kind of its bounds. */
struct pk_parameter {
    struct pk_quantity what;
    size_t offset; /* byte offset */
    int follows;   /* 1: the default value depends on other parameters */
    int lo_open, hi_open;
};

/* A method's step function compiled together with the kernels of one system; see pk/inlined.h. */
struct pk_integrator;
struct pk_stepper {
    const char *method; /* NULL marks the end of the list */
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit);
};

/* A method's step function for a block of states in SIMD lanes; see pk/adaptive_lanes.h. */
struct pk_block;
struct pk_block_stepper {
    const char *method;                                    /* NULL marks the end of the list */
    size_t lanes;                                          /* states in a block, at most 64 */
    unsigned long long (*step)(struct pk_block *block);    /* makes a step of given size */
    unsigned long long (*attempt)(struct pk_block *block); /* makes a trial step, or NULL */
    /* Computes accelerations at block->t. Returns, as step() and attempt(), failed lanes. */
    unsigned long long (*members)(struct pk_block *block, const pk_real *q, const pk_real *v,
                                  pk_real *a);
    /* Computes the functions of all events, then those of all switches, at block->t. Number k of
     * lane l is g[k * lanes + l]. NULL: the function was not compiled. */
    void (*values)(const struct pk_block *block, const pk_real *q, const pk_real *v, pk_real *g);
};

/* The optional parts of a system; the members of an absent part are zero. */

/* The n particles of the system. Their kinetic energy, the sum of m/2 |r'|^2, is the terms of L of
 * second degree in the rates. at() writes the masses m, and the components x, y, z (z = 0 in a
 * plane) of each r, r' and r''; its argument a is q''. */
struct pk_part_particles {
    size_t n;
    void (*at)(const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
               const pk_real *a, pk_real *m, pk_real *r, pk_real *r_v, pk_real *r_a);
};

/* A sample block: a controller that runs at the times T0 + k T. next() writes all inputs after a
 * sample, as functions of those before it. */
struct pk_sample {
    const char *name;
    pk_kernel *next;
};
/* start() writes T and T0 of each block, and the inputs at the start of a motion. `held` has a flag
 * for each input: 1 if a block sets it. */
struct pk_part_samples {
    size_t n;
    const struct pk_sample *table;
    const unsigned char *held;
    pk_kernel_2 *start;
};

/* Independent white noises. values() writes the two-sided intensity S of each, and for each the n
 * accelerations by a unit force along it; both depend on q and t alone. */
struct pk_part_noise {
    size_t n;
    const char *const *names;
    pk_kernel_2 *values;
};

/* Jacobians that a compile was asked for by name, row-major, of `width` numbers in all. `moving`
 * takes an acceleration a, else `plain` is set. */
struct pk_jacobian {
    const char *name;
    size_t width;
    pk_kernel *plain;
    pk_kernel_moving *moving;
};
struct pk_part_sensitivity {
    size_t n;
    const struct pk_jacobian *table;
};

enum { PK_JET_ORDER = 30 };

struct pk_system {
    unsigned abi;  /* PK_ABI when the model was compiled */
    unsigned size; /* sizeof (struct pk_system) when the model was compiled */
    /* address of the symbol PK_SCALAR, which libraries for other scalar types lack; or NULL */
    const char *scalar;
    const char *name;
    const char *source_hash; /* SHA-256 of the model's source, in hexadecimal */
    unsigned facts;          /* bits of enum pk_fact */
    size_t n;                /* length of v; in a system of variable size see pk_system_count() */
    size_t n_parameters, n_inputs, n_observed, n_conserved;
    size_t params_size; /* sizeof (struct NAME_params) */

    /* Number of first-order variables, n - n_q. They are the last entries of v, and `rates` has
     * their names. The Lagrangian and the energy treat first-order variables as given functions of
     * time. `energy` is NULL in a model without coordinates. */
    size_t n_first_order;
    /* Number of quadratures: first-order variables on which no rate depends. They are the last
     * numbers of v. Newton's equations of implicit methods omit them. 0 in one of variable size. */
    size_t n_unread;
    /* Number of rotations: attitudes R in SO(3), body to space. The first 3 n_rotations first-order
     * variables are the body rates, omega(R).x, .y, .z of each rotation; the next 4 n_rotations are
     * their unit quaternions Q = (w, x, y, z), with Q' = Q (0, omega)/2 and R r = Q r Q*. For body
     * rates, all kernels have p = dL/domega and pdot = X L + p x omega + torque, where X_i is the
     * derivative along Q' = Q e_i/2; these momenta are in the body frame. */
    size_t n_rotations; /* in a system of variable size see pk_system_rotations() */

    /* Tables of names: n coordinates, n rates, n momenta, n_inputs inputs, and so on. */
    const struct pk_quantity *coordinates, *rates, *momenta, *inputs, *observed, *conserved;
    const struct pk_parameter *parameters;
    const unsigned char *cyclic; /* n flags: p_i is constant (dL/dq_i = 0, Q_i = 0, dD/dv_i = 0) */

    /* Parameters. defaults() sets all of them and calls prepare(). derive() recomputes the defaults
     * that depend on other parameters; it leaves parameter i unchanged if given[i] is nonzero. With
     * given = NULL it recomputes all of them. prepare() computes numbers that depend only on
     * parameters; call it after any change. It returns 0 or a failure (PK_FAILURE_PARAMETER,
     * PK_FAILURE_DERIVED, PK_FAILURE_SIZE). bounds() writes the bounds, infinite where there is
     * none. start() writes the start values. */
    void (*defaults)(void *params);
    void (*derive)(void *params, const unsigned char *given);
    int (*prepare)(void *params);
    void (*bounds)(const void *params, pk_real *lo, pk_real *hi);
    void (*start)(const void *params, pk_real *q, pk_real *v);

    /* Computes a with M a = f. Returns 0, or a PK_FAILURE_MASS or _CONSTRAINT without a. */
    int (*acceleration)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                        const pk_real *u, pk_real *a);
    pk_kernel *mass, *force;
    /* writes p, then pdot, since the stages of a Gauss method need both */
    pk_kernel_2 *canonical;
    pk_kernel *gradient; /* writes dL/dq */
    /* Jacobians of p and pdot for the Newton iteration of methods in (q, p): dp/dq, d(pdot)/dq,
     * d(pdot)/dv. The fourth one, dp/dv, is M. */
    void (*jacobian)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                     const pk_real *u, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v);
    pk_kernel_number *energy;
    pk_kernel_number *kinetic, *potential; /* T and V; NULL if the model defines only L */
    pk_kernel *observe, *conserve; /* outputs of `observe`, constants of `conserve`; NULL: none */
    /* Writes the derivatives r_q, r_v, r_t of r = f - M a by q, v and t, at constant a and inputs.
     * If a is the acceleration, M da/dq = r_q, and likewise for v and t. The kernel is for
     * variational equations and implicit methods in (q, v); see pk/linear.h. NULL: left out. */
    void (*linear)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *u, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t);
    /* unconstrained() does the same as canonical(), but without the constraint forces J^T lambda:
     * it writes p = dL/dv and pdot, and for the other first-order variables their values and rates.
     * inertia() writes the derivative dp/dv of this p. Models with rotations, constraints, impulses
     * or momenta that depend on first-order variables have both kernels: their mass() may be the
     * unit matrix (the model has solved M a = f itself), and canonical() writes no momenta. */
    pk_kernel_2 *unconstrained;
    pk_kernel *inertia;
    pk_kernel *fast; /* acceleration by the forces declared fast; NULL: none */

    /* Accelerations of PK_LANES states at once: t[l], q[i * PK_LANES + l], and so on. Returns a bit
     * mask: bit l is set if the acceleration failed in lane l, where a is then invalid. lanes() has
     * the same parameters in each lane; members() has parameters P[k * PK_LANES + l], number k of
     * the params of lane l as an array of pk_real. NULL: not compiled in. */
    unsigned long long (*lanes)(const void *params, const pk_real *t, const pk_real *q,
                                const pk_real *v, const pk_real *u, pk_real *a);
    unsigned long long (*members)(const pk_real *P, const pk_real *t, const pk_real *q,
                                  const pk_real *v, const pk_real *u, pk_real *a);
    /* Steps compiled together with the kernels of this system, or NULL. If you copy the system and
     * replace a kernel, set both to NULL in the copy. */
    const struct pk_stepper *steppers;
    const struct pk_block_stepper *block_steppers;

    struct pk_part_singularities singularities;
    struct pk_part_events events;
    struct pk_part_switches switches;
    struct pk_part_marks marks;
    struct pk_part_constraints constraints;
    struct pk_part_families families;
    struct pk_part_particles particles;
    /* A flag for each switch, or NULL. 1: the equations jump at every integer of the switch's value
     * u, as floor(u) does. Its side is then 2 n + 1 while n <= u <= n + 1. */
    const unsigned char *counted;
    /* Offsets in the params of the pointers to the tables, const struct pk_table *. */
    const size_t *tables;
    size_t n_tables;
    int consistent; /* whether pk_integrator_reset() moves to the nearest state on constraints */
    struct pk_part_samples samples;
    struct pk_part_resets resets;
    struct pk_part_contacts contacts;
    struct pk_part_noise noise;
    struct pk_part_sensitivity sensitivity;
    /* Writes Taylor coefficients of q and v up to order <= PK_JET_ORDER, n_q + n numbers for each
     * order. Returns 0, or a failure as acceleration(). NULL: left out. */
    int (*jet)(const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
               int order, pk_real *c);
    int jet_fast; /* the order up to which jet() is straight-line code */
    /* Add new members here, at the end. */
};

/* Return n, the length of v, and the numbers of outputs, first-order variables, rotations, values
 * of singularities, and switches. */
#define PK_NUMBER(name, counted, otherwise)                                                   \
    static inline size_t pk_system_##name(const struct pk_system *system, const void *params) \
    {                                                                                         \
        return system->counted ? system->counted(params) : system->otherwise;                 \
    }
PK_NUMBER(count, families.count, n)
PK_NUMBER(outputs, families.outputs, n_observed)
PK_NUMBER(first_order, families.first_order, n_first_order)
PK_NUMBER(rotations, families.rotations, n_rotations)
PK_NUMBER(singularity_count, singularities.count, singularities.n)
PK_NUMBER(switch_count, switches.count, switches.n)

/* Returns n_q, the number of coordinates. */
static inline size_t pk_system_coordinates(const struct pk_system *system, const void *params)
{
    return pk_system_count(system, params) - pk_system_first_order(system, params);
}

static inline struct pk_turning pk_system_turning(const struct pk_system *system,
                                                  const void *params, size_t r)
{
    const size_t first = pk_system_count(system, params) - system->n_first_order;
    const struct pk_turning found = {first + 3 * r, first + 3 * system->n_rotations + 4 * r, 1};
    return system->families.turning ? system->families.turning(params, r) : found;
}

/* Returns the sparsity pattern of Jacobians by q or v, without rows and columns of quadratures. If
 * `dense` is set, the matrix has no band. */
static inline struct pk_pattern pk_system_pattern(const struct pk_system *system,
                                                  const void *params)
{
    struct pk_pattern pattern = {0, 0, system->n - system->n_unread, 1};
    if (system->families.pattern)
        system->families.pattern(params, &pattern);
    return pattern;
}

/* Returns the index range of declared name number k among those that `of` says. */
static inline struct pk_range pk_system_range(const struct pk_system *system, const void *params,
                                              enum pk_range_of of, size_t k)
{
    struct pk_range range = {0, 1, 0};
    if (system->families.range)
        system->families.range(params, of, k, &range);
    return range;
}

/* Returns the number of constraint rows, or, if `holonomic` is nonzero, of holonomic rows. */
static inline size_t pk_system_rows(const struct pk_system *system, const void *params,
                                    int holonomic)
{
    const struct pk_part_constraints *c = &system->constraints;
    return c->count ? c->count(params, holonomic) : holonomic ? c->n_holonomic : c->n;
}

/* Return, for value k of the singularities or switch k, the index of its expression, i and j. */
#define PK_PLACE(name, part)                                                       \
    static inline struct pk_place pk_system_##name(const struct pk_system *system, \
                                                   const void *params, size_t k)   \
    {                                                                              \
        struct pk_place found = {k, 0, 0};                                         \
        if (system->part.place)                                                    \
            system->part.place(params, k, &found);                                 \
        return found;                                                              \
    }
PK_PLACE(singularity, singularities)
PK_PLACE(switch, switches)

/* Writes the expression of value number k of the singularities, with numbers in place of the
 * indices i and j: "x[8] - x[7]". */
int pk_system_singularity_name(const struct pk_system *system, const void *params, size_t k,
                               char *text, size_t size);

/* Writes the name of switch number k, such as "q[8]'"; "x" if there is no switch k. */
int pk_system_switch_name(const struct pk_system *system, const void *params, size_t k, char *text,
                          size_t size);

/* Writes the name of output i. All functions for names return the length as snprintf() does. */
int pk_system_output_name(const struct pk_system *system, const void *params, size_t i, char *text,
                          size_t size);

/* Writes the name of coordinate i, an index into q, such as "theta" or "q[3]"; with `table` the
 * system's rates or momenta "q[3]'" or "p_q[3]". */
int pk_system_name(const struct pk_system *system, const void *params,
                   const struct pk_quantity *table, size_t i, char *text, size_t size);

PK_END

#endif
