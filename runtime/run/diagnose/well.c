/* A potential well of one degree of freedom; see well.h. */
#include "well.h"

#include "../../src/core/internal.h"
#include <pk/root.h>

enum { PANELS = 20000, PARTS = 8, PROBES = 16, PANELS_ROUND = 256 };
#define FOLLOWED (1024 * PK_EPSILON) /* largest error of the work in a panel, relative to w->most */

pk_real force_at(const struct well *w, pk_real q)
{
    const pk_real rest = 0;
    pk_real F;
    w->system->gradient(w->params, w->t, &q, &rest, w->u, &F);
    return F;
}

pk_real mass_at(const struct well *w, pk_real q)
{
    const pk_real rest = 0;
    pk_real M;
    w->system->mass(w->params, w->t, &q, &rest, w->u, &M);
    return M;
}

pk_real linear_at(const struct well *w, pk_real q)
{
    const pk_real rest = 0;
    pk_real b, pdot;
    w->system->canonical(w->params, w->t, &q, &rest, w->u, &b, &pdot);
    return b;
}

pk_real well_work(const struct well *w, pk_real q, pk_real a, pk_real b)
{
    static const pk_real x[3] = {PK_C(0.23861918608319690863050172168071193542),
                                 PK_C(0.66120938646626451366139959501990534701),
                                 PK_C(0.93246951420315202781230155449399460913)};
    static const pk_real weight[3] = {PK_C(0.46791393457269104738987034398955099481),
                                      PK_C(0.36076157304813860756983351383771611166),
                                      PK_C(0.17132449237917034504029614217273289353)};
    const pk_real half = (b - a) / 2, middle = a + half;
    pk_real sum = 0;
    for (int i = 0; i < 3; i++)
        sum += weight[i] *
               (force_at(w, q + (middle - half * x[i])) + force_at(w, q + (middle + half * x[i])));
    return half * sum;
}

/* A point of the march: at q + y, where h - W (energy minus potential) is U; and the direction. */
struct place {
    const struct well *w;
    pk_real q, y, U, direction;
};

static enum pk_status left_at(void *context, pk_real distance, pk_real *U)
{
    const struct place *p = (const struct place *)context;
    *U = p->U + well_work(p->w, p->q, p->y, p->y + p->direction * distance);
    return PK_DONE;
}

static enum pk_status slope_at(void *context, pk_real distance, pk_real *slope)
{
    const struct place *p = (const struct place *)context;
    *slope = p->direction * force_at(p->w, p->q + (p->y + p->direction * distance));
    return PK_DONE;
}

/* Returns the distance from the point p to the root of f, to the last digit. At the distance `far`
 * f has the opposite sign or is 0; `far` may be a million times the distance of the root, as in the
 * first panel of a march if the force is tiny. */
static pk_real root_of(struct place *p, pk_function f, pk_real far)
{
    for (pk_real before = PK_INFINITY; far < before / 2;) {
        pk_real near = 0, at_near, at_far;
        before = far;
        f(p, near, &at_near);
        f(p, far, &at_far);
        pk_root(f, p, &near, at_near, &far, at_far, PK_EPSILON * before);
    }
    return far;
}

/* Returns whether h - W has a root within the distance `far` from p, and sets *distance to its
 * distance. Beyond a low barrier, h - W may be positive again: its minimum is computed where the
 * force turns. */
static int crosses(struct place *p, pk_real far, pk_real at_far, pk_real *least, pk_real *distance)
{
    pk_real before, behind, U, to = far;
    slope_at(p, 0, &before);
    slope_at(p, far, &behind);
    if (before < 0 && behind > 0) {
        to = root_of(p, slope_at, far);
        left_at(p, to, &U);
        *least = PK_F(fmin)(*least, U);
        if (U > 0)
            to = far;
        else
            at_far = U;
    }
    if (at_far > 0)
        return 0;
    *distance = root_of(p, left_at, to);
    return 1;
}

/* Returns whether the mass M, the force F and the term b of L have period 2 pi in q, and a full
 * turn takes no work. Returns 0 if F is 0 and M is constant, since q need not be an angle then. */
static int is_angle(const struct well *w, pk_real q)
{
    pk_real off[3] = {0, 0, 0}, most[3] = {0, 0, 0}, M_lo = PK_INFINITY, round = 0;
    for (int k = 0; k < PANELS_ROUND; k++)
        round += well_work(w, q, (pk_real)k * (TURN / PANELS_ROUND),
                           (pk_real)(k + 1) * (TURN / PANELS_ROUND));
    for (int k = 0; k < PROBES; k++) {
        const pk_real x = q + (pk_real)k * PK_C(0.7310585786300049), X = x + TURN;
        const pk_real here[3] = {force_at(w, x), mass_at(w, x), linear_at(w, x)};
        const pk_real there[3] = {force_at(w, X), mass_at(w, X), linear_at(w, X)};
        for (int i = 0; i < 3; i++) {
            off[i] = PK_F(fmax)(off[i], pk_abs(here[i] - there[i]));
            most[i] = PK_F(fmax)(most[i], pk_abs(here[i]));
        }
        M_lo = PK_F(fmin)(M_lo, here[1]);
    }
    for (int i = 0; i < 3; i++)
        if (!(off[i] <= PK_F(sqrt)(PK_EPSILON) * most[i]))
            return 0;
    if (!(pk_abs(round) <= PK_F(sqrt)(PK_EPSILON) * TURN * most[0]))
        return 0;
    return most[0] > 0 || most[1] - M_lo > PK_F(sqrt)(PK_EPSILON) * most[1];
}

/* Makes each panel (interval) as long as possible while the quadrature resolves the force. */
struct end well_march(struct well *w, pk_real q, pk_real U, pk_real direction)
{
    struct end end = {0, 0, 0};
    const pk_real F = pk_abs(force_at(w, q));
    pk_real y = 0, d = U > 0 && F > 0 ? U / F : pk_abs(q) > 0 ? pk_abs(q) : 1;
    for (int panel = 0; panel < PANELS && pk_finite(d); panel++) {
        d = PK_F(fmin)(d, w->longest);
        const pk_real step = direction * d / PARTS, whole = well_work(w, q, y, y + direction * d);
        pk_real at[PARTS + 1] = {U}, most = w->most;
        for (int k = 0; k < PARTS; k++) {
            const pk_real from = y + (pk_real)k * step, to = y + (pk_real)(k + 1) * step;
            at[k + 1] = at[k] + well_work(w, q, from, to);
            most = PK_F(fmax)(most, at[k + 1]);
        }
        /* The force is not resolved, or the motion from rest turns back within this panel. */
        if (!(pk_abs(at[PARTS] - U - whole) <= FOLLOWED * most) || !(at[0] > 0 || at[1] > 0)) {
            d /= 4;
            if (!(pk_abs(y) + d / PARTS > pk_abs(y)))
                return end;
            continue;
        }
        for (int k = 0; k < PARTS; k++) {
            struct place place = {w, q, y + (pk_real)k * step, at[k], direction};
            pk_real distance;
            if (crosses(&place, d / PARTS, at[k + 1], &w->least, &distance)) {
                end.y = place.y + direction * distance;
                end.found = 1;
                return end;
            }
        }
        w->most = most;
        U = at[PARTS];
        y += direction * d;
        d *= 2;
        if (pk_abs(y) >= TURN && is_angle(w, q)) {
            end.found = end.turns = 1;
            return end;
        }
    }
    return end;
}
