/* Impulses at closed gaps, and which contacts and frictions hold: linear complementarity problems
 *
 *     y = A x + b,   A = J M^-1 J^T,
 *
 * where x are impulses and y rates, or x multipliers and y accelerations of the rows. A row that
 * always holds has y = 0. Of a contact, x >= 0, y >= 0 and x y = 0. Friction has y = 0 up to
 * |x| = S + s x_n, and beyond slips with x = -(F + f x_n) against the sign of y, where x_n is the
 * multiplier of its contact. Each pivot changes the state of the first row that is wrong. */
#include <math.h>

#include "act.h"

enum kind { OUT, EQUAL, PUSH, RUB, SLIP };
enum { PIVOTS = 1000, MOST_TRIED = 100000 };
#define ROUND (PK_C(1e3) * PK_EPS)
/* two orders of impacts agree if they differ by less than this fraction of the rates */
#define AGREE PK_C(1e-8)

struct problem {
    size_t c;
    const pk_real *A, *b;
    pk_real *x, *B;
    enum kind kind[PK_MOST_ROWS];
    int state[PK_MOST_ROWS];                  /* 1: holds; 0: open; 2, -2: slips */
    size_t of[PK_MOST_ROWS];                  /* row of the contact that bounds it, or c */
    pk_real F[PK_MOST_ROWS], f[PK_MOST_ROWS]; /* bound while it slips */
    pk_real S[PK_MOST_ROWS], s[PK_MOST_ROWS]; /* bound while it holds */
    const pk_real *least;                     /* rounding error of each y */
};

static pk_real push(const struct problem *p, size_t row)
{
    return p->of[row] < p->c ? p->x[p->of[row]] : 0;
}

