/* Newton's matrix of the stage equations G(V) = 0 in gauss.c. It has the blocks
 *
 *     dG_i/dV_j = delta_ij M + h (a_ij p_q - a^_ij pdot_v) - h^2 sum_r a^_ir a_rj pdot_q
 *
 * with the derivatives at the stages: M and p_q at i, pdot_v at j, pdot_q at r; or in large systems
 * all at the mean of the stages, with an error of second order in h.
 *
 * References: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8; for the norm,
 * R. S. Varga, Matrix Iterative Analysis, 2.1 (Collatz, Wielandt). */

#include "gauss.h"

#define SMALL (PK_GAUSS_SURE / 4) /* the search for a bound ends at a bound below this */
/* the search for a bound also ends if a bound is above this fraction of the least one so far */
#define LITTLE PK_C(0.8)
#define TINY PK_F(sqrt)(PK_EPS)
#define SURELY_BELOW PK_C(0.2) /* three successive growth factors below this prove a radius < .5 */
#define SURELY_ABOVE PK_C(1.5)
enum { MOST_TURNS = 16, TURNS = 16 };

int pk_gauss_small(const struct pk_gauss_work *w) { return w->s * pk_gauss_read(w) <= 24; }

int pk_gauss_refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode)
{
    const size_t n_q = it->n_q, n = it->n, s = w->s;
    it->own->flags &= ~(PK_HAVE_LU | PK_REFRESH);
    it->count.factorisations++;
    if (mode == PK_BY_MASS) {
        pk_gauss_mass(it, it->t, it->q, it->v, w->jacobian);
        return pk_gauss_mass_factor(w, w->jacobian) == 0;
    }
    const int each = mode == PK_FULL || pk_gauss_small(w);
    if (each) {
        pk_gauss_stage_derivatives(it, w);
    } else {
        pk_zero(w->mean_q, n_q);
        pk_zero(w->mean_v, n);
        for (size_t i = 0; i < s; i++)
            for (size_t k = 0; k < n; k++) {
                if (k < n_q)
                    w->mean_q[k] += w->Q[i * n_q + k] / (pk_real)s;
                w->mean_v[k] += w->V[i * n + k] / (pk_real)s;
            }
        pk_gauss_derivatives(it, w, it->t + it->own->h / 2, w->mean_q, w->mean_v, w->jacobian);
    }
    /* In a stiff system the bound of the last step was no use, and branch.c computes another. */
    const pk_real last = w->kept->last_contraction;
    const int stiff = !w->pattern.dense && last > 4 * PK_GAUSS_SURE_ONCE && pk_finite(last);
    w->kept->contraction = stiff ? PK_INFINITY
                                 : pk_gauss_contraction(it, w, w->jacobian, each ? s : 1);
    w->kept->sure = 0;
    w->kept->fresh = 1;
    pk_gauss_matrix(w, w->jacobian, each ? 4 * w->nn : 0, 1, 1, &w->lu);
    w->kept->lu_h = it->own->h;
    if (!pk_band_factor(&w->lu))
        return 0;
    if (mode == PK_SIMPLIFIED)
        it->own->flags |= PK_HAVE_LU;
    return 1;
}

const pk_real *pk_gauss_equations(struct pk_integrator *it)
{
    const struct pk_gauss_work w = pk_gauss_parts(it);
    return it->own->flags & PK_HAVE_LU && w.pattern.dense ? w.lu.corner : NULL;
}

/* Computes an upper bound y of |M^-1 X| x. For |M^-1| it uses the inverse of the comparison matrix,
 * which is factored in w->M and bounds |M^-1| from above. */
static void add_sizes(const struct pk_gauss_work *w, const pk_real *M, const pk_real *x, pk_real *y)
{
    const size_t rows = w->pattern.rows, border = w->pattern.border, s = w->s;
    pk_zero(y, s * w->places);
    pk_band_add_sizes(&w->other, x, y);
    for (size_t i = 0; i < s && M; i++) {
        const struct pk_band band = pk_gauss_band(w, w->M + i * w->nn);
        for (size_t k = 0; k < rows; k++)
            w->z[k] = y[k * s + i];
        pk_copy(w->z + rows, y + rows * s + i * border, border);
        pk_band_ldl_solve(&band, w->z);
        for (size_t k = 0; k < rows; k++)
            y[k * s + i] = w->z[k];
        pk_copy(y + rows * s + i * border, w->z + rows, border);
    }
}

