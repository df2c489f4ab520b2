/* The functions of events at samples of a step: on an interpolant, which costs no step, or where
 * that is worthless at states by shorter steps. See events.c. /
 */
#include "events.h"

/* Cubic of Hermite through q and v at the ends, and its derivative. */
static void hermite(const struct pk_events *e, const struct pk_integrator *it, pk_real x)
{
    const pk_real h = it->t - e->from, y = 1 - x;
    const pk_real h01 = x * x * (3 - 2 * x), h10 = x * y * y * h, h11 = -x * x * y * h;
    const pk_real slope = 6 * x * y / h, d10 = y * (1 - 3 * x), d11 = x * (3 * x - 2);
    for (size_t i = 0; i < e->n; i++) {
        const pk_real rise = it->q[i] - e->q0[i];
        e->trial[i] = e->q0[i] + h01 * rise + h10 * e->v0[i] + h11 * it->v[i];
        e->trial[e->n + i] = slope * rise + d10 * e->v0[i] + d11 * it->v[i];
    }
}

/* Whether the cubic bends at an end by so much else than the motion does that half-way it may be
 * off by 1/32 of the rise: bends differ by 32/h^2 of what it is off. */
static int is_worthless(struct pk_events *e, const struct pk_integrator *it)
{
    const pk_real h = it->t - e->from;
    for (int end = 0; end < 2; end++) {
        const pk_real *q = end ? it->q : e->q0, *v = end ? it->v : e->v0;
        if (pk_eval_acceleration(&e->scout, end ? it->t : e->from, q, v, e->trial) < 0)
            return 0;
        for (size_t i = 0; i < e->n; i++) {
            const pk_real rise = it->q[i] - e->q0[i], v0 = h * e->v0[i], v1 = h * it->v[i];
            const pk_real bend = end ? 2 * v0 + 4 * v1 - 6 * rise : 6 * rise - 4 * v0 - 2 * v1;
            const pk_real size = pk_max(pk_abs(rise), pk_max(pk_abs(v0), pk_abs(v1)) / 4);
            if (pk_abs(bend - h * h * e->trial[i]) > size + PK_EPS * pk_abs(q[i]))
                return 1;
        }
    }
    return 0;
}

/* A sample by the method itself; where it makes no such step there is none. */
static int reach_sample(struct pk_events *e, struct pk_integrator *it, pk_real t)
{
    const size_t where = it->where;
    const pk_real detail = it->detail;
    if (pk_events_reach(e, it, t) >= 0)
        return 1;
    it->where = where;
    it->detail = detail;
    it->status = PK_DONE;
    return 0;
}

enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real h = it->t - e->from;
    const int by_steps = !e->dense && is_worthless(e, it);
    for (int j = 1; j < e->samples; j++) {
        const pk_real x = (pk_real)j / (pk_real)e->samples, t = e->from + x * h;
        if (!e->dense && !(by_steps && reach_sample(e, it, t)))
            hermite(e, it, x);
        else if (e->dense && pk_integrator_dense(it, t, e->trial, e->trial + e->n) < 0)
            return it->status;
        pk_events_functions(e, it, t, e->trial, e->trial + e->n, pk_events_sample(e, j));
    }
    return PK_DONE;
}
