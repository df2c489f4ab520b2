/* The part of struct pk_system (pk/system.h) for systems of variable size. A family is an indexed
 * name, such as q[1..N]; if kernels are loops ("kept as loops"), N is chosen at run time. */
#ifndef PK_SYSTEM_FAMILIES_H
#define PK_SYSTEM_FAMILIES_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* A size such as N, the length of families; a ptrdiff_t at byte `offset` of struct NAME_params. */
struct pk_size {
    struct pk_quantity what;
    size_t offset;
};

/* The index range of a declared name: lo, lo + 1, ...; count is 1 if the name has no index. */
enum pk_range_of { PK_OF_COORDINATE, PK_OF_PARAMETER, PK_OF_ROW, PK_OF_OUTPUT };
struct pk_range {
    ptrdiff_t lo;
    size_t count;
    int is_family;
};

/* Indices in v of the numbers of a rotation. `rate` is the index of its first body rate, `number`
 * that of the first component of its quaternion; further components follow at distances `step`. */
struct pk_turning {
    size_t rate, number, step;
};

/* Sparsity pattern of a Jacobian by coordinates or rates: `rows` rows of a band with `width`
 * entries on either side of the diagonal, then `border` dense rows and columns. The numbers are
 * stored in four groups: rows * (2 * width + 1) numbers of the rows of the band, each with the
 * diagonal in its middle; rows * border numbers of the columns of the border, row by row; rows *
 * border numbers of the rows of the border, by columns; and border^2 numbers where both meet. */
struct pk_pattern {
    size_t rows, width, border;
    int dense; /* 1: the matrix has no band; all coordinates, in order, belong to the border */
};

/* If a system has variable size, pk_system.n is n at the default sizes; coordinates, rates, momenta
 * and parameters have one entry for each declared name (q for q[1..N]); `cyclic`, mass and jacobian
 * of pk_system are NULL; the offset of an indexed parameter is that of a pointer to its members.
 * Before defaults(), call set_sizes(), set other sizes if wanted, and call attach() with a block of
 * block_size() bytes, aligned for pk_real (0: no block is needed, or a size is too small). */
struct pk_part_families {
    /* Returns the length of v. NULL: the length is pk_system.n. */
    size_t (*count)(const void *params);
    size_t n_sizes;
    const struct pk_size *sizes;
    void (*set_sizes)(void *params);
    size_t (*block_size)(const void *params);
    void (*attach)(void *params, void *block);
    /* number of declared names of coordinates and, the last n_states, of first-order variables */
    size_t n_coordinates;
    size_t n_states;
    size_t (*first_order)(const void *params); /* NULL: use pk_system.n_first_order */
    /* rotations() returns the number of rotations, turning() the indices of rotation r in v. Both
     * are NULL if there are no rotations. */
    size_t (*rotations)(const void *params);
    struct pk_turning (*turning)(const void *params, size_t r);
    /* Returns the number of outputs, if some declared outputs have a value for each member of a
     * family. In this case n_observed is the number of outputs at the default sizes, and `observed`
     * has n_outputs declared names. NULL: the number of outputs is n_observed. */
    size_t (*outputs)(const void *params);
    size_t n_outputs;
    /* Writes the index range of declared coordinate, parameter, constraint or output number k. */
    void (*range)(const void *params, enum pk_range_of of, size_t k, struct pk_range *range);
    /* Makes `steps` steps of size h of a splitting method, in place and in as few passes over
     * memory as possible: kicks v += kick[i] h a(q, t), i = 0 .. stages, with drifts q += drift[i]
     * h v between successive kicks. Sums are not compensated. NULL: not compiled in. */
    void (*advance)(const void *params, int stages, const pk_real *kick, const pk_real *drift,
                    pk_real t, pk_real h, unsigned long steps, pk_real *q, pk_real *v);
    /* diagonal() writes the diagonal of M. factor() factors M and stores the factors in the memory
     * of params; it fails like acceleration(). solve() then solves M d = f. factor and solve are
     * NULL if M is diagonal or constraints.factor factors it. */
    pk_kernel *diagonal;
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u);
    void (*solve)(const void *params, const pk_real *f, pk_real *d);
    /* The matrix M, and the Jacobians that pk_system.jacobian would write, stored according to a
     * sparsity pattern. NULL: these kernels were not compiled. place() returns the coordinate at
     * index i of the pattern. It returns a negative number for an additional unknown, such as a
     * multiplier, an acceleration or a sum over many members, without which the Jacobians would be
     * dense; the diagonal entry of M is then 1, or its row relates rates to each other. closed()
     * writes M and, for the equations of the additional unknowns, derivatives by rates and them. */
    void (*pattern)(const void *params, struct pk_pattern *pattern);
    ptrdiff_t (*place)(const void *params, size_t i);
    pk_kernel *mass;
    pk_kernel *closed; /* NULL if there are no additional unknowns */
    pk_kernel_3 *jacobian;
};

PK_END

#endif
