/* The tables: every rooted tree up to the order claimed (HNW II.2: sum b_i Phi_i(tree) =
 * 1/density), and one of the order above must fail; symplecticity and symmetry of Gauss (GNI
 * VI.4, V.2). Trees come as level sequences, by the successor rule of T. Beyer, S. Hedetniemi,
 * SIAM J. Comput. 9 (1980) 706.
 */
#include "fixture.h"
#include "core/tableau.h"

#include <pk/step/gauss_tables.h>

#define MOST 18

struct dense_table {
    int s;
    double a[MOST][MOST], b[MOST], c[MOST];
};

static void weight(const struct dense_table *t, const int *level, int first, int order, double *phi,
                   double *density)
{
    /* The subtree rooted at `first`: phi_i = product over children of sum_j a_ij phi_child_j. */
    int size = 1;
    while (first + size < order && level[first + size] > level[first])
        size++;
    for (int i = 0; i < t->s; i++)
        phi[i] = 1;
    *density *= size;
    for (int k = first + 1; k < first + size; k++) {
        double child[MOST];
        if (level[k] != level[first] + 1)
            continue;
        weight(t, level, k, order, child, density);
        for (int i = 0; i < t->s; i++) {
            double sum = 0;
            for (int j = 0; j < t->s; j++)
                sum += t->a[i][j] * child[j];
            phi[i] *= sum;
        }
    }
}

static int next_tree(int *level, int order)
{
    int p = order - 1;
    while (p > 0 && level[p] <= 1)
        p--;
    if (p <= 0)
        return 0;
    int q = p - 1;
    while (level[q] != level[p] - 1)
        q--;
    for (int i = p; i < order; i++)
        level[i] = level[i - (p - q)];
    return 1;
}

/* Largest defect over all trees of an order; how many there are. */
static double defect(const struct dense_table *t, int order, int *trees)
{
    int level[MOST];
    double worst = 0;
    for (int i = 0; i < order; i++)
        level[i] = i;
    *trees = 0;
    do {
        double phi[MOST], density = 1, sum = 0;
        weight(t, level, 0, order, phi, &density);
        for (int i = 0; i < t->s; i++)
            sum += t->b[i] * phi[i];
        worst = fmax(worst, fabs(sum - 1 / density));
        ++*trees;
    } while (next_tree(level, order));
    return worst;
}

static void check_order(const char *name, const struct dense_table *t, int order)
{
    static const int known[] = {0,   1,   1,    2,    4,     9,     20,    48,     115,
                                286, 719, 1842, 4766, 12486, 32973, 87811, 235381, 634847};
    int trees;
    for (int p = 1; p <= order; p++) {
        CU_ASSERT(defect(t, p, &trees) < 3e-14);
        CU_ASSERT(trees == known[p]);
    }
    const double above = defect(t, order + 1, &trees);
    CU_ASSERT(above > 1e-10);
    printf("\n    %s: order %d, next defect %.2e (%d trees)", name, order, above, trees);
    for (int i = 0; i < t->s; i++) {
        double row = 0;
        for (int j = 0; j < t->s; j++)
            row += t->a[i][j];
        CU_ASSERT(fabs(row - t->c[i]) < 4e-14);
    }
}

TEST("explicit Runge-Kutta: all rooted trees")
{
    int found = 0;
    for (size_t m = 0; pk_method_at(m); m++) {
        const struct pk_method *method = pk_method_at(m);
        const struct pk_tableau *table = pk_explicit_table(method);
        if (!table)
            continue;
        found++;
        struct dense_table t = {.s = table->stages};
        const pk_real *a = table->a;
        for (int i = 0; i < t.s; i++) {
            t.b[i] = table->b[i];
            t.c[i] = table->c[i];
            for (int j = 0; j < i; j++)
                t.a[i][j] = *a++;
        }
        CU_ASSERT(method->stages == t.s);
        check_order(method->name, &t, method->order);
        if (!table->e)
            continue;
        /* Embedded: weights b - e (and the derivative at the end as a last stage). */
        struct dense_table e = t;
        for (int j = 0; j < t.s; j++)
            e.a[t.s][j] = t.b[j];
        e.s++;
        e.c[t.s] = 1;
        for (int j = 0; j <= t.s; j++)
            e.b[j] = (j < t.s ? t.b[j] : 0) - table->e[j];
        check_order("  its estimate", &e, table->e3 ? 5 : 4);
        if (table->e3) {
            for (int j = 0; j <= t.s; j++)
                e.b[j] = (j < t.s ? t.b[j] : 0) - table->e3[j];
            check_order("  its second", &e, 3);
        }
    }
    CU_ASSERT(found == 6);
    /* The check sees a wrong digit. */
    struct dense_table bad = {.s = 1, .b = {1.000001}};
    int trees;
    CU_ASSERT(defect(&bad, 1, &trees) > 1e-7);
}

