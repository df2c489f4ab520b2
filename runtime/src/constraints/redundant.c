/* Decides whether a residual is more than rounding, and whether redundant constraint rows, which
 * follow from other rows, are satisfied. A residual is measured relative to the sizes of its
 * terms, which the system computes. An initial state has a limited number of digits. A coordinate
 * or rate that should be 0 may be a rounding error of the largest one, in the metric of M, which
 * makes metres and radians comparable. */
#include "../core/project.h"

/* pk_project_rest() divides by the step size, but at least by this fraction of t */
#define SHORT PK_C(1e-6)
#define DEBRIS (64 * PK_EPS) /* rounding errors relative to the largest coordinate or rate */

static pk_real largest(const struct pk_projection *w, const pk_real *x, int of_rates)
{
    pk_real most = 0;
    for (size_t k = 0; k < w->m; k++) {
        const pk_real size = k < w->rotation || of_rates ? pk_abs(x[k]) : 1;
        most = pk_max(most, PK_F(sqrt)(pk_project_mass(w, k)) * size);
    }
    return most;
}

pk_real pk_project_rest(const struct pk_integrator *it, const struct pk_projection *w,
                        const pk_real *q)
{
    const pk_real t = it->own->next_t; /* SHORT bounds the quotient for tiny steps */
    const pk_real way = pk_max(pk_abs(t - it->t), SHORT * pk_abs(t));
    return way > 0 ? DEBRIS * largest(w, q, 0) / way : 0;
}

size_t pk_project_broken(const struct pk_projection *w, const pk_real *residual,
                         const pk_real *terms, const pk_real *slopes, size_t rows, const pk_real *x,
                         int of_rates, pk_real least)
{
    const pk_real most = pk_max(least, largest(w, x, of_rates));
    for (size_t i = 0; i < rows; i++)
        if (!(pk_abs(residual[i]) <= PK_WRITTEN * terms[i] + DEBRIS * slopes[i] * most))
            return i;
    return rows;
}

pk_real pk_project_passed(const struct pk_integrator *it, const struct pk_projection *w)
{
    return it->count.steps ? largest(w, pk_next(it, PK_Q), 0) : 0;
}

enum pk_status pk_project_redundant(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, enum pk_status status)
{
    const struct pk_system *system = it->problem.system;
    if (!it->own->project || !system->constraints.n_redundant)
        return PK_DONE;
    const size_t h = system->constraints.n_redundant_holonomic;
    struct pk_projection w = pk_projection(it);
    system->constraints.redundant(w.params, t, q, v, pk_eval_input(it, t), w.off, w.off_size,
                                  w.off_rows);
    pk_project_slopes(&w, q, v, w.off_rows, w.r, w.off_slopes);
    size_t row =
        pk_project_broken(&w, w.off, w.off_size, w.off_slopes, h, q, 0, pk_project_passed(it, &w));
    if (row < h)
        return pk_fail_with(it, status,
                            PK_WHY(.kind = PK_REASON_REDUNDANT, .index = row, .value = w.off[row]));
    row = pk_project_broken(&w, w.off + h, w.off_size + h, w.off_slopes, w.r, v, 1,
                            pk_project_rest(it, &w, q));
    if (row == w.r)
        return PK_DONE;
    return pk_fail_with(
        it, status,
        PK_WHY(.kind = PK_REASON_REDUNDANT_RATE, .index = row, .value = w.off[h + row]));
}
