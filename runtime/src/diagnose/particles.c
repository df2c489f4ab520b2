/* Angular momentum and the Laplace-Runge-Lenz vector; see pk/particles.h. */
#include <string.h>

#include <pk/particles.h>

#include "../core/attitude.h"

static pk_real norm(const pk_real *a) { return PK_F(sqrt)(pk_dot3(a, a)); }

void pk_angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                         int about_centre, pk_real L[3], pk_real *size)
{
    pk_real mass = 0, R[3] = {0, 0, 0}, V[3] = {0, 0, 0};
    for (size_t i = 0; i < n && about_centre; i++) {
        mass += m[i];
        for (size_t k = 0; k < 3; k++) {
            R[k] += m[i] * r[3 * i + k];
            V[k] += m[i] * v[3 * i + k];
        }
    }
    for (size_t k = 0; k < 3 && about_centre; k++) {
        R[k] /= mass;
        V[k] /= mass;
    }
    memset(L, 0, 3 * sizeof *L);
    *size = 0;
    for (size_t i = 0; i < n; i++) {
        pk_real x[3], u[3], l[3];
        for (size_t k = 0; k < 3; k++) {
            x[k] = r[3 * i + k] - R[k];
            u[k] = v[3 * i + k] - V[k];
        }
        pk_cross(x, u, l);
        for (size_t k = 0; k < 3; k++)
            L[k] += m[i] * l[k];
        *size += m[i] * norm(x) * norm(u);
    }
}

/* Computes the Laplace-Runge-Lenz vector e, its length, and its rate of change. */
static void vector(struct pk_lrl *lrl, const pk_real *r, const pk_real *v, const pk_real *a)
{
    pk_real l[3], torque[3], e[3], b[3], c[3], rate[3];
    const pk_real distance = norm(r), inwards = pk_dot3(r, v) / (distance * distance);
    pk_cross(r, v, l);
    pk_cross(v, l, e);
    pk_cross(r, a, torque);
    pk_cross(a, l, b);
    pk_cross(v, torque, c);
    for (size_t k = 0; k < 3; k++) {
        lrl->e[k] = e[k] / lrl->k - r[k] / distance;
        rate[k] = (b[k] + c[k]) / lrl->k - (v[k] - r[k] * inwards) / distance;
    }
    lrl->eccentricity = norm(lrl->e);
    lrl->rate = norm(rate) * distance / norm(v);
}

enum pk_status pk_lrl_init(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3],
                           const pk_real a[3])
{
    pk_real l[3];
    memset(lrl, 0, sizeof *lrl);
    lrl->k = -norm(r) * pk_dot3(r, a);
    if (!(lrl->k > 0))
        return PK_REFUSED;
    vector(lrl, r, v, a);
    pk_cross(r, v, l);
    pk_cross(l, lrl->e, lrl->across);
    const pk_real length = norm(lrl->across);
    for (size_t k = 0; k < 3 && lrl->eccentricity > 0; k++) {
        lrl->along[k] = lrl->e[k] / lrl->eccentricity;
        lrl->across[k] = length > 0 ? lrl->across[k] / length : 0;
    }
    return PK_DONE;
}

/* Finds the plane of a motion that began at rest or radially, once it leaves its straight line. */
static void find_plane(struct pk_lrl *lrl, const pk_real *r, const pk_real *v)
{
    pk_real l[3], across[3];
    pk_cross(r, v, l);
    if (!(norm(l) > 64 * PK_EPSILON * norm(r) * norm(v)))
        return;
    pk_cross(l, lrl->along, across);
    const pk_real length = norm(across);
    for (size_t k = 0; k < 3 && length > 0; k++)
        lrl->across[k] = across[k] / length;
}

void pk_lrl_update(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3], const pk_real a[3])
{
    vector(lrl, r, v, a);
    if (!(norm(lrl->across) > 0))
        find_plane(lrl, r, v);
    const pk_real turn = 2 * PK_PI;
    const pk_real now = PK_F(atan2)(pk_dot3(lrl->e, lrl->across), pk_dot3(lrl->e, lrl->along));
    lrl->angle = now + turn * PK_F(round)((lrl->angle - now) / turn);
}
