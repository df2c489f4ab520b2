/* One correction of V and of the kick in a variational step: with the matrix M, or with Newton's
 * matrix from differences and the exact derivatives of phi; see variational_solve.c. */

#include "variational.h"

static size_t unknowns(const struct pk_variational_work *w) { return w->m + (w->n - w->states); }
static size_t place(const struct pk_variational_work *w, size_t i)
{
    return i < w->m ? i : i - w->m + w->states;
}

/* Solves the linear system of the iteration for x, in place. */
static void solve(const struct pk_variational_work *w, int newton, pk_real *x)
{
    if (!newton) {
        pk_variational_by_mass(w, x);
        return;
    }
    for (size_t i = w->m; i < unknowns(w); i++)
        x[i] = x[place(w, i)];
    pk_lu_solve(w->lu, w->pivot, unknowns(w), x);
    for (size_t i = unknowns(w); i-- > w->m;) {
        const pk_real state = x[i];
        x[i] = 0;
        x[place(w, i)] = state;
    }
}

/* Computes dr/dV by differences and factors it, then restores the end of V. Returns the sign of its
 * determinant, or 0 if it is singular. */
static int differences(struct pk_integrator *it, struct pk_variational_work *w)
{
    const size_t count = unknowns(w);
    const pk_real e = PK_F(sqrt)(PK_EPS), more = PK_VARIATIONAL_SHARE * pk_largest(w->scale, w->n);
    pk_real *column = w->spare;
    for (size_t j = 0; j < count; j++) {
        const size_t k = place(w, j);
        const pk_real V = w->V[k], own = w->scale[k] + more, d = e * (own > 0 ? own : 1);
        w->V[k] = V + d;
        const int finite = pk_variational_evaluate(it, w);
        pk_variational_residual(w, column);
        w->V[k] = V;
        if (!finite)
            return 0;
        for (size_t i = 0; i < count; i++)
            w->lu[i * count + j] = (column[place(w, i)] - w->dV[place(w, i)]) / d;
    }
    pk_variational_reach(w);
    it->count.jacobians++;
    it->count.factorisations++;
    int sign = 0;
    if (pk_lu_factor(w->lu, w->pivot, count))
        pk_lu_determinant(w->lu, w->pivot, count, &sign);
    return sign;
}

/* Computes a row of d(phi)/dV. */
static void end_by_rates(const struct pk_variational_work *w, const pk_real *J, pk_real *row)
{
    for (size_t k = 0; k < w->rotation; k++)
        row[k] = w->h * J[k];
    for (size_t k = w->rotation; k < w->m; k += 3) {
        pk_real y[3], both[3], across[3];
        pk_variational_y(w, w->V + k, y);
        const pk_real weight = w->h / 2 / (1 + pk_dot3(y, y));
        pk_cayley_turn(y, 1, J + k, both);
        for (size_t l = 0; l < 3; l++)
            both[l] += J[k + l];
        pk_cross(y, both, across);
        for (size_t l = 0; l < 3; l++)
            row[k + l] = weight * (both[l] + across[l]);
    }
}

/* Computes the change of V by a kick along a row of J(q0), turned into the frame of the middle. */
static void rates_by_kick(const struct pk_variational_work *w, int newton, const pk_real *J,
                          pk_real *by)
{
    pk_copy(by, J, w->m);
    pk_zero(by + w->m, w->n - w->m);
    for (size_t k = w->rotation; k < w->m; k += 3) {
        pk_real y[3];
        pk_variational_y(w, w->V + k, y);
        pk_cayley_turn(y, -1, by + k, by + k);
    }
    solve(w, newton, by);
}

/* Corrects dV, and the kick, so that phi vanishes at the end of V + dV. Returns the sign of the
 * determinant of phi's matrix (1 at h = 0), a factor of the whole determinant; 0 if singular. */
static int constrain(struct pk_variational_work *w, int newton)
{
    const size_t n = w->n, c = w->c;
    pk_real *row = w->spare, *A = w->at.A, *by = w->at.W, *mu = w->at.mu;
    for (size_t j = 0; j < c; j++)
        rates_by_kick(w, newton, w->J + j * n, by + j * n);
    for (size_t i = 0; i < c; i++) {
        end_by_rates(w, w->at.J + i * n, row);
        mu[i] = -w->at.phi[i];
        for (size_t k = 0; k < w->m; k++)
            mu[i] -= row[k] * w->dV[k];
        for (size_t j = 0; j < c; j++)
            A[i * c + j] = pk_dot(row, by + j * n, w->m);
    }
    if (!pk_lu_factor(A, w->A_pivot, c))
        return 0;
    pk_lu_solve(A, w->A_pivot, c, mu);
    pk_add(w->kick, 1, mu, c);
    for (size_t j = 0; j < c; j++)
        pk_add(w->dV, mu[j], by + j * n, n);
    int sign;
    pk_lu_determinant(A, w->A_pivot, c, &sign);
    return w->h < 0 && c % 2 ? -sign : sign;
}

/* For families: solves with [M J^T; J 0] of the start. J at the end is near that. */
static void constrain_by_mass(const struct pk_variational_work *w)
{
    pk_real *mu = w->at.mu;
    for (size_t i = 0; i < w->c; i++)
        mu[i] = -w->at.phi[i] / w->h;
    w->at.system->constraints.solve(w->at.params, w->dV, mu, w->dV, mu);
    pk_add(w->kick, 1, mu, w->c);
}

int pk_variational_correction(struct pk_integrator *it, struct pk_variational_work *w, int newton)
{
    int sign = newton ? differences(it, w) : 1;
    if (!sign)
        return 0;
    for (size_t k = 0; k < w->n; k++)
        w->dV[k] = -w->dV[k];
    it->count.iterations++;
    if (w->c && !w->whole) {
        constrain_by_mass(w);
        return sign;
    }
    solve(w, newton, w->dV);
    return w->c ? sign * constrain(w, newton) : sign;
}
