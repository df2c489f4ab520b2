/* The one contract between generated C and the runtime: a mechanical system as a table of
 * kernels and facts. pkgen emits `const struct pk_system NAME_system` behind PK_RUNTIME.
 *
 * A state is n_q coordinates q and n numbers v: the rates of the coordinates, then what has a rate of
 * its own. With time t, inputs u and parameters
 *
 *     q' = v[0 .. n_q)
 *     v' = a(t, q, v, u)      v = [rates of q | body rates of rotations | their quaternions | states]
 *
 * of which the last four are blocks of one vector, for methods, step control, dense output and
 * whatever else looks at a state: a quaternion's part of a is Q (0, omega)/2, linear in the body
 * rates, that of a state x is g in x' = g(t, q, v, x). Of the rates of q and the body rates
 *
 *     p    = dL/dv                        momenta
 *     p'   = dL/dq + Q - dD/dv            pdot: Q generalized forces, D the Rayleigh function
 *     M a  = f                            M = dp/dv,  f = pdot - (dp/dq) v - dp/dt
 *     h    = v.p - L                      energy
 *
 * and of all others p is the number itself, M 1 and f its rate. Matrices are n by n, row-major:
 * M[i*n + j]; derivatives by q are 0 in columns of what is no coordinate. Arrays never alias. Units are SI. Kernels are
 * reentrant and allocate nothing. `params` is the model's own struct NAME_params.
 */
#ifndef PK_SYSTEM_H
#define PK_SYSTEM_H

#include <pk/kernel.h>
#include <pk/status.h>
#include <pk/system_constraints.h>
#include <pk/system_families.h>
#include <pk/system_singular.h>

PK_BEGIN

/* Which layout the structs of a system have, and of which scalar type. A library is of one: a
 * system of another does not link with it, since it names the library's PK_SCALAR; one that is
 * loaded at run time is refused by its number. */
#if defined PK_FLOAT
#define PK_SCALAR pk_scalar_is_float
#define PK_ABI 93u
#elif defined PK_LONG_DOUBLE
#define PK_SCALAR pk_scalar_is_long_double
#define PK_ABI 94u
#elif defined PK_FLOAT128
#define PK_SCALAR pk_scalar_is_float128
#define PK_ABI 95u
#else
#define PK_SCALAR pk_scalar_is_double
#define PK_ABI 92u
#endif
extern const char PK_SCALAR[];

/* Facts about a system that methods may require; proved by pkgen, never guessed. */
enum pk_fact {
    PK_MASS_CONSTANT = 1u << 0, /* M does not depend on q, v, t, u */
    PK_MASS_DIAGONAL = 1u << 1,
    PK_QUADRATIC = 1u << 2,    /* L is of second degree in v: M does not depend on v */
    PK_SEPARABLE = 1u << 3,    /* M constant, and f depends on q, t and u alone */
    PK_AUTONOMOUS = 1u << 4,   /* nothing depends on t explicitly, and there are no inputs */
    PK_CONSERVATIVE = 1u << 5, /* h is constant: dL/dt = 0, no Q, no D, no inputs */
    PK_VARIATIONAL = 1u << 6,  /* no Q and no D: the flow is symplectic */
    PK_SMOOTH = 1u << 7,       /* no abs, min, max or step in the equations */
    PK_AFFINE = 1u << 8,       /* a = A q + B v + c with constant A, B, c; no t and no inputs */
    PK_SWITCHED = 1u << 9,     /* smooth with the sides of all switches given */
    /* Not separable, but nearly: M constant, no first-order variables, no constraints, and */
    PK_LINEAR_DRAG = 1u << 10,  /* f = g(q, t, u) + C v with constant C */
    PK_AFFINE_RATES = 1u << 11, /* f = g(q, t, u) + C(q, t, u) v */
    PK_FAST = 1u << 12          /* separable, and a part of the forces is named: see fast() */
};

/* A parameter: where it is in struct NAME_params, and where its value may lie. */
struct pk_parameter {
    struct pk_quantity what;
    size_t offset; /* in bytes */
    int follows;   /* its default is computed from other parameters */
    int lo_open, hi_open;
};

/* A method's step with the kernels of one system compiled into it; see pk/inlined.h. */
struct pk_integrator;
struct pk_stepper {
    const char *method; /* NULL ends the list */
    enum pk_status (*step)(struct pk_integrator *it, pk_real limit);
};

/* The same for many states side by side; see pk/abreast.h. */
struct pk_block;
struct pk_block_stepper {
    const char *method;                                    /* NULL ends the list */
    size_t lanes;                                          /* states a block, at most 64 */
    unsigned long long (*step)(struct pk_block *block);    /* of the length that is given */
    unsigned long long (*attempt)(struct pk_block *block); /* of an adaptive method: a trial */
    /* Accelerations at block->t. All three return the bits of lanes that failed. */
    unsigned long long (*members)(struct pk_block *block, const pk_real *q, const pk_real *v,
                                  pk_real *a);
    /* Functions of events, then of switches, at block->t: number k of lane l is g[k * lanes + l].
     * NULL: there are none compiled in. */
    void (*values)(const struct pk_block *block, const pk_real *q, const pk_real *v, pk_real *g);
};

