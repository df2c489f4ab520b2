/* Independent blocks of coordinates, each integrated by itself: by a method, a step or a tolerance
 * of its own. The whole is a pk_system too, for names, outputs and energy; it is not integrated.
 *
 *     size_t size = pk_apart_size(&whole, parts, choices, count);
 *     pk_apart_init(&apart, &whole, parts, choices, count, t0, q0, v0, block, size);
 *     status = pk_apart_to(&apart, t, t);                        apart.t, apart.q, apart.v
 *
 * A part has its own parameters: each takes the value of that of the whole which has its name, and
 * the rest are its defaults or follow. So too its inputs. A coordinate of the
 * whole is in one part.
 */
#ifndef PK_APART_H
#define PK_APART_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* A block: its own system, and where its coordinates and states, system->n, are in those of the
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

/* A part at work; to be read alone. */
struct pk_apart_part {
    struct pk_part of;
    struct pk_integrator it, aside;    /* see pk_integrator_aside() */
    const struct pk_integrator *there; /* of these, at the time of the whole */
    void *params;
    const struct pk_apart *apart;
    size_t *inputs; /* where they are in those of the whole */
    pk_real *u;     /* inputs of the whole */
};

struct pk_apart {
    /* To be read by the caller: where all parts are. */
    pk_real t;
    const pk_real *q, *v;
    enum pk_status status; /* of the last call */
    size_t failed;         /* 1 + the part that it is about, 0: none */
    struct pk_apart_part *parts;
    size_t count;
    /* To be set behind init, or NULL: called after each step of part number k. */
    void (*stepped)(void *context, size_t k);
    void *context;

    /* For the runtime alone. */
    struct pk_problem whole;
    pk_real *state;
    const char *why; /* of a bad argument */
};

/* Bytes of the block that pk_apart_init() wants, aligned as malloc's are; 0 where an argument is
 * null, a system is of another PK_ABI, or a part keeps its families as loops. */
size_t pk_apart_size(const struct pk_problem *whole, const struct pk_part *parts,
                     const struct pk_choice *choices, size_t count);
/* Copies q0 and v0; the rest must outlive it, and the struct must not move. PK_BAD_ARGUMENT where
 * the parts are not the whole; else the first status that is not PK_DONE of a part's init. */
enum pk_status pk_apart_init(struct pk_apart *apart, const struct pk_problem *whole,
                             const struct pk_part *parts, const struct pk_choice *choices,
                             size_t count, pk_real t0, const pk_real *q0, const pk_real *v0,
                             void *block, size_t block_size);
/* Integrates each part to t in turn. Fixed steps may pass t; only `limit` shortens them.
 * Where one fails the state stays at the last t that all reached; parts before it are at t already,
 * and no later call makes a step. */
enum pk_status pk_apart_to(struct pk_apart *apart, pk_real t, pk_real limit);
/* The last status in words, with the part's coordinates and its last valid time. Returns its length
 * as snprintf() does. */
int pk_apart_reason(const struct pk_apart *apart, char *text, size_t size);
/* Needed for methods that allocate (GSL's), harmless for others. */
void pk_apart_free(struct pk_apart *apart);

PK_END

#endif
