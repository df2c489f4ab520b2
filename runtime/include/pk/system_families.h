/* The part of a system (pk/system.h) whose families are kept as loops. */
#ifndef PK_SYSTEM_FAMILIES_H
#define PK_SYSTEM_FAMILIES_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* The length of families, in struct NAME_params: a ptrdiff_t. */
struct pk_size {
    struct pk_quantity what;
    size_t offset;
};

/* The members of a declared name: lo, lo + 1, ...; or it is no family, and count is 1. */
enum pk_range_of { PK_OF_COORDINATE, PK_OF_PARAMETER, PK_OF_ROW, PK_OF_OUTPUT };
struct pk_range {
    ptrdiff_t lo;
    size_t count;
    int is_family;
};

/* Where a rotation is in v: its first body rate and the first number of its quaternion; the others
 * are `step` apart each. */
struct pk_turning {
    size_t rate, number, step;
};

/* A matrix of derivatives by coordinates or rates: `rows` of a band that reaches `width` places to
 * either side, then `border` places whole. Its numbers: rows * (2 width + 1), the diagonal of a row
 * in the middle; rows * border, the border's columns by rows; rows * border, the border's rows by
 * columns; border * border. */
struct pk_pattern {
    size_t rows, width, border;
    int dense; /* places are coordinates, all of them in the border */
};

/* Families kept as loops. pk_system.n is then the count at the default sizes; coordinates, rates,
 * momenta and parameters have an entry for each declared name (q for q[1..N]), `cyclic` is NULL,
 * mass and jacobian are, and the offset of a family of parameters is that of a pointer to its
 * members. Before defaults(): set_sizes() and any sizes of one's own, then attach() with
 * block_size() bytes, aligned for pk_real (0: none needed, or a size is too small). */
struct pk_part_families {
    size_t (*count)(const void *params); /* degrees of freedom; NULL: pk_system.n */
    size_t n_sizes;
    const struct pk_size *sizes;
    void (*set_sizes)(void *params);
    size_t (*block_size)(const void *params);
    void (*attach)(void *params, void *block);
    size_t n_coordinates; /* declared names; the last n_states are of body rates and states */
    size_t n_states;
    size_t (*first_order)(const void *params); /* NULL: pk_system.n_first_order */
    /* How many rotations there are and where each is; NULL: there are none. */
    size_t (*rotations)(const void *params);
    struct pk_turning (*turning)(const void *params, size_t r);
    /* How many outputs there are, where some have a value for each index: n_observed is then their
     * count at the default sizes, and the table has n_outputs names. NULL: n_observed. */
    size_t (*outputs)(const void *params);
    size_t n_outputs;
    /* The members of declared coordinate, parameter, constraint or output number k. */
    void (*range)(const void *params, enum pk_range_of of, size_t k, struct pk_range *range);
    /* `steps` steps of h of a splitting method in place, in as few passes over memory as can be:
     * kicks v += kick[i] h a(q, t), i = 0 .. stages, and drifts q += drift[i] h v between them.
     * Uncompensated. NULL: there is none. */
    void (*advance)(const void *params, int stages, const pk_real *kick, const pk_real *drift,
                    pk_real t, pk_real h, unsigned long steps, pk_real *q, pk_real *v);
    /* For what solves by M: its diagonal; and where it is more, and there are no constraints, whose
     * factor() has it: M factored in the memory of params, as acceleration() fails, and M d = f. */
    pk_kernel *diagonal;
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u);
    void (*solve)(const void *params, const pk_real *f, pk_real *d);
    /* M, and what pk_system.jacobian has, of a pattern; NULL: there are none. place() is the
     * coordinate that has place i, negative where there is none: M is 1 there, or it has rows that
     * say how rates depend on each other. Where p' has multipliers or accelerations in it, or both
     * depend on what is made of many members, derivatives are dense; these are unknowns too then,
     * places that are no coordinates, and `closed` has M and the derivatives of the equations for
     * them by rates and by themselves. */
    void (*pattern)(const void *params, struct pk_pattern *pattern);
    ptrdiff_t (*place)(const void *params, size_t i);
    pk_kernel *mass;
    pk_kernel *closed; /* NULL: there are no such unknowns */
    pk_kernel_3 *jacobian;
};

PK_END

#endif