/* Solves for x by Gauss's elimination; an x that the rows do not determine is 0. */
static void solve(const struct problem *p)
{
    const size_t c = p->c, n = c + 1;
    pk_real *B = p->B;
    size_t place[PK_MOST_ROWS];
    for (size_t i = 0; i < c; i++) {
        pk_real *row = B + i * n;
        const int in = p->kind[i] != OUT && p->state[i] == 1;
        const int slip = p->kind[i] >= RUB && (p->state[i] == 2 || p->state[i] == -2);
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

static pk_real result(const struct problem *p, size_t i, pk_real *size)
{
    pk_real sum = p->b[i];
    *size = pk_abs(sum);
    for (size_t j = 0; j < p->c; j++) {
        sum += p->A[i * p->c + j] * p->x[j];
        *size += pk_abs(p->A[i * p->c + j] * p->x[j]);
    }
    return sum;
}

/* Changes the state of row i if it is wrong, and returns whether it was. */
static int turn(struct problem *p, size_t i, pk_real round)
{
    pk_real size;
    const pk_real y = result(p, i, &size), x = p->x[i];
    const pk_real bound = p->S[i] + p->s[i] * push(p, i);
    const pk_real least = ROUND * size + p->least[i];
    const int was = p->state[i];
    round += p->least[i] / p->A[i * p->c + i];
    if (p->kind[i] == PUSH && was == 1 && x < -round)
        p->state[i] = 0;
    else if (p->kind[i] == PUSH && was == 0 && y < -least)
        p->state[i] = 1;
    else if (p->kind[i] == RUB && was == 1 && pk_abs(x) > bound + round)
        p->state[i] = x > 0 ? -2 : 2;
    else if (p->kind[i] == RUB && was != 1 && (was > 0 ? -y : y) > least)
        p->state[i] = 1;
    return p->state[i] != was;
}

/* Solves for x, and changes the state of the first row that is wrong. Returns whether none was. */
static int pivot(struct problem *p)
{
    size_t i = 0;
    solve(p);
    const pk_real round = ROUND * pk_largest(p->x, p->c);
    while (i < p->c && !turn(p, i, round))
        i++;
    return i == p->c;
}

/* Tries all states, those that hold first. */
static int search(struct problem *p)
{
    unsigned long all = 1;
    for (size_t i = 0; i < p->c; i++) {
        all *= p->kind[i] == PUSH ? 2 : p->kind[i] == RUB ? 3 : 1;
        if (all > MOST_TRIED)
            return 0;
    }
    for (unsigned long number = 0; number < all; number++) {
        unsigned long rest = number;
        for (size_t i = 0; i < p->c; i++) {
            static const int ways[] = {1, 2, -2};
            if (p->kind[i] == PUSH)
                p->state[i] = rest % 2 == 0, rest /= 2;
            else if (p->kind[i] == RUB)
                p->state[i] = ways[rest % 3], rest /= 3;
        }
        if (pivot(p))
            return 1;
    }
    return 0;
}

/* Returns whether a solution is found. Pivots may go round where rows depend on each other. */
static int complement(struct problem *p)
{
    for (int count = 0; count < PIVOTS; count++)
        if (pivot(p))
            return 1;
    return search(p);
}

/* Computes the rounding errors of rows: relative to their terms, and to the largest numbers of the
 * motion so far, since what is at rest has no size of its own. */
static void sizes(struct pk_actor *a, struct rows *r)
{
    struct pk_projection *w = &r->w;
    const pk_real *v = a->next + a->n_q, *numbers[3] = {a->next, v, a->before};
    const int failed = w->system->acceleration(a->params, w->t, a->next, v, a->u, a->before);
    for (int what = 0; what < 3 - (failed != 0); what++)
        for (size_t k = 0; k < (what ? w->m : w->rotation); k++) {
            const pk_real size = PK_F(sqrt)(pk_project_mass(w, k)) * pk_abs(numbers[what][k]);
            a->most[what] = pk_finite(size) ? pk_max(a->most[what], size) : a->most[what];
        }
    pk_project_slopes(w, a->next, v, w->J, w->c, w->mu);
    for (size_t i = 0; i < w->c; i++) {
        const int gap = i < w->system->constraints.n_holonomic;
        r->of_gap[i] = gap ? ROUND * (w->phi_size[i] + w->mu[i] * a->most[0]) : 0;
        r->of_rate[i] = ROUND * (w->rate_size[i] + w->mu[i] * a->most[1]);
        r->of_acceleration[i] = ROUND * w->mu[i] * a->most[2];
    }
}

enum pk_status pk_act_rows(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    const pk_real *v = a->next + a->n_q;
    struct pk_projection *w = &r->w;
    *w = pk_project_parts(&it->problem, a->n, a->room);
    w->all = 1;
    w->t = it->t;
    w->u = a->u;
    const int singular = pk_project_inertia(w, a->next, v);
    if (singular)
        return it->status = pk_eval_failed(it, it->t, a->next, v, singular);
    pk_project_rows(w, a->next, v);
    pk_project_terms(w, a->next, v);
    sizes(a, r);
    for (size_t i = 0; i < w->c; i++) {
        r->of[i] = all->n;
        r->acceleration[i] = 0;
        pk_copy(w->W + i * w->m, w->J + i * w->n, w->m);
        pk_ldl_solve(w->M, w->m, w->W + i * w->m);
        for (size_t j = 0; j <= i; j++)
            a->A[i * w->c + j] = a->A[j * w->c + i] =
                pk_dot(w->J + i * w->n, w->W + j * w->m, w->m);
    }
    for (size_t k = 0; k < all->n; k++) {
        r->of[all->table[k].row] = k;
        r->mode[all->table[k].row] = all->table[k].mode;
    }
    all->values(a->params, it->t, a->next, v, a->u, a->values);
    for (size_t k = 0; k < all->n; k++) {
        const pk_real *bounds = a->values + 5 * k + 1;
        const int contact = all->table[k].kind == PK_CONTACT;
        for (size_t i = 0; i < 4; i++)
            if (bounds[i] < 0 || (contact && bounds[i] > 1))
                return pk_fail_with(it, PK_NO_CONTACT,
                                    PK_WHY(.kind = contact ? 2 : 3, .index = k, .value = bounds[i],
                                           .time = it->t));
    }
    return PK_DONE;
}

static struct problem problem_of(struct pk_actor *a, const struct rows *r)
{
    struct problem p = {
        .c = r->w.c, .A = a->A, .b = a->b, .x = a->x, .B = a->B, .least = r->of_acceleration};
    const struct pk_part_contacts *all = &a->system->contacts;
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        p.kind[i] = k == all->n ? EQUAL : OUT;
        p.state[i] = k == all->n;
        p.of[i] = p.c;
        if (k < all->n && all->table[k].of < all->n)
            p.of[i] = all->table[all->table[k].of].row;
        p.F[i] = p.f[i] = p.S[i] = p.s[i] = 0;
        if (k == all->n || all->table[k].kind != PK_FRICTION)
            continue;
        p.F[i] = a->values[5 * k + 1];
        p.f[i] = a->values[5 * k + 2];
        p.S[i] = a->values[5 * k + 3];
        p.s[i] = a->values[5 * k + 4];
    }
    return p;
}

/* Adds the impulses x to the rates, and to the books. */
static void apply(struct pk_actor *a, struct rows *r, const pk_real *x, pk_real t)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    struct pk_projection *w = &r->w;
    pk_real *v = a->next + a->n_q, *u = v + a->n;
    for (size_t i = 0; i < w->c; i++) {
        pk_real change = 0;
        for (size_t j = 0; j < w->c; j++)
            change += a->A[i * w->c + j] * x[j];
        const pk_real lost = -x[i] * (w->rate[i] + change / 2);
        size_t k = r->of[i];
        if (k < all->n && all->table[k].kind == PK_FRICTION)
            k = all->table[k].of;
        if (k < all->n) {
            u[all->table[k].mode + 1] += lost;
            a->seen[k].lost += lost;
        }
        if (k < all->n && all->table[k].row == i && x[i] > 0) {
            a->seen[k].impacts += 1;
            a->seen[k].flight = t - a->seen[k].last;
            a->seen[k].last = t;
        }
    }
    for (size_t i = 0; i < w->c; i++)
        pk_add(v, x[i], w->W + i * w->m, w->m);
    pk_project_rows(w, a->next, v);
    all->values(a->params, t, a->next, v, a->u, a->values); /* accelerations are of the new rates */
}

