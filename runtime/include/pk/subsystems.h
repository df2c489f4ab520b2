/* Integrates independent blocks (parts) of a system's coordinates separately, each with its own
 * method, step size or tolerance. The whole system gives names, outputs and energy.
 *
 *     size_t size = pk_subsystems_size(&whole, parts, choices, count);
 *     pk_subsystems_init(&apart, &whole, parts, choices, count, t0, q0, v0, block, size);
 *     status = pk_subsystems_to(&apart, t, t);                        apart.t, apart.q, apart.v
 *
 * A part has its own parameters. They have the values of the whole system's parameters of the same
 * name; other parameters have their defaults. Inputs are also matched by name. Each coordinate of
 * the whole system is in exactly one part. */
#ifndef PK_SUBSYSTEMS_H
#define PK_SUBSYSTEMS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* A part: its own system; for each coordinate and first-order variable of the part, `coordinates`
 * has its index in the whole system. */
struct pk_part {
    const struct pk_system *system;
    const size_t *coordinates;
};

/* The method and options of a part. */
struct pk_choice {
    const struct pk_method *method;
    struct pk_options options;
};

/* A part during integration; read-only for callers. */
struct pk_subsystem {
    struct pk_part of;
    /* it: the integrator of the part; aside: a second one, for states within the steps of `it` */
    struct pk_integrator it, aside;
    const struct pk_integrator *there; /* `it` or `aside`, whichever is at the common time */
    void *params;
    const struct pk_subsystems *apart;
    size_t *inputs; /* indices of the part's inputs in the whole system */
    pk_real *u;     /* inputs of the whole system at the current time */
};

struct pk_subsystems {
    /* Read-only for callers: the time and state that all parts have reached. */
    pk_real t;
    const pk_real *q, *v;
    enum pk_status status; /* status of the last call */
    size_t failed;         /* 1 + index of the part whose failure is `status`; 0: no part failed */
    struct pk_subsystem *parts;
    size_t count;
    /* NULL, or a function that the caller sets after init: it is called after each step, with the
     * number k of the part that made it. */
    void (*stepped)(void *context, size_t k);
    void *context;

    /* Private to the runtime. */
    struct pk_problem whole;
    pk_real *state;
    const char *why; /* why an argument was refused */
};

/* Returns the bytes of the block for pk_subsystems_init(), aligned as malloc() aligns; 0 if an
 * argument is null, a system has another PK_ABI, or a part has a variable size. */
size_t pk_subsystems_size(const struct pk_problem *whole, const struct pk_part *parts,
                          const struct pk_choice *choices, size_t count);
/* Copies q0 and v0. All other arguments must outlive the struct, which must not move. Fails with
 * PK_BAD_ARGUMENT if the parts' coordinates are not those of the whole, or a part's first
 * failure. */
enum pk_status pk_subsystems_init(struct pk_subsystems *apart, const struct pk_problem *whole,
                                  const struct pk_part *parts, const struct pk_choice *choices,
                                  size_t count, pk_real t0, const pk_real *q0, const pk_real *v0,
                                  void *block, size_t block_size);
/* Integrates each part to t in turn. Fixed steps are not shortened to end at t, only to end at
 * `limit`; the state at t is computed within the step. If a part fails, the state remains at the
 * last t that all parts reached, though parts before it have been integrated to the new t, and
 * later calls make no step. */
enum pk_status pk_subsystems_to(struct pk_subsystems *apart, pk_real t, pk_real limit);
/* Writes the last status as text, with the part's coordinates and last valid time. Returns the
 * length as snprintf() does. */
int pk_subsystems_reason(const struct pk_subsystems *apart, char *text, size_t size);
/* Frees memory. Needed only after methods that allocate (GSL's). */
void pk_subsystems_free(struct pk_subsystems *apart);

PK_END

#endif
