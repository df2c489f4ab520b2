/* Linear complementarity problems of contacts and frictions,
 *
 *     y = A x + b.
 *
 * A row that always holds has y = 0. Of a contact, x >= 0, y >= 0 and x y = 0. Friction has y = 0 up
 * to |x| = S + s x_n, and beyond slips with x = -(F + f x_n) against the sign of y, where x_n is the
 * x of its contact. A row that is out has x = 0. */
#ifndef PK_COMPLEMENT_H
#define PK_COMPLEMENT_H

#include "act.h"

#define PK_COMPLEMENT_ROUND (PK_C(1e3) * PK_EPS)

enum pk_complement_kind { PK_OUT, PK_EQUAL, PK_PUSH, PK_RUB, PK_SLIP };

struct pk_complement {
    size_t c;
    const pk_real *A, *b;
    pk_real *x, *B;
    enum pk_complement_kind kind[PK_MOST_ROWS];
    int state[PK_MOST_ROWS];                  /* 1: holds; 0: open; 2, -2: slips */
    size_t of[PK_MOST_ROWS];                  /* row of the contact that bounds it, or c */
    pk_real F[PK_MOST_ROWS], f[PK_MOST_ROWS]; /* bound while it slips */
    pk_real S[PK_MOST_ROWS], s[PK_MOST_ROWS]; /* bound while it holds */
    const pk_real *least;                     /* rounding error of each y */
};

/* Finds x, from the given states on. Returns 0 if there is no solution. */
int pk_complement(struct pk_complement *p);
/* Returns y_i, and in *size the sum of the magnitudes of its terms. */
pk_real pk_complement_result(const struct pk_complement *p, size_t i, pk_real *size);
/* Returns the x of the contact that bounds a friction, or 0. */
static inline pk_real pk_complement_push(const struct pk_complement *p, size_t row)
{
    return p->of[row] < p->c ? p->x[p->of[row]] : 0;
}

#endif