/* Solves for the impulses x of all contacts that touch. Returns whether they are found. */
static int impulses(struct pk_actor *a, const struct rows *r, const pk_real *rate, pk_real *x)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    struct problem p = problem_of(a, r);
    pk_real first[PK_MOST_ROWS];
    p.least = r->of_rate;
    int expands = 0;
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        const struct pk_contact *of = k < all->n ? &all->table[k] : NULL;
        const pk_real restitution = of && of->kind == PK_CONTACT ? a->values[5 * k + 1] : 0;
        const int poisson = of && of->kind == PK_CONTACT && of->flag;
        a->b[i] = rate[i];
        p.F[i] = p.S[i] = 0; /* finite forces give no impulse */
        p.s[i] = p.f[i];
        if (of && of->kind == PK_CONTACT && a->touches[k] > 0) {
            p.kind[i] = PUSH;
            a->b[i] += poisson ? 0 : restitution * pk_min(rate[i], 0);
            p.state[i] = a->b[i] < 0;
            expands |= poisson && restitution > 0;
        } else if (of && of->kind == PK_FRICTION && of->of < all->n && a->touches[of->of] > 0) {
            p.kind[i] = RUB;
            p.state[i] = 1;
        } else if (of && of->kind == PK_LATCH && a->u[of->mode] > 0) {
            p.kind[i] = EQUAL;
            p.state[i] = 1;
        }
    }
    if (!complement(&p))
        return 0;
    pk_copy(x, a->x, p.c);
    if (!expands)
        return 1;
    for (size_t i = 0; i < p.c; i++) { /* Poisson: impulses of compression come back, e-fold */
        const size_t k = r->of[i];
        const int back = p.kind[i] == PUSH && all->table[k].flag;
        first[i] = back ? a->values[5 * k + 1] * x[i] : 0;
    }
    for (size_t i = 0; i < p.c; i++) {
        a->b[i] = rate[i];
        for (size_t j = 0; j < p.c; j++)
            a->b[i] += a->A[i * p.c + j] * (x[j] + first[j]);
        p.F[i] = p.S[i] = p.of[i] < p.c ? p.f[i] * first[p.of[i]] : 0;
        p.state[i] = p.kind[i] == PUSH ? a->b[i] < 0 : p.kind[i] != OUT;
    }
    if (!complement(&p))
        return 0;
    for (size_t i = 0; i < p.c; i++)
        x[i] += first[i] + a->x[i];
    return 1;
}