pk_real pk_gauss_norm(const struct pk_gauss_work *w, const pk_real *M)
{
    const size_t m = w->s * w->places;
    pk_real least = PK_INFINITY, *x = w->x, *y = w->y;
    for (size_t i = 0; i < m; i++)
        x[i] = 1;
    for (int turn = 0; turn < MOST_TURNS && least > SMALL; turn++) {
        pk_real most = 0, sum = 0;
        add_sizes(w, M, x, y);
        for (size_t i = 0; i < m; i++) {
            if (!(y[i] <= most * x[i])) /* written so that a NaN is not lost */
                most = y[i] / x[i];
        }
        if (!pk_finite(most))
            return most;
        const int falls = most < LITTLE * least;
        least = pk_min(least, most);
        if (m == 1 || !(most > 0) || (turn >= 5 && !falls))
            break;
        /* A step of the power iteration, weakly damped: |X| may be cyclic, and x_i must grow fast
         * if row i depends on others but no row on it, as for the height of a rolling body. */
        for (size_t i = 0; i < m; i++) {
            x[i] += 3 * y[i] / most;
            sum = pk_max(sum, x[i]);
        }
        for (size_t i = 0; i < m; i++)
            x[i] /= sum;
    }
    return least;
}

/* Returns a bound of the contraction factor without solving equations. M = D^(1/2) C D^(1/2), where
 * D is the diagonal of M. Then |C^-1| <= e / det C, since the n eigenvalues of C are positive and
 * sum to n. The other factors are bounded by Frobenius norms and norms of the tableau. */
static pk_real quick_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                                 const pk_real *J, size_t count)
{
    const size_t n = w->places, across = w->across, nn = w->nn;
    const int separable = (it->problem.system->facts & PK_SEPARABLE) != 0;
    pk_real *ldl = w->M, *r = w->x, p_q = 0, pdot_q = 0, pdot_v = 0, least = 1;
    for (size_t k = 0; k < count; k++, J += 4 * nn) {
        pk_real det = 1, of_p_q = 0, of_pdot_q = 0, of_pdot_v = 0;
        if (n > 1) {
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < n; j++)
                    ldl[i * n + j] = J[i * across + j];
            if (pk_ldl_factor(ldl, n))
                return PK_INFINITY;
        } else if (!(J[0] > 0)) {
            return PK_INFINITY;
        }
        for (size_t i = 0; i < n; i++) {
            r[i] = 1 / J[i * across + i];
            if (n > 1)
                det *= ldl[i * n + i] * r[i];
        }
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++) {
                const pk_real *x = J + i * across + j, scale = r[i] * r[j];
                of_pdot_q += x[2 * nn] * x[2 * nn] * scale;
                if (!separable) {
                    of_p_q += x[nn] * x[nn] * scale;
                    of_pdot_v += x[3 * nn] * x[3 * nn] * scale;
                }
            }
        least = pk_min(least, det);
        p_q = pk_max(p_q, of_p_q);
        pdot_q = pk_max(pdot_q, of_pdot_q);
        pdot_v = pk_max(pdot_v, of_pdot_v);
        if (!pk_finite(of_p_q + of_pdot_q + of_pdot_v))
            return PK_INFINITY;
    }
    pk_real sum = w->norms[2] * PK_F(sqrt)(pdot_q);
    if (!separable)
        sum += w->norms[0] * PK_F(sqrt)(p_q) + w->norms[1] * PK_F(sqrt)(pdot_v);
    return n > 1 ? PK_C(2.72) * sum / least : sum;
}

