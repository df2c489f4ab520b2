/* Events and switches at a time within a step: the state there, the values of their functions, and
 * the sample times of a window. */

#include "events.h"

/* cos(pi j / 16). */
const pk_real pk_events_cosines[PK_MOST_SAMPLES + 1] = {
    1,
    PK_C(0.980785280403230449126182236134239036),
    PK_C(0.923879532511286756128183189396788286),
    PK_C(0.831469612302545237078788377617905756),
    PK_C(0.707106781186547524400844362104849039),
    PK_C(0.555570233019602224742830813948532874),
    PK_C(0.382683432365089771728459984030398866),
    PK_C(0.195090322016128267848284868477022240),
    0,
    PK_C(-0.195090322016128267848284868477022240),
    PK_C(-0.382683432365089771728459984030398866),
    PK_C(-0.555570233019602224742830813948532874),
    PK_C(-0.707106781186547524400844362104849039),
    PK_C(-0.831469612302545237078788377617905756),
    PK_C(-0.923879532511286756128183189396788286),
    PK_C(-0.980785280403230449126182236134239036),
    -1};

void pk_switches_values(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                        const pk_real *q, const pk_real *v, pk_real *x)
{
    const struct pk_problem *p = &it->problem;
    pk_feedback(p, t, q, v, e->u);
    p->system->switches.values(e->params, t, q, v, e->u, x);
}

/* Evaluates the switches alone; a value of 0 gets the sign of the side where the switch is held, or
 * is positive. The value of a counted switch becomes positive in its piece and negative elsewhere. */
static void switches(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                     const pk_real *q, const pk_real *v, pk_real *g)
{
    if (e->n_switches == 0)
        return;
    pk_switches_values(e, it, t, q, v, g);
    const int begins = e->kept && !(t < e->from) && !(t > e->from);
    for (size_t k = 0; k < e->n_switches; k++) {
        const int counted = pk_switches_counted(it, k);
        const pk_real side = counted ? 1 : e->sides[k], off = g[k] - e->sides[k] / 2;
        if (counted) /* (u - n) (n + 1 - u), positive in the piece */
            g[k] = PK_C(0.25) - off * off;
        if (pk_abs(g[k]) <= 0 || (begins && pk_switches_impulse(it, k) && g[k] * side < 0))
            g[k] = side < 0 ? -PK_TINY : PK_TINY;
    }
}

void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                         const pk_real *q, const pk_real *v, pk_real *g)
{
    const struct pk_problem *p = &it->problem;
    pk_feedback(p, t, q, v, e->u);
    if (e->n_events)
        p->system->events.values(e->params ? e->params : p->params, t, q, v, e->u, g);
    for (size_t k = 0; k < e->n_events; k++)
        if (pk_abs(g[k] -= e->off[k]) <= 0 && p->system->events.table[k].stop > 1)
            g[k] = -PK_TINY * (pk_real)p->system->events.table[k].direction;
    switches(e, it, t, q, v, g + e->n_events);
}

enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k)
{
    it->event = k + 1;
    return it->status = PK_NOT_FINITE;
}

enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t)
{
    const struct pk_integrator *there = it;
    if (t < it->t || t > it->t) {
        e->tries++;
        if (e->dense)
            return pk_integrator_dense(it, t, e->trial, e->trial_v);
        PK_TRY(pk_integrator_aside(it, &e->scout, t));
        there = &e->scout;
    }
    pk_copy(e->trial, there->q, e->n_q);
    pk_copy(e->trial_v, there->v, e->n);
    return PK_DONE;
}

pk_real pk_events_node(const struct pk_events *e, int j)
{
    return j == PK_MOST_SAMPLES ? e->at + e->width
                                : e->at + e->width * (1 - pk_events_cosines[j]) / 2;
}
