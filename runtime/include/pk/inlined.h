/* Compiles steps together with the kernels of one model. The C that pkgen generates includes it
 * before its struct pk_system, once for each model in a file. The source of a step,
 * pk/step/FAMILY.h, is also compiled in the library, which calls kernels by function pointers; here
 * the number of coordinates is a constant and the kernels are inlined. -DPK_INLINE_ERK, _EMBEDDED,
 * _SPLITTING, _GAUSS, _TAYLOR select families, and -DPK_INLINE_ENSEMBLE adds their steps in SIMD lanes.
 * Without these macros the library's steps are used. "-DPK_SPLITTING_METHODS(X)=X(verlet)", and
 * likewise _ERK_ and _EMBEDDED_, compiles fewer methods of a family.
 *
 * The generated C defines PK_MODEL(x), which prefixes x with the model's name; PK_MODEL_N(it) if
 * the length of v is not the constant PK_MODEL(N); PK_MODEL_FIRST_ORDER if it has first-order
 * variables; PK_MODEL_JET if it has the kernel jet; and PK_MODEL_WITHOUT_LANES or PK_MODEL_WITHOUT_MEMBERS if it has no kernel `lanes` or
 * `members`: then the library's steps are used. Steps use the macros
 *
 *     PK_STEPPER(x)                   x with a name that is unique in this file
 *     PK_STEPPER_N(it)                the length of v
 *     PK_STEPPER_COORDINATES(it)      the number of coordinates
 *     PK_STEPPER_INPUT(it, t)         the inputs at t
 *     PK_STEPPER_FEEDBACK(it, t, q, v)              the inputs at a state
 *     PK_STEPPER_ACCELERATION(it, t, q, v, u, a)    0, or the failure of acceleration()
 *     PK_STEPPER_LANES(it, t, q, v, u, a)           the bits of lanes that failed
 *     PK_STEPPER_JET(it, t, q, v, u, order, c)      0, or the failure of jet()
 *     PK_BLOCK_...                    see pk/step/ensemble.h */
#include <pk/step/state.h>

#undef PK_INLINE_STEPPERS
#undef PK_INLINE_BLOCK_STEPPERS
#ifndef PK_MODEL_FIRST_ORDER
#define PK_MODEL_FIRST_ORDER 0
#endif
#ifndef PK_STEPPER
#define PK_STEPPER(x) PK_MODEL(step_##x)
#ifdef PK_MODEL_N
#define PK_STEPPER_N(it) PK_MODEL_N(it)
#define PK_STEPPER_COORDINATES(it) ((it)->n_q)
#else
#define PK_STEPPER_N(it) ((void)(it), (size_t)PK_MODEL(N))
#define PK_STEPPER_COORDINATES(it) ((void)(it), (size_t)PK_MODEL(N) - PK_MODEL_FIRST_ORDER)
#endif
#define PK_STEPPER_INPUT(it, t) (PK_MODEL(INPUTS) > 0 ? pk_eval_input(it, t) : (it)->own->u)
#define PK_STEPPER_FEEDBACK(it, t, q, v) \
    (PK_MODEL(INPUTS) > 0 ? pk_eval_feedback(it, t, q, v) : (it)->own->u)
#define PK_STEPPER_ACCELERATION(it, t, q, v, u, a) \
    PK_MODEL(acceleration)((const struct PK_MODEL(params) *)(it)->problem.params, t, q, v, u, a)
#define PK_STEPPER_LANES(it, t, q, v, u, a)                                                       \
    PK_MODEL(lanes_inline)(PK_LANES, (const struct PK_MODEL(params) *)(it)->problem.params, t, q, \
                           v, u, a)
#define PK_STEPPER_JET(it, t, q, v, u, order, c) \
    PK_MODEL(jet)((const struct PK_MODEL(params) *)(it)->problem.params, t, q, v, u, order, c)

/* Number of ensemble members in a block. Their states, stages and parameters should fit into the L1
 * cache. */
#ifndef PK_INLINE_LANES
#define PK_INLINE_LANES (PK_MODEL(N) <= 4 ? 64 : PK_MODEL(N) <= 8 ? 32 : 16)
#endif
#define PK_BLOCK_LANES(b) ((void)(b), (size_t)PK_INLINE_LANES)
#define PK_BLOCK_N(b) ((void)(b), (size_t)PK_MODEL(N))
#define PK_BLOCK_COORDINATES(b) ((void)(b), (size_t)PK_MODEL(N) - PK_MODEL_FIRST_ORDER)
#define PK_BLOCK_MEMBERS(b, q, v, a) PK_STEPPER(members)((b)->P, (b)->t, q, v, (b)->u, a)

#define PK_INLINED_STEP(method, call)                                                  \
    static enum pk_status PK_STEPPER(method)(struct pk_integrator * it, pk_real limit) \
    {                                                                                  \
        (void)limit;                                                                   \
        return call;                                                                   \
    }