/* The parts of a system. One that is zero is not there. */

/* The particles of which T = sum of m/2 |r'|^2, or what of L is of the second degree in the rates:
 * masses, and x, y, z (0 beside a plane) of r, r' and r'' of each, with a = q'' given. */
struct pk_part_particles {
    size_t n;
    void (*at)(const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
               const pk_real *a, pk_real *m, pk_real *r, pk_real *r_v, pk_real *r_a);
};

struct pk_system {
    unsigned abi;       /* PK_ABI */
    const char *scalar; /* PK_SCALAR; NULL: not asked */
    const char *name;
    const char *source_hash; /* SHA-256 of the model's text, in hexadecimal */
    unsigned facts;          /* of enum pk_fact */
    size_t n;                /* numbers of v; of families see pk_system_count() */
    size_t n_parameters, n_inputs, n_observed, n_conserved;
    size_t params_size; /* sizeof (struct NAME_params) */

    /* First-order variables, n - n_q: the last ones of v, which are no rates of coordinates. Their
     * names are those of the rates there. The Lagrangian and the energy take them as given
     * functions of time; energy is NULL in a model without coordinates. */
    size_t n_first_order;
    /* So many of the last ones no rate depends on, not their own either: quadratures. Newton's
     * equations are of the others. 0 of families kept as loops. */
    size_t n_unread;
    /* Rotations, attitudes R in SO(3), body to space. The first 3 n_rotations of the first-order
     * variables are their body rates, omega(R).x, .y, .z each; the next 4 n_rotations their unit
     * quaternions Q = (w, x, y, z), with Q' = Q (0, omega)/2: the matrix R turns by R v = Q v Q*.
     * Of all kernels: p = dL/domega and pdot = X L + p x omega + torque there, X_i the derivative
     * along Q' = Q e_i/2; the momenta are those of the body frame. */
    size_t n_rotations; /* but of families kept as loops: see pk_system_turning() */

    /* Names: n coordinates, n rates, n momenta, and so on. */
    const struct pk_quantity *coordinates, *rates, *momenta, *inputs, *observed, *conserved;
    const struct pk_parameter *parameters;
    const unsigned char *cyclic; /* n flags: p_i is constant (dL/dq_i = 0, no Q_i, no dD/dv_i) */

    /* Parameters. defaults() sets all of them and calls prepare(). derive() computes again the
     * defaults that follow other parameters, except where given[i] != 0 (given may be NULL: none
     * is given). prepare() computes what depends on parameters alone and must follow any change;
     * it returns 0 or a failure (PK_FAILURE_PARAMETER, PK_FAILURE_DERIVED, PK_FAILURE_SIZE).
     * bounds() gives the bounds, infinite where there is none. */
    void (*defaults)(void *params);
    void (*derive)(void *params, const unsigned char *given);
    int (*prepare)(void *params);
    void (*bounds)(const void *params, pk_real *lo, pk_real *hi);
    void (*start)(const void *params, pk_real *q, pk_real *v);

    /* a with M a = f. Returns 0 or a failure (PK_FAILURE_MASS, PK_FAILURE_CONSTRAINT); then a is
     * not written. */
    int (*acceleration)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                        const pk_real *u, pk_real *a);
    pk_kernel *mass, *force;
    pk_kernel_2 *canonical; /* p and pdot together: a stage of a Gauss method needs both */
    pk_kernel *gradient;    /* dL/dq alone */
    /* What Newton's method on (p, pdot) needs: dp/dq, d(pdot)/dq, d(pdot)/dv. (dp/dv is M.) */
    void (*jacobian)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                     const pk_real *u, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v);
    pk_kernel_number *energy;
    pk_kernel_number *kinetic, *potential; /* T and V; NULL where the model states L alone */
    pk_kernel *observe, *conserve; /* outputs by `observe`, claims by `conserve`; NULL: none */
    /* Derivatives of r = f - M a by q, v and t, with a and the inputs held: where a is the
     * acceleration, M da/dq = r_q, and so on. For variational equations and implicit methods in
     * (q, v); see pk/linear.h. NULL: there is none. */
    void (*linear)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *u, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t);
    /* canonical() without J^T lambda: p = dL/dv (of quaternions and first-order variables: the
     * numbers themselves) and pdot (their rates); and dp/dv of that p. Models with
     * rotations, constraints, impulses or momenta that depend on states have both, since their
     * mass() may be the unit matrix (the model has solved M a = f itself), and canonical() then
     * does not give the momenta. */
    pk_kernel_2 *unconstrained;
    pk_kernel *inertia;
    pk_kernel *fast; /* the acceleration by what the model names fast; NULL: nothing is */

    /* The acceleration of PK_LANES states at once: t[l], q[i * PK_LANES + l], and so on. Bit l of
     * the result: lane l failed as acceleration() does, and a is not to be used there. With the
     * same parameters in each lane; or with P[k * PK_LANES + l] number k of the params of lane l,
     * which are an array of pk_real. NULL: there is none. */
    unsigned long long (*lanes)(const void *params, const pk_real *t, const pk_real *q,
                                const pk_real *v, const pk_real *u, pk_real *a);
    unsigned long long (*members)(const pk_real *P, const pk_real *t, const pk_real *q,
                                  const pk_real *v, const pk_real *u, pk_real *a);
    /* NULL: none compiled in. To be NULL in a copy of a system whose kernels are replaced. */
    const struct pk_stepper *steppers;
    const struct pk_block_stepper *block_steppers;

    struct pk_part_singularities singularities;
    struct pk_part_events events;
    struct pk_part_switches switches;
    struct pk_part_marks marks;
    struct pk_part_constraints constraints;
    struct pk_part_families families;
    struct pk_part_particles particles;
};