pk_real pk_gauss_radius(const struct pk_gauss_work *w, pk_real shift)
{
    const size_t m = w->s * w->places;
    pk_real growth[TURNS], product = 1;
    unsigned long noise = 1;
    for (size_t i = 0; i < m; i++) {
        noise = (noise * 1103515245ul + 12345ul) & 0x7ffffffful;
        w->x[i] = noise & 0x10000ul ? 1 : -1;
    }
    for (int turn = 0; turn < TURNS; turn++) {
        pk_real size = 0;
        pk_zero(w->y, m);
        pk_band_add_product(&w->other, w->x, w->y);
        pk_band_solve(&w->lu, w->y);
        for (size_t i = 0; i < m; i++) {
            w->y[i] -= shift * w->x[i];
            if (!(pk_abs(w->y[i]) <= size)) /* written so that a NaN is not lost */
                size = pk_abs(w->y[i]);
        }
        if (!(size > TINY) || !pk_finite(size))
            return size;
        growth[turn] = size;
        if (turn >= 4) { /* if the radius is far from the threshold, a few iterations suffice */
            const pk_real one = growth[turn - 1], two = growth[turn - 2];
            const pk_real most = pk_max(size, pk_max(one, two));
            const pk_real least = pk_min(size, pk_min(one, two));
            if (most < SURELY_BELOW * shift || least > SURELY_ABOVE * shift)
                return most;
        }
        for (size_t i = 0; i < m; i++)
            w->x[i] = w->y[i] / size;
    }
    for (int turn = TURNS / 2; turn < TURNS; turn++)
        product *= growth[turn];
    return PK_F(pow)(product, PK_C(2.0) / TURNS);
}

/* Returns |M^-1 (J - M)|, for bands an upper bound. */
static pk_real contraction(const struct pk_gauss_work *w, const pk_real *J, size_t stride)
{
    const size_t n = w->places, s = w->s, m = s * n, banded = !w->pattern.dense;
    pk_gauss_matrix(w, J, stride, 1, 0, &w->other);
    for (size_t i = 0; i < s; i++, J += stride) {
        pk_real *M = w->M + (banded ? i * w->nn : 0);
        pk_copy(M, J, w->nn);
        if (banded)
            pk_gauss_compare(w, M);
        if (pk_gauss_mass_factor(w, M))
            return PK_INFINITY;
        for (size_t j = 0; j < m && !banded; j++) {
            pk_real *column = w->other.corner + i * n * m + j;
            for (size_t k = 0; k < n; k++)
                w->x[k] = column[k * m];
            pk_gauss_mass_solve(w, M, w->x);
            for (size_t k = 0; k < n; k++)
                column[k * m] = w->x[k];
        }
    }
    return pk_gauss_norm(w, banded ? w->M : NULL);
}

pk_real pk_gauss_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                             const pk_real *J, size_t count)
{
    const size_t stride = count > 1 ? 4 * w->nn : 0;
    if (!w->pattern.dense) {
        const pk_real norm = w->closed ? PK_INFINITY : contraction(w, J, stride);
        if (pk_finite(norm))
            return norm;
        /* Norms give no bound if M couples coordinates too strongly or if, with additional unknowns
         * (`closed`), the matrix at h = 0 is not only M. M^-1 J is not a band matrix; so the
         * spectral radius of J(0)^-1 J(h) - I is used instead. */
        it->own->flags &= ~PK_HAVE_LU;
        pk_gauss_matrix(w, J, stride, 0, 1, &w->lu);
        pk_gauss_matrix(w, J, stride, 1, 1, &w->other);
        return pk_band_factor(&w->lu) ? 2 * pk_gauss_radius(w, 1) : PK_INFINITY;
    }
    const pk_real quick = quick_contraction(it, w, J, count);
    if (quick <= PK_GAUSS_SURE || !pk_finite(quick))
        return quick;
    /* The quick bound is too large by a factor that changes little and is measured occasionally. */
    const pk_real guess = 2 * w->kept->loose * quick;
    if (w->kept->loose_for > 0 && guess <= PK_GAUSS_SURE) {
        w->kept->loose_for -= 1;
        return guess;
    }
    const pk_real norm = contraction(w, J, stride);
    w->kept->loose = norm / quick;
    w->kept->loose_for = 16;
    return norm;
}
