/* By the kernel `linear` where the system has it, else by central differences, good to some
 * PK_EPSILON^(2/3).
 */
#include "jacobians.h"

#include <string.h>

size_t jacobians_size(const struct pk_problem *problem)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    const size_t exact = 2 * n + pk_system_linear_size(problem), differences = 4 * n;
    return exact > differences ? exact : differences;
}

static int differences(const struct pk_problem *problem, pk_real t, const pk_real *q,
                       const pk_real *v, const pk_real *u, pk_real *a_q, pk_real *a_v,
                       pk_real *work)
{
    const struct pk_system *system = problem->system;
    const size_t n = pk_system_count(system, problem->params);
    pk_real *y = work, *plus = y + 2 * n, *minus = plus + n;
    const pk_real delta = PK_F(cbrt)(PK_EPSILON);
    for (size_t j = 0; j < 2 * n; j++) {
        memcpy(y, q, n * sizeof *y);
        memcpy(y + n, v, n * sizeof *y);
        const pk_real x = y[j], h = delta * (PK_F(fabs)(x) > 1 ? PK_F(fabs)(x) : 1);
        y[j] = x + h;
        const pk_real up = y[j];
        if (system->acceleration(problem->params, t, y, y + n, u, plus))
            return 0;
        y[j] = x - h;
        if (system->acceleration(problem->params, t, y, y + n, u, minus))
            return 0;
        pk_real *const column = j < n ? a_q + j : a_v + (j - n);
        for (size_t i = 0; i < n; i++)
            column[i * n] = (plus[i] - minus[i]) / (up - y[j]);
    }
    return 1;
}

int jacobians_at(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                 const pk_real *u, pk_real *a_q, pk_real *a_v, pk_real *work)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    const enum pk_status status =
        pk_system_linear(problem, t, q, v, work, a_q, a_v, work + n, work + 2 * n);
    return status == PK_REFUSED ? differences(problem, t, q, v, u, a_q, a_v, work)
                                : status == PK_DONE;
}