/* Numbers of v. */
static inline size_t pk_system_count(const struct pk_system *system, const void *params)
{
    return system->families.count ? system->families.count(params) : system->n;
}

static inline size_t pk_system_outputs(const struct pk_system *system, const void *params)
{
    return system->families.outputs ? system->families.outputs(params) : system->n_observed;
}

/* Of these the last ones, which are first-order variables. */
static inline size_t pk_system_first_order(const struct pk_system *system, const void *params)
{
    return system->families.first_order ? system->families.first_order(params)
                                        : system->n_first_order;
}

/* Coordinates, n_q. */
static inline size_t pk_system_coordinates(const struct pk_system *system, const void *params)
{
    return pk_system_count(system, params) - pk_system_first_order(system, params);
}

static inline size_t pk_system_rotations(const struct pk_system *system, const void *params)
{
    return system->families.rotations ? system->families.rotations(params) : system->n_rotations;
}

static inline struct pk_turning pk_system_turning(const struct pk_system *system,
                                                  const void *params, size_t r)
{
    const size_t first = pk_system_count(system, params) - system->n_first_order;
    const struct pk_turning found = {first + 3 * r, first + 3 * system->n_rotations + 4 * r, 1};
    return system->families.turning ? system->families.turning(params, r) : found;
}

/* The pattern of its derivatives by what rates depend on: dense ones are a border alone. */
static inline struct pk_pattern pk_system_pattern(const struct pk_system *system,
                                                  const void *params)
{
    struct pk_pattern pattern = {0, 0, system->n - system->n_unread, 1};
    if (system->families.pattern)
        system->families.pattern(params, &pattern);
    return pattern;
}

/* Members of declared coordinate, output, ... number k. */
static inline struct pk_range pk_system_range(const struct pk_system *system, const void *params,
                                              enum pk_range_of of, size_t k)
{
    struct pk_range range = {0, 1, 0};
    if (system->families.range)
        system->families.range(params, of, k, &range);
    return range;
}

/* Rows of constraints, or of those of positions alone. */
static inline size_t pk_system_rows(const struct pk_system *system, const void *params,
                                    int holonomic)
{
    const struct pk_part_constraints *c = &system->constraints;
    return c->count ? c->count(params, holonomic) : holonomic ? c->n_holonomic : c->n;
}

/* How many values there are of singularities. */
static inline size_t pk_system_singularity_count(const struct pk_system *system, const void *params)
{
    return system->singularities.count ? system->singularities.count(params)
                                       : system->singularities.n;
}

/* Which singularity value number k is of. */
static inline struct pk_place pk_system_singularity(const struct pk_system *system,
                                                    const void *params, size_t k)
{
    struct pk_place place = {k, 0, 0};
    if (system->singularities.place)
        system->singularities.place(params, k, &place);
    return place;
}

/* How many switches there are. */
static inline size_t pk_system_switch_count(const struct pk_system *system, const void *params)
{
    return system->switches.count ? system->switches.count(params) : system->switches.n;
}

/* Which expression switch number k is of, and of which member. */
static inline struct pk_place pk_system_switch(const struct pk_system *system, const void *params,
                                               size_t k)
{
    struct pk_place place = {k, 0, 0};
    if (system->switches.place)
        system->switches.place(params, k, &place);
    return place;
}

/* Its name with i and j in brackets as numbers: "x[8] - x[7]". */
int pk_system_singularity_name(const struct pk_system *system, const void *params, size_t k,
                               char *text, size_t size);

/* The same of switch number k: "q[8]'". "x": there is no such switch. */
int pk_system_switch_name(const struct pk_system *system, const void *params, size_t k, char *text,
                          size_t size);

/* The name of output i. Of both the length is returned as snprintf() does. */
int pk_system_output_name(const struct pk_system *system, const void *params, size_t i, char *text,
                          size_t size);

/* The name of coordinate i (a number in q): "theta", "q[3]". `table` is the system's coordinates,
 * rates or momenta ("q[3]'", "p_q[3]"). */
int pk_system_name(const struct pk_system *system, const void *params,
                   const struct pk_quantity *table, size_t i, char *text, size_t size);

PK_END

#endif
