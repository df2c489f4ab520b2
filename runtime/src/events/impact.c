/* Impulses at closed gaps, and which contacts and frictions hold: the linear complementarity
 * problems of complement.h, where x are impulses and y rates, or x multipliers and y accelerations
 * of the rows, and A = J M^-1 J^T. */
#include <math.h>

#include "act.h"
#include "complement.h"

#define ROUND PK_COMPLEMENT_ROUND
/* two orders of impacts agree if they differ by less than this fraction of the rates */
#define AGREE PK_C(1e-8)
enum { BLOWS = 200 }; /* the most of a sequence of single impacts */

/* Computes the rounding errors of rows: relative to their terms, and to the largest numbers of the
 * motion so far, since what is at rest has no size of its own. */
static void sizes(struct pk_actor *a, struct rows *r)
{
    struct pk_projection *w = &r->w;
    const pk_real *v = a->next + a->n_q, *numbers[3] = {a->next, v, a->before};
    const int failed = w->system->acceleration(a->params, w->t, a->next, v, a->u, a->before);
    const int count = 3 - (failed != 0);
    for (int what = 0; what < count; what++)
        for (size_t k = 0; k < (what ? w->m : w->rotation); k++) {
            const pk_real since = what + 1 < count ? w->t - a->changed : 0; /* the last change */
            const pk_real way = since > 0 ? numbers[what + 1][k] * since : 0;
            const pk_real size = PK_F(sqrt)(pk_project_mass(w, k)) *
                                 pk_max(pk_abs(way), pk_abs(numbers[what][k]));
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
                return pk_fail_with(
                    it, PK_NO_CONTACT,
                    PK_WHY(.kind = contact ? PK_REASON_RESTITUTION : PK_REASON_BOUND, .index = k,
                           .value = bounds[i], .time = it->t));
    }
    return PK_DONE;
}

static struct pk_complement problem_of(struct pk_actor *a, const struct rows *r)
{
    struct pk_complement p = {
        .c = r->w.c, .A = a->A, .b = a->b, .x = a->x, .B = a->B, .least = r->of_acceleration};
    const struct pk_part_contacts *all = &a->system->contacts;
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        p.kind[i] = k == all->n ? PK_EQUAL : PK_OUT;
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
    struct pk_complement p = problem_of(a, r);
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
            p.kind[i] = PK_PUSH;
            a->b[i] += poisson ? 0 : restitution * pk_min(rate[i], 0);
            p.state[i] = a->b[i] < 0;
            expands |= poisson && restitution > 0;
        } else if (of && of->kind == PK_FRICTION && of->of < all->n && a->touches[of->of] > 0) {
            p.kind[i] = PK_RUB;
            p.state[i] = 1;
        } else if (of && of->kind == PK_LATCH && a->u[of->mode] > 0) {
            p.kind[i] = PK_EQUAL;
            p.state[i] = 1;
        }
    }
    if (!pk_complement(&p))
        return 0;
    pk_copy(x, a->x, p.c);
    if (!expands)
        return 1;
    for (size_t i = 0; i < p.c; i++) { /* Poisson: impulses of compression come back, e-fold */
        const size_t k = r->of[i];
        const int back = p.kind[i] == PK_PUSH && all->table[k].flag;
        first[i] = back ? a->values[5 * k + 1] * x[i] : 0;
    }
    for (size_t i = 0; i < p.c; i++) {
        a->b[i] = rate[i];
        for (size_t j = 0; j < p.c; j++)
            a->b[i] += a->A[i * p.c + j] * (x[j] + first[j]);
        p.F[i] = p.S[i] = p.of[i] < p.c ? p.f[i] * first[p.of[i]] : 0;
        p.state[i] = p.kind[i] == PK_PUSH ? a->b[i] < 0 : p.kind[i] != PK_OUT;
    }
    if (!pk_complement(&p))
        return 0;
    for (size_t i = 0; i < p.c; i++)
        x[i] += first[i] + a->x[i];
    return 1;
}

/* Computes the sum of the impulses if contacts strike one after the other, the first or the last of
 * the contacts `which` first. Returns 0 if they do not come to an end. */
static int one_by_one(struct pk_actor *a, const struct rows *r, const size_t *which, size_t count,
                      int first, pk_real *sum)
{
    pk_real x[PK_MOST_ROWS], rate[PK_MOST_ROWS];
    const size_t c = r->w.c;
    pk_zero(sum, c);
    for (int blow = 0; blow < BLOWS; blow++) {
        size_t next = count;
        for (size_t i = 0; i < c; i++)
            rate[i] = r->w.rate[i] + pk_dot(a->A + i * c, sum, c);
        for (size_t n = 0; n < count && next == count; n++) {
            const size_t k = first ? n : count - 1 - n,
                         row = a->system->contacts.table[which[k]].row;
            next = rate[row] < -r->of_rate[row] ? k : count;
        }
        if (next == count)
            return 1;
        for (size_t n = 0; n < count; n++)
            a->touches[which[n]] = n == next;
        const int found = impulses(a, r, rate, x);
        for (size_t n = 0; n < count; n++)
            a->touches[which[n]] = 1;
        if (!found)
            return 0;
        pk_add(sum, 1, x, c);
    }
    return 0;
}

/* Notes the first impact of several contacts that leaves other rates if they strike one after the
 * other, in either order. */