/* Dense output: weights b_i(s) of the interpolant at s, over all stages; sum b_i(s) Phi_i =
 * s^p / density up to its order, and not one further. */
TEST("dense output: all rooted trees")
{
    static const char *const names[] = {"dopri5", "dop853"};
    for (size_t m = 0; m < 2; m++) {
        const struct pk_method *method = pk_method_find(names[m]);
        const struct pk_tableau *table = (const struct pk_tableau *)method->table;
        const int end = table->stages, all = end + 1 + table->extra;
        const pk_real *a = table->a, *more = table->extra_a;
        struct dense_table t = {.s = all};
        for (int i = 0; i < end; i++)
            for (int j = 0; j < i; j++)
                t.a[i][j] = *a++;
        for (int j = 0; j < end; j++)
            t.a[end][j] = table->b[j];
        for (int i = end + 1; i < all; i++)
            for (int j = 0; j < i; j++)
                t.a[i][j] = *more++;
        for (double s = 0.15; s < 1; s += 0.2) {
            double worst = 0, scale = 1;
            int trees;
            for (int i = 0; i < all; i++) {
                const double b = i < end ? table->b[i] : 0, bend = (i == 0) - b;
                double r[8] = {0, b, bend, b - (i == end) - bend}, y = 0;
                for (int j = 0; j < table->rows; j++)
                    r[4 + j] = table->d[j * all + i];
                for (int j = 3 + table->rows; j >= 0; j--)
                    y = r[j] + (j % 2 ? 1 - s : s) * y;
                t.b[i] = y / s; /* the tree conditions are homogeneous: scale the step to 1 */
            }
            for (int p = 1; p <= method->dense_order; p++, scale *= s) {
                struct dense_table unit = t;
                for (int i = 0; i < all; i++)
                    for (int j = 0; j < all; j++)
                        unit.a[i][j] = t.a[i][j] / s;
                worst = fmax(worst, scale * defect(&unit, p, &trees));
            }
            CU_ASSERT(worst < 1e-14);
            struct dense_table unit = t;
            for (int i = 0; i < all; i++)
                for (int j = 0; j < all; j++)
                    unit.a[i][j] = t.a[i][j] / s;
            CU_ASSERT(scale * defect(&unit, method->dense_order + 1, &trees) > 1e-6);
            if (s < 0.2)
                printf("\n    %s: dense order %d, defect %.1e", names[m], method->dense_order,
                       worst);
        }
    }
}

TEST("Gauss: trees, symplectic, symmetric")
{
    static const char *const names[] = {"gauss1", "gauss2", "gauss3", "gauss4",
                                        "gauss5", "gauss6", "gauss7", "gauss8"};
    for (int m = 0; m < 8; m++) {
        const struct pk_method *method = pk_method_find(names[m]);
        const struct pk_gauss *table = (const struct pk_gauss *)method->table;
        const int s = table->stages;
        struct dense_table t = {.s = s};
        double mu[64];
        pk_collocation(table, t.c, t.b, mu);
        for (int i = 0; i < s; i++) {
            for (int j = 0; j < s; j++) {
                t.a[i][j] = mu[i * s + j] * t.b[j];
                CU_ASSERT(fabs(mu[i * s + j] + mu[j * s + i] - 1) < 1e-15);
                /* symmetry: a_{s+1-i,s+1-j} + a_ij = b_j */
                CU_ASSERT(fabs(mu[(s - 1 - i) * s + s - 1 - j] + mu[i * s + j] - 1) < 1e-15);
                if (j < i) /* what makes 1 - mu exact */
                    CU_ASSERT(mu[i * s + j] > 0.5 && mu[i * s + j] < 2);
            }
        }
        CU_ASSERT(s == method->stages && 2 * s == method->order);
        check_order(method->name, &t, method->order);
    }
    /* rk4 is not symplectic: b_i a_ij + b_j a_ji != b_i b_j. */
    const struct pk_tableau *rk4 = (const struct pk_tableau *)pk_method_find("rk4")->table;
    CU_ASSERT(fabs(rk4->b[1] * rk4->a[0] - rk4->b[0] * rk4->b[1]) > 0.01);
}

