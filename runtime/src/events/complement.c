/* Murty's least-index pivots: each changes the state of the first row that is wrong, see
 * complement.h.
 * Reference: K. G. Murty, Linear Complementarity, Linear and Nonlinear Programming, 1988, section
 * 4.1. */
#include "complement.h"

enum { PIVOTS = 1000, MOST_TRIED = 100000 };
#define ROUND PK_COMPLEMENT_ROUND

/* Solves for x by Gauss's elimination; an x that the rows do not determine is 0. */
static void solve(const struct pk_complement *p)
{
    const size_t c = p->c, n = c + 1;
    pk_real *B = p->B;
    size_t place[PK_MOST_ROWS];
    for (size_t i = 0; i < c; i++) {
        pk_real *row = B + i * n;
        const int in = p->kind[i] != PK_OUT && p->state[i] == 1;
        const int slip = p->kind[i] >= PK_RUB && (p->state[i] == 2 || p->state[i] == -2);
        pk_zero(row, n);
        if (in) {
            pk_copy(row, p->A + i * c, c);
            row[c] = -p->b[i];
            continue;
        }
        const pk_real side = p->state[i] > 0 ? 1 : -1;
        row[i] = 1;
        row[c] = slip ? -side * p->F[i] : 0;
        if (slip && p->of[i] < c)
            row[p->of[i]] = side * p->f[i];
    }
    for (size_t k = 0; k < c; k++) { /* each row is divided by its largest entry */
        const pk_real size = pk_largest(B + k * n, c);
        for (size_t j = 0; j < n; j++)
            B[k * n + j] /= size > 0 ? size : 1;
    }
    size_t used = 0;
    for (size_t k = 0; k < c; k++) {
        size_t best = used;
        place[k] = c;
        for (size_t i = used; i < c; i++)
            if (pk_abs(B[i * n + k]) > pk_abs(B[best * n + k]))
                best = i;
        if (used == c || !(pk_abs(B[best * n + k]) > ROUND))
            continue;
        for (size_t j = 0; j < n; j++) {
            const pk_real swap = B[used * n + j];
            B[used * n + j] = B[best * n + j];
            B[best * n + j] = swap;
        }
        for (size_t i = 0; i < c; i++)
            if (i != used)
                pk_add(B + i * n, -B[i * n + k] / B[used * n + k], B + used * n, n);
        place[k] = used++;
    }
    for (size_t k = 0; k < c; k++)
        p->x[k] = place[k] < c ? B[place[k] * n + c] / B[place[k] * n + k] : 0;
}

pk_real pk_complement_result(const struct pk_complement *p, size_t i, pk_real *size)
{
    pk_real sum = p->b[i];
    *size = pk_abs(sum);
    for (size_t j = 0; j < p->c; j++) {
        sum += p->A[i * p->c + j] * p->x[j];
        *size += pk_abs(p->A[i * p->c + j] * p->x[j]);
    }
    return sum;
}

/* Changes the state of row i if it is wrong, and returns whether it was: also if others lead off a
 * row that holds. */
static int turn(struct pk_complement *p, size_t i, pk_real round)
{
    pk_real size;
    const pk_real y = pk_complement_result(p, i, &size), x = p->x[i];
    const pk_real bound = p->S[i] + p->s[i] * pk_complement_push(p, i);
    const pk_real least = ROUND * size + p->least[i];
    const int was = p->state[i], off = was == 1 && p->kind[i] >= PK_PUSH && pk_abs(y) > least;
    round += p->least[i] / p->A[i * p->c + i];
    if (p->kind[i] == PK_PUSH && was == 1 && (x < -round || (off && y > 0)))
        p->state[i] = 0;
    else if (p->kind[i] == PK_PUSH && was == 0 && y < -least)
        p->state[i] = 1;
    else if (p->kind[i] == PK_RUB && was == 1 && (off || pk_abs(x) > bound + round))
        p->state[i] = (off ? y < 0 : x > 0) ? -2 : 2;
    else if (p->kind[i] == PK_RUB && was != 1 && (was > 0 ? -y : y) > least)
        p->state[i] = 1;
    return off || p->state[i] != was;
}

/* Solves for x, and changes the state of the first row that is wrong. Returns whether none was. */
static int pivot(struct pk_complement *p)
{
    size_t i = 0;
    solve(p);
    const pk_real round = ROUND * pk_largest(p->x, p->c);
    while (i < p->c && !turn(p, i, round))
        i++;
    return i == p->c;
}

/* Tries all states, those that hold first. */
static int search(struct pk_complement *p)
{
    unsigned long all = 1;
    for (size_t i = 0; i < p->c; i++) {
        all *= p->kind[i] == PK_PUSH ? 2 : p->kind[i] == PK_RUB ? 3 : 1;
        if (all > MOST_TRIED)
            return 0;
    }
    for (unsigned long number = 0; number < all; number++) {
        unsigned long rest = number;
        for (size_t i = 0; i < p->c; i++) {
            static const int ways[] = {1, 2, -2};
            if (p->kind[i] == PK_PUSH)
                p->state[i] = rest % 2 == 0, rest /= 2;
            else if (p->kind[i] == PK_RUB)
                p->state[i] = ways[rest % 3], rest /= 3;
        }
        if (pivot(p))
            return 1;
    }
    return 0;
}

/* Returns whether a solution is found. Pivots may go round where rows depend on each other. */
int pk_complement(struct pk_complement *p)
{
    for (int count = 0; count < PIVOTS; count++)
        if (pivot(p))
            return 1;
    return search(p);
}