static void order(struct pk_actor *a, const struct pk_integrator *it, const struct rows *r,
                  const pk_real *x)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    pk_real sums[2][PK_MOST_ROWS], apart = 0, size = 0;
    size_t which[PK_MOST_ROWS], count = 0;
    for (size_t k = 0; k < all->n; k++)
        if (all->table[k].kind == PK_CONTACT && a->touches[k] > 0 && x[all->table[k].row] > 0)
            which[count++] = k;
    if (count < 2 || pk_finite(a->order_t) || !one_by_one(a, r, which, count, 1, sums[0]) ||
        !one_by_one(a, r, which, count, 0, sums[1]))
        return;
    for (size_t i = 0; i < r->w.c; i++) {
        const pk_real *row = a->A + i * r->w.c;
        const pk_real at_once = pk_dot(row, x, r->w.c);
        for (int way = 0; way < 2; way++)
            apart = pk_max(apart, pk_abs(pk_dot(row, sums[way], r->w.c) - at_once));
        size = pk_max(size, pk_abs(r->w.rate[i]));
    }
    if (apart <= AGREE * size)
        return;
    a->order_t = it->t;
    a->order_of[0] = (pk_real)which[0];
    a->order_of[1] = (pk_real)which[1];
}

enum pk_status pk_impact(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    pk_real x[PK_MOST_ROWS];
    if (!impulses(a, r, r->w.rate, x))
        return pk_fail_with(it, PK_NO_CONTACT, PK_WHY(.kind = PK_REASON_IMPULSES, .time = it->t));
    order(a, it, r, x);
    apply(a, r, x, it->t);
    return PK_DONE;
}

/* Marks the rows that are linear combinations of rows that hold: they stay at 0 without a force, or
 * with the force of a slip. */
static void depend(const struct pk_complement *p, int *depends)
{
    const pk_real least = PK_C(1e-9);
    size_t held[PK_MOST_ROWS], count = 0;
    pk_real d[PK_MOST_ROWS], *L = p->B;
    for (int holds = 1; holds >= 0; holds--)
        for (size_t i = 0; i < p->c; i++) {
            if ((p->state[i] == 1 && p->kind[i] != PK_OUT) != holds)
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
    struct pk_complement p = problem_of(a, r);
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        a->b[i] = 0;
        if (k == all->n)
            continue;
        const int state = (int)a->state[k], holds = state == 1;
        const enum pk_contact_kind kind = all->table[k].kind;
        a->b[i] = a->values[5 * k];
        if (kind == PK_LATCH)
            p.kind[i] = a->u[all->table[k].mode] > 0 ? PK_EQUAL : PK_OUT;
        else if (kind == PK_CONTACT)
            p.kind[i] = holds ? PK_PUSH : PK_OUT;
        else if (all->table[k].of < all->n && !(a->state[all->table[k].of] > 0))
            p.kind[i] = PK_OUT; /* its contact is open */
        else
            p.kind[i] = holds ? PK_RUB : PK_SLIP;
        p.state[i] = p.kind[i] == PK_EQUAL ? 1 : state;
    }
    int found = pk_complement(&p), ends = 0;
    for (size_t i = 0; i < p.c && found; i++) { /* a row whose force reached its bound lets go */
        const size_t k = r->of[i];
        const pk_real nothing = 10 * r->of_acceleration[i] / p.A[i * p.c + i];
        const int over =
            k < all->n && p.state[i] == 1 &&
            ((all->table[k].open < a->system->events.n && a->happened[all->table[k].open] > 0) ||
             (p.kind[i] == PK_PUSH && p.x[i] <= nothing));
        if (over && p.kind[i] == PK_PUSH)
            p.state[i] = 0, ends = 1;
        else if (over && p.kind[i] == PK_RUB)
            p.state[i] = p.x[i] > 0 ? -2 : 2, ends = 1;
    }
    if (!found || (ends && !pk_complement(&p)))
        return pk_fail_with(it, PK_NO_CONTACT,
                            PK_WHY(.kind = PK_REASON_ACCELERATIONS, .time = it->t));
    int depends[PK_MOST_ROWS];
    depend(&p, depends);
    for (size_t i = 0; i < p.c; i++) {
        const size_t k = r->of[i];
        pk_real size;
        r->acceleration[i] = pk_complement_result(&p, i, &size);
        if (k == all->n)
            continue;
        /* a gap, or a slip, that begins at rest is less than its rounding for a while */
        a->floats[k] = p.kind[i] != PK_OUT && p.kind[i] != PK_SLIP && p.state[i] != 1;
        const pk_real bound = p.S[i] + p.s[i] * pk_complement_push(&p, i);
        const int ties = p.kind[i] == PK_RUB && p.state[i] == 1 &&
                         bound - pk_abs(p.x[i]) <= 10 * ROUND * bound;
        a->clings[k] = ties ? -100 * ROUND * bound * bound : 0;
        a->idle[k] = depends[i] && p.kind[i] != PK_OUT && p.kind[i] != PK_SLIP &&
                     pk_abs(r->acceleration[i]) <= ROUND * size + r->of_acceleration[i];
        a->state[k] = (pk_real)(p.state[i] == 1 && depends[i] ? 0 : p.state[i]);
        if (all->table[k].kind == PK_FRICTION && p.of[i] < p.c && !(pk_complement_push(&p, i) > 0))
            a->state[k] = 0;
    }
    return PK_DONE;
}
