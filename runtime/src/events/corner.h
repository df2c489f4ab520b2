/* The corner condition at a switch, solved for the rates after it; see corner.c. */
#ifndef PK_CORNER_H
#define PK_CORNER_H

#include "events.h"
#include "../core/project.h"

#define PK_CORNER_ALONG \
    (1024 * PK_EPS) /* a smaller part of s_q outside the span of the rows counts as 0 */
#define PK_CORNER_WHOLE \
    PK_F(sqrt)(PK_EPS) /* a larger relative change of a position or a row is a jump */

struct corner {
    struct pk_events *e;
    struct pk_integrator *it;
    struct pk_projection w;
    const pk_real *q, *slope; /* s_q */
    pk_real slope_t, h0;
    pk_real *p0, *p, *v, *start;  /* p has 2 n numbers: momenta, then their rates pdot */
    pk_real *along, *lambda, *by; /* dv/dalpha, Lambda, dLambda/dalpha */
    pk_real *slopes, *J, *phi, *before, *sides, *first;
};

struct corner pk_corner_of(struct pk_events *e, struct pk_integrator *it);
void pk_corner_momenta(struct corner *x, const pk_real *v);
pk_real pk_corner_energy(const struct corner *x, const pk_real *v);
void pk_corner_rows(struct corner *x, const pk_real *v);
pk_real pk_corner_speed(const struct corner *x);

/* Finds the rates at that root of the energy balance E(alpha) where s' = ds/dt has the sign of
 * `direction`; see corner.c. Returns 1 on success, 0 if there is no root, -1 on failure. */
int pk_corner_leave(struct corner *x, pk_real direction, int free);

#endif
