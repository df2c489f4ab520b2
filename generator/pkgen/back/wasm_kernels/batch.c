/* Many states in one call: arrays t, q, v and u, each ordered state by state. */
#include <string.h>

#include "live.h"

/* The accelerations of PK_LANES states at once, one in each SIMD lane. Returns a bit set of the
 * lanes that failed. */
static unsigned long long block(const void *params, size_t n, const double *t, const double *q,
                                const double *v, const double *u, double *out, double *work)
{
    const size_t n_u = live_system->n_inputs;
    double *const Q = work, *const V = Q + n * PK_LANES, *const A = V + n * PK_LANES,
                  *const U = A + n * PK_LANES;
    for (size_t l = 0; l < PK_LANES; l++) {
        for (size_t i = 0; i < n; i++) {
            Q[i * PK_LANES + l] = q[l * n + i];
            V[i * PK_LANES + l] = v[l * n + i];
        }
        for (size_t i = 0; i < n_u; i++)
            U[i * PK_LANES + l] = u[l * n_u + i];
    }
    const unsigned long long failed = live_system->lanes(params, t, Q, V, U, A);
    for (size_t l = 0; l < PK_LANES; l++)
        for (size_t i = 0; i < n; i++)
            out[l * n + i] = A[i * PK_LANES + l];
    return failed;
}

/* Length of the array `work` of live_accelerations(). */
size_t EXPORT(live_accelerations_size)(const void *params)
{
    return PK_LANES * (3 * pk_system_count(live_system, params) + live_system->n_inputs);
}

/* Writes the accelerations of `count` states to `out`. failed[k] is 1 if state k has none. */
void EXPORT(live_accelerations)(const void *params, size_t count, const double *t, const double *q,
                                const double *v, const double *u, double *out,
                                unsigned char *failed, double *work)
{
    const size_t n = pk_system_count(live_system, params), n_u = live_system->n_inputs;
    const size_t blocks = live_system->lanes ? count / PK_LANES : 0;
    for (size_t b = 0; b < blocks; b++) {
        const size_t k = b * PK_LANES;
        const unsigned long long bits =
            block(params, n, t + k, q + k * n, v + k * n, u + k * n_u, out + k * n, work);
        for (size_t l = 0; l < PK_LANES; l++)
            failed[k + l] = (unsigned char)(bits >> l & 1);
    }
    for (size_t k = 0; k < count; k++)
        if (k >= blocks * PK_LANES || failed[k])
            failed[k] = live_system->acceleration(params, t[k], q + k * n, v + k * n, u + k * n_u,
                                                  out + k * n) != 0;
}

/* Evaluates a kernel with `width` results at each state. `which`: 0 outputs, 1 claims, 2 the
 * energy. Returns 0 if the model has no such kernel. */
int EXPORT(live_values)(const void *params, int which, size_t width, size_t count, const double *t,
                        const double *q, const double *v, const double *u, double *out)
{
    const size_t n = pk_system_count(live_system, params), n_u = live_system->n_inputs;
    pk_kernel *const kernel = which ? live_system->conserve : live_system->observe;
    if (which == 2 ? !live_system->energy : !kernel)
        return 0;
    for (size_t k = 0; k < count; k++, q += n, v += n, u += n_u)
        if (which == 2)
            out[k] = live_system->energy(params, t[k], q, v, u);
        else
            kernel(params, t[k], q, v, u, out + k * width);
    return 1;
}

/* Writes the states at `times`, each reached by at most `budget` steps. Returns the number of rows
 * written; *status is the result of the last live_to(). */
size_t EXPORT(live_rows)(struct live *m, size_t n, size_t count, const double *times, double budget,
                         double *q, double *v, int *status)
{
    for (size_t k = 0; k < count; k++) {
        *status = live_to(m, times[k], budget);
        if (*status)
            return k;
        memcpy(q + k * n, live_q(m), n * sizeof *q);
        memcpy(v + k * n, live_v(m), n * sizeof *v);
    }
    return count;
}
