/* Independent blocks of coordinates, each integrated by itself, with its own method, step size or
 * tolerance. The whole is a pk_system too, for names, outputs and energy; it is not integrated.
 *
 *     size_t size = pk_subsystems_size(&whole, parts, choices, count);
 *     pk_subsystems_init(&apart, &whole, parts, choices, count, t0, q0, v0, block, size);
 *     status = pk_subsystems_to(&apart, t, t);                        apart.t, apart.q, apart.v
 *
 * A part has its own parameters. Each takes the value of the whole's parameter of the same name;
 * the others have their defaults or follow. Inputs likewise. Each coordinate of the whole is in
 * exactly one part.
 */
#ifndef PK_SUBSYSTEMS_H
#define PK_SUBSYSTEMS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* A block: its system, and for each of its system->n coordinates and states the index in the
 * whole. */
struct pk_part {
    const struct pk_system *system;
    const size_t *coordinates;
};

/* How a part is integrated. */
struct pk_choice {
    const struct pk_method *method;
    struct pk_options options;
};

/* A part during integration; read only. */
struct pk_subsystem {
    struct pk_part of;
    struct pk_integrator it, aside;    /* see pk_integrator_aside() */
    const struct pk_integrator *there; /* `it` or `aside`: the one at the time of the whole */
    void *params;
    const struct pk_subsystems *apart;
    size_t *inputs; /* indices of its inputs in the whole */
    pk_real *u;     /* inputs of the whole */
};

struct pk_subsystems {
    /* To be read by the caller: the time and state that all parts have reached. */
    pk_real t;
    const pk_real *q, *v;
    enum pk_status status; /* of the last call */
    size_t failed;         /* 1 + the part that the status is about, 0: none */
    struct pk_subsystem *parts;
    size_t count;
    /* To be set after init, or NULL: called after each step of part number k. */
    void (*stepped)(void *context, size_t k);
    void *context;

    /* For the runtime alone. */
    struct pk_problem whole;
    pk_real *state;
    const char *why; /* why an argument is bad */
};

/* Returns the bytes of the block for pk_subsystems_init(), aligned as malloc's are; 0 if an argument is
 * null, a system has another PK_ABI, or a part has families kept as loops. */
size_t pk_subsystems_size(const struct pk_problem *whole, const struct pk_part *parts,
                          const struct pk_choice *choices, size_t count);
/* Copies q0 and v0. All other arguments must outlive the struct, which must not move.
 * PK_BAD_ARGUMENT if the parts do not make up the whole, or the first failure of a part. */
enum pk_status pk_subsystems_init(struct pk_subsystems *apart, const struct pk_problem *whole,
                                  const struct pk_part *parts, const struct pk_choice *choices,
                                  size_t count, pk_real t0, const pk_real *q0, const pk_real *v0,
                                  void *block, size_t block_size);
/* Integrates each part to t in turn. Fixed steps may pass t; only `limit` shortens them. If a part
 * fails, the state stays at the last t that all parts reached, parts before it have reached the new
 * t, and no later call makes a step. */
enum pk_status pk_subsystems_to(struct pk_subsystems *apart, pk_real t, pk_real limit);
/* Writes the last status in words, with the part's coordinates and its last valid time. Returns the
 * length as snprintf() does. */
int pk_subsystems_reason(const struct pk_subsystems *apart, char *text, size_t size);
/* Needed after methods that allocate (GSL's), harmless after others. */
void pk_subsystems_free(struct pk_subsystems *apart);

PK_END

#endif