/* Beside the matrices of the 8 stages, whose order quad/order.c measures: what predicts the next
 * step and judges this one. A wrong digit there would only cost iterations, or tolerance. */
TEST("the lanes of 8 stages")
{
    const double *c = pk_gauss8_c;
    struct pk_gauss_matrices M;
    pk_gauss_make_matrices(&M);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            double power = 1;
            for (int k = 0; k < j; k++)
                power *= c[i];
            CU_ASSERT(fabs(M.powers[j * 8 + i] - power) < 4e-16);
        }
    for (int degree = 0; degree < 8; degree++) {
        double legendre[2] = {0, 0}, taylor[8] = {0}, binomial = 1;
        for (int i = 0; i < 8; i++) {
            const double y = 2 * c[i] - 1;
            double below = 0, here = 1, power = 1;
            for (int k = 0; k < degree; k++) {
                const double next = ((2 * k + 1) * y * here - k * below) / (k + 1);
                below = here, here = next, power *= c[i];
            }
            legendre[0] += M.legendre6[i] * here;
            legendre[1] += M.legendre7[i] * here;
            for (int k = 0; k < 8; k++) /* of x^degree at x = 1 */
                taylor[k] += M.taylor[i * 8 + k] * power;
        }
        CU_ASSERT(fabs(legendre[0] - (degree == 6)) < 1e-15);
        CU_ASSERT(fabs(legendre[1] - (degree == 7)) < 1e-15);
        for (int k = 0; k < 8; k++) {
            CU_ASSERT(fabs(taylor[k] - binomial) < 1e-10);
            binomial *= (double)(degree - k) / (k + 1);
        }
    }
}

TEST("splitting")
{
    /* Sums and symmetry; order conditions are in tests/runtime/test_compositions.py, and in every
     * order that is measured. Symplectic they are by what they are made of. */
    int found = 0;
    for (size_t m = 0; pk_method_at(m); m++) {
        const struct pk_method *method = pk_method_at(m);
        const struct pk_splitting *t = pk_splitting_table(method);
        double kick = 0, drift = 0, skew = 0;
        if (!t)
            continue;
        found++;
        CU_ASSERT(method->stages == t->stages);
        for (int i = 0; i <= t->stages; i++)
            kick += t->kick[i];
        for (int i = 0; i < t->stages; i++)
            drift += t->drift[i];
        for (int i = 0; i <= t->stages; i++)
            skew = fmax(skew, fabs(t->kick[i] - t->kick[t->stages - i]));
        for (int i = 0; i < t->stages; i++)
            skew = fmax(skew, fabs(t->drift[i] - t->drift[t->stages - 1 - i]));
        CU_ASSERT(fabs(kick - 1) < 2e-15 && fabs(drift - 1) < 2e-15);
        CU_ASSERT((method->traits & PK_SYMMETRIC) ? skew == 0 : skew > 0.5);
        CU_ASSERT((method->traits & PK_SYMPLECTIC) != 0);
    }
    CU_ASSERT(found == 11);
}

TEST("registry")
{
    size_t count = 0;
    for (; pk_method_at(count); count++) {
        const struct pk_method *m = pk_method_at(count);
        CU_ASSERT(pk_method_find(m->name) == m);
        const int exact = (m->traits & (PK_EXACT | PK_JETS)) != 0; /* or of any order */
        CU_ASSERT((m->order > 0) == !exact && (m->stages > 0) == !exact && strlen(m->doc) > 10);
        CU_ASSERT(!(m->traits & PK_DENSE) == !m->dense);
    }
    CU_ASSERT(count >= 34);
    CU_ASSERT_PTR_NULL(pk_method_find("rk5"));
    CU_ASSERT_PTR_NOT_NULL(pk_gsl_method_find("gsl_rk8pd"));
    CU_ASSERT_PTR_NOT_NULL(pk_gsl_method_find("gsl_msadams"));
    CU_ASSERT_PTR_NULL(pk_gsl_method_find("rk8pd"));
    for (count = 0; pk_gsl_method_at(count); count++)
        CU_ASSERT(strncmp(pk_gsl_method_at(count)->name, "gsl_", 4) == 0);
    CU_ASSERT(count == 5);
}