#define PK_INLINED_ERK(method) PK_INLINED_STEP(method, PK_STEPPER(erk)(it, &pk_##method##_table))
#define PK_INLINED_EMBEDDED(method) \
    PK_INLINED_STEP(method, PK_STEPPER(embedded)(it, &pk_##method##_table, limit))
#define PK_INLINED_SPLITTING(method) \
    PK_INLINED_STEP(method, PK_STEPPER(splitting)(it, &pk_##method##_table))
#define PK_INLINED_GAUSS(method) PK_INLINED_STEP(method##_adaptive, PK_STEPPER(gauss)(it, limit))
#define PK_INLINED_TAYLOR(method) PK_INLINED_STEP(method, PK_STEPPER(taylor_step)(it, limit))
#define PK_INLINED_GAUSS_ENTRY(method) {#method, PK_STEPPER(method##_adaptive)},
#define PK_INLINED_ENTRY(method) {#method, PK_STEPPER(method)},
#define PK_INLINED_BLOCK(method, call) \
    static unsigned long long PK_STEPPER(block_##method)(struct pk_block * b) { return call; }
#define PK_INLINED_BLOCK_RUNGE_KUTTA(method) \
    PK_INLINED_BLOCK(method, PK_STEPPER(block_erk)(b, &pk_##method##_table))
#define PK_INLINED_BLOCK_SPLITTING(method) \
    PK_INLINED_BLOCK(method, PK_STEPPER(block_splitting)(b, &pk_##method##_table))
#define PK_INLINED_BLOCK_EMBEDDED(method) \
    PK_INLINED_BLOCK_RUNGE_KUTTA(method)  \
    PK_INLINED_BLOCK(attempt_##method, PK_STEPPER(block_attempt)(b, &pk_##method##_table))
#define PK_INLINED_BLOCK_ENTRY(method)                               \
    {#method, PK_INLINE_LANES,           PK_STEPPER(block_##method), \
     NULL,    PK_STEPPER(block_members), PK_INLINED_VALUES},
#define PK_INLINED_BLOCK_ENTRY_EMBEDDED(method) \
    {#method,                                   \
     PK_INLINE_LANES,                           \
     PK_STEPPER(block_##method),                \
     PK_STEPPER(block_attempt_##method),        \
     PK_STEPPER(block_members),                 \
     PK_INLINED_VALUES},
#endif

#if defined PK_INLINE_ERK || defined PK_INLINE_EMBEDDED || defined PK_INLINE_SPLITTING || \
    defined PK_INLINE_GAUSS || defined PK_INLINE_TAYLOR
#define PK_INLINE_STEPPERS PK_STEPPER(steppers)
#include <pk/step/evaluate.h>

#ifdef PK_INLINE_ERK
#include <pk/step/erk.h>
PK_ERK_METHODS(PK_INLINED_ERK)
#endif
#ifdef PK_INLINE_EMBEDDED
#include <pk/step/embedded.h>
PK_EMBEDDED_METHODS(PK_INLINED_EMBEDDED)
#endif
#ifdef PK_INLINE_SPLITTING
#include <pk/step/splitting.h>
PK_SPLITTING_METHODS(PK_INLINED_SPLITTING)
#endif
#if defined PK_INLINE_GAUSS && !defined PK_MODEL_WITHOUT_LANES
#include <pk/step/gauss.h>
PK_GAUSS_METHODS(PK_INLINED_GAUSS)
#endif
#if defined PK_INLINE_TAYLOR && defined PK_MODEL_JET
#include <pk/step/taylor.h>
PK_TAYLOR_METHODS(PK_INLINED_TAYLOR)
#endif

static const struct pk_stepper PK_STEPPER(steppers)[] = {
#ifdef PK_INLINE_ERK
    PK_ERK_METHODS(PK_INLINED_ENTRY)
#endif
#ifdef PK_INLINE_EMBEDDED
        PK_EMBEDDED_METHODS(PK_INLINED_ENTRY)
#endif
#ifdef PK_INLINE_SPLITTING
            PK_SPLITTING_METHODS(PK_INLINED_ENTRY)
#endif
#if defined PK_INLINE_GAUSS && !defined PK_MODEL_WITHOUT_LANES
                PK_GAUSS_METHODS(PK_INLINED_GAUSS_ENTRY)
#endif
#if defined PK_INLINE_TAYLOR && defined PK_MODEL_JET
                    PK_TAYLOR_METHODS(PK_INLINED_ENTRY)
#endif
                        {NULL, NULL}};
#else
#define PK_INLINE_STEPPERS NULL
#endif

#if defined PK_INLINE_ENSEMBLE && !defined PK_MODEL_WITHOUT_MEMBERS
#define PK_INLINE_BLOCK_STEPPERS PK_STEPPER(block_steppers)
static unsigned long long PK_STEPPER(members)(const pk_real *P, const pk_real *t, const pk_real *q,
                                              const pk_real *v, const pk_real *u, pk_real *a)
{
    return PK_MODEL(members_inline)(PK_INLINE_LANES, P, t, q, v, u, a);
}
#include <pk/step/ensemble.h>
static unsigned long long PK_STEPPER(block_members)(struct pk_block *b, const pk_real *q,
                                                    const pk_real *v, pk_real *a)
{
    return PK_BLOCK_MEMBERS(b, q, v, a);
}
#ifndef PK_MODEL_EVENTS
#define PK_MODEL_EVENTS 0
#define PK_MODEL_EVENTS_UNKNOWN
#endif
#ifndef PK_MODEL_SWITCHES
#define PK_MODEL_SWITCHES 0
#define PK_MODEL_SWITCHES_UNKNOWN
#endif
#if PK_MODEL_EVENTS + PK_MODEL_SWITCHES > 0
#define PK_INLINED_VALUES PK_STEPPER(block_values)
static void PK_STEPPER(block_values)(const struct pk_block *b, const pk_real *q, const pk_real *v,
                                     pk_real *PK_RESTRICT g)
{
    const size_t n_q = PK_BLOCK_COORDINATES(b), n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b);
    const size_t m = PK_MODEL(INPUTS);
    for (size_t l = 0; l < W; l++) {
        const struct PK_MODEL(params) *p = (const struct PK_MODEL(params) *)b->params[l];
        pk_real x[2 * PK_MODEL(N)], u[PK_MODEL(INPUTS) + 1], y[PK_MODEL_EVENTS + PK_MODEL_SWITCHES];
        for (size_t i = 0; i < n_q; i++)
            x[i] = q[i * W + l];
        for (size_t i = 0; i < n; i++)
            x[n_q + i] = v[i * W + l];
        for (size_t i = 0; i < m; i++)
            u[i] = b->u[i * W + l];
#ifndef PK_MODEL_EVENTS_UNKNOWN
        PK_MODEL(event)(p, b->t[l], x, x + n_q, u, y);
#endif
#ifndef PK_MODEL_SWITCHES_UNKNOWN
        PK_MODEL(switching)(p, b->t[l], x, x + n_q, u, y + PK_MODEL_EVENTS);
#endif
        for (size_t i = 0; i < PK_MODEL_EVENTS + PK_MODEL_SWITCHES; i++)
            g[i * W + l] = y[i];
    }
}
#else
#define PK_INLINED_VALUES NULL
#endif
#ifdef PK_MODEL_EVENTS_UNKNOWN
#undef PK_MODEL_EVENTS
#undef PK_MODEL_EVENTS_UNKNOWN
#endif
#ifdef PK_MODEL_SWITCHES_UNKNOWN
#undef PK_MODEL_SWITCHES
#undef PK_MODEL_SWITCHES_UNKNOWN
#endif
#ifdef PK_INLINE_ERK
PK_ERK_METHODS(PK_INLINED_BLOCK_RUNGE_KUTTA)
#endif
#ifdef PK_INLINE_EMBEDDED
PK_EMBEDDED_METHODS(PK_INLINED_BLOCK_EMBEDDED)
#endif
#ifdef PK_INLINE_SPLITTING
PK_SPLITTING_METHODS(PK_INLINED_BLOCK_SPLITTING)
#endif
#ifdef PK_MODEL_JET_WIDE
/* Coefficients of a few states only, so that they fit into the L1 cache. */
enum { PK_STEPPER(jet_lanes) = 16 };
static unsigned long long PK_STEPPER(block_jets)(struct pk_block *b)
{
    unsigned long long failed = 0;
    for (size_t l = 0; l < PK_STEPPER(jet_lanes); l += PK_WIDE)
        failed |= (unsigned long long)PK_MODEL(jet_wide)(PK_STEPPER(jet_lanes), b->P + l, b->t + l,
                                                         b->state + l, b->order, b->work + l)
                  << l;
    return failed;
}
#define PK_INLINED_BLOCK_ENTRY_TAYLOR(method) \
    {#method, PK_STEPPER(jet_lanes), NULL, PK_STEPPER(block_jets), NULL, NULL},
#endif
static const struct pk_block_stepper PK_STEPPER(block_steppers)[] = {
#ifdef PK_INLINE_ERK
    PK_ERK_METHODS(PK_INLINED_BLOCK_ENTRY)
#endif
#ifdef PK_INLINE_EMBEDDED
        PK_EMBEDDED_METHODS(PK_INLINED_BLOCK_ENTRY_EMBEDDED)
#endif
#ifdef PK_INLINE_SPLITTING
            PK_SPLITTING_METHODS(PK_INLINED_BLOCK_ENTRY)
#endif
#ifdef PK_MODEL_JET_WIDE
                PK_TAYLOR_METHODS(PK_INLINED_BLOCK_ENTRY_TAYLOR)
#undef PK_INLINED_BLOCK_ENTRY_TAYLOR
#endif
                    {NULL, 0, NULL, NULL, NULL, NULL}};
#undef PK_INLINED_VALUES
#else
#define PK_INLINE_BLOCK_STEPPERS NULL
#endif