enum pk_status pk_impact(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    pk_real x[PK_MOST_ROWS];
    if (!impulses(a, r, r->w.rate, x))
        return pk_fail_with(it, PK_NO_CONTACT, PK_WHY(.kind = 1, .time = it->t));
    apply(a, r, x, it->t);
    return PK_DONE;
}

/* Marks the rows that are linear combinations of rows that hold: they stay at 0 without a force, or
 * with the force of a slip. */
static void depend(const struct problem *p, int *depends)
{
    const pk_real least = PK_C(1e-9);
    size_t held[PK_MOST_ROWS], count = 0;
    pk_real d[PK_MOST_ROWS], *L = p->B;
    for (int holds = 1; holds >= 0; holds--)
        for (size_t i = 0; i < p->c; i++) {
            if ((p->state[i] == 1 && p->kind[i] != OUT) != holds)
                continue;
            pk_real left = p->A[i * p->c + i];
            for (size_t k = 0; k < count; k++) {
                pk_real sum = p->A[i * p->c + held[k]];
                for (size_t m = 0; m < k; m++)
                    sum -= L[i * p->c + m] * L[held[k] * p->c + m] * d[m];
                L[i * p->c + k] = sum / d[k];
                left -= sum * sum / d[k];
            }
            depends[i] = !(left > least * p->A[i * p->c + i]);
            if (holds && !depends[i]) {
                d[count] = left;
                held[count++] = i;
            }
        }
}

enum pk_status pk_reactions(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    struct problem p = problem_of(a, r);
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        a->b[i] = 0;
        if (k == all->n)
            continue;
        const int state = (int)a->state[k], holds = state == 1;
        const enum pk_contact_kind kind = all->table[k].kind;
        a->b[i] = a->values[5 * k];
        if (kind == PK_LATCH)
            p.kind[i] = a->u[all->table[k].mode] > 0 ? EQUAL : OUT;
        else if (kind == PK_CONTACT)
            p.kind[i] = holds ? PUSH : OUT;
        else if (all->table[k].of < all->n && !(a->state[all->table[k].of] > 0))
            p.kind[i] = OUT; /* its contact is open */
        else
            p.kind[i] = holds ? RUB : SLIP;
        p.state[i] = p.kind[i] == EQUAL ? 1 : state;
    }
    int found = complement(&p), ends = 0;
    for (size_t i = 0; i < p.c && found; i++) { /* a row whose force reached its bound lets go */
        const size_t k = r->of[i];
        const pk_real nothing = 10 * r->of_acceleration[i] / p.A[i * p.c + i];
        const int over =
            k < all->n && p.state[i] == 1 &&
            ((all->table[k].open < a->system->events.n && a->happened[all->table[k].open] > 0) ||
             (p.kind[i] == PUSH && p.x[i] <= nothing));
        if (over && p.kind[i] == PUSH)
            p.state[i] = 0, ends = 1;
        else if (over && p.kind[i] == RUB)
            p.state[i] = p.x[i] > 0 ? -2 : 2, ends = 1;
    }
    if (!found || (ends && !complement(&p)))
        return pk_fail_with(it, PK_NO_CONTACT, PK_WHY(.time = it->t));
    int depends[PK_MOST_ROWS];
    depend(&p, depends);
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        pk_real size;
        r->acceleration[i] = result(&p, i, &size);
        if (k == all->n)
            continue;
        /* a gap, or a slip, that begins at rest is less than its rounding for a while */
        a->floats[k] = p.kind[i] != OUT && p.kind[i] != SLIP && p.state[i] != 1;
        const pk_real bound = p.S[i] + p.s[i] * push(&p, i);
        const int ties = p.kind[i] == RUB && p.state[i] == 1 &&
                         bound - pk_abs(p.x[i]) <= 10 * ROUND * bound;
        a->clings[k] = ties ? -100 * ROUND * bound * bound : 0;
        a->idle[k] = depends[i] && p.kind[i] != OUT && p.kind[i] != SLIP;
        a->state[k] = p.state[i] == 1 && depends[i] ? 0 : p.state[i];
        if (all->table[k].kind == PK_FRICTION && p.of[i] < p.c && !(push(&p, i) > 0))
            a->state[k] = 0;
    }
    return PK_DONE;
}
