/* The part of a system (pk/system.h) with families kept as loops. A family is an indexed name, such
 * as q[1..N]; its kernels may be loops over the members, so that N is known only at run time. */
#ifndef PK_SYSTEM_FAMILIES_H
#define PK_SYSTEM_FAMILIES_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* A size, such as N: the length of families; a ptrdiff_t at byte `offset` of struct NAME_params. */
struct pk_size {
    struct pk_quantity what;
    size_t offset;
};

/* The members of a declared name: indices lo, lo + 1, ...; count is 1 if it is no family. */
enum pk_range_of { PK_OF_COORDINATE, PK_OF_PARAMETER, PK_OF_ROW, PK_OF_OUTPUT };
struct pk_range {
    ptrdiff_t lo;
    size_t count;
    int is_family;
};

/* The place of a rotation in v: index of its first body rate and of the first component of its
 * quaternion. The other components follow at distance `step`. */
struct pk_turning {
    size_t rate, number, step;
};

/* Sparsity pattern of a Jacobian by coordinates or rates: `rows` rows of a band with `width`
 * entries on either side of the diagonal, then `border` dense rows and columns. Storage: rows * (2
 * width + 1), band rows with the diagonal in the middle; rows * border, the border's columns row by
 * row; rows * border, the border's rows column by column; border * border. */
struct pk_pattern {
    size_t rows, width, border;
    int dense; /* index i is coordinate i, and all of them are in the border */
};

/* Families kept as loops. Then pk_system.n is n at the default sizes; coordinates, rates, momenta
 * and parameters have one entry for each declared name (q for q[1..N]); `cyclic`, mass and jacobian
 * of pk_system are NULL; the offset of a family of parameters is that of a pointer to its members.
 * Before defaults(), call set_sizes(), set other sizes if wanted, and call attach() with a block of
 * block_size() bytes, aligned for pk_real (0: none needed, or a size is too small). */
struct pk_part_families {
    size_t (*count)(const void *params); /* length of v; NULL: pk_system.n */
    size_t n_sizes;
    const struct pk_size *sizes;
    void (*set_sizes)(void *params);
    size_t (*block_size)(const void *params);
    void (*attach)(void *params, void *block);
    size_t n_coordinates; /* declared names; the last n_states are body rates and states */
    size_t n_states;
    size_t (*first_order)(const void *params); /* NULL: pk_system.n_first_order */
    /* The number of rotations, and the place of rotation r; NULL: there are none. */
    size_t (*rotations)(const void *params);
    struct pk_turning (*turning)(const void *params, size_t r);
    /* The number of outputs, if some have a value for each index: n_observed is then their number
     * at the default sizes, and `observed` has n_outputs names. NULL: n_observed. */
    size_t (*outputs)(const void *params);
    size_t n_outputs;
    /* Writes the members of declared coordinate, parameter, constraint or output number k. */
    void (*range)(const void *params, enum pk_range_of of, size_t k, struct pk_range *range);
    /* Makes `steps` steps of size h of a splitting method in place, in as few passes over memory as
     * possible: kicks v += kick[i] h a(q, t), i = 0 .. stages, and drifts q += drift[i] h v between
     * them. Sums are not compensated. NULL: not compiled in. */
    void (*advance)(const void *params, int stages, const pk_real *kick, const pk_real *drift,
                    pk_real t, pk_real h, unsigned long steps, pk_real *q, pk_real *v);
    /* diagonal: the diagonal of M. factor: factors M in the memory of params and fails as
     * acceleration() does. solve: solves M d = f. The last two are NULL if M is diagonal or
     * constraints.factor includes it. */
    pk_kernel *diagonal;
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u);
    void (*solve)(const void *params, const pk_real *f, pk_real *d);
    /* M and the Jacobians of pk_system.jacobian, stored by a pattern; NULL: none. place() returns
     * the coordinate at index i of the pattern, or a negative number: then M is 1 there, or has
     * rows that relate rates to each other. If p' depends on multipliers or accelerations, or p and
     * p' on sums over many members, Jacobians would be dense. Then these are unknowns too, at
     * indices without a coordinate. `closed` writes M and the derivatives of the equations for them
     * by rates and by themselves. */
    void (*pattern)(const void *params, struct pk_pattern *pattern);
    ptrdiff_t (*place)(const void *params, size_t i);
    pk_kernel *mass;
    pk_kernel *closed; /* NULL: there are no such unknowns */
    pk_kernel_3 *jacobian;
};

PK_END

#endif
