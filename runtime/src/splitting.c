/* Splitting methods for separable systems, M constant and a = a(q, t): compositions of
 *
 *     kick   v += kappa h a(q, t)          drift   q += delta h v,  t += delta h
 *
 * Time moves with the drift, as a coordinate of its own would, so a kick sees the time that
 * belongs to its q and the order holds for driven systems too. The last acceleration of a step
 * is the first of the next. Sums are compensated.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. ("GNI"),
 * I.1, II.4; L. Verlet, Phys. Rev. 159 (1967) 98; H. Yoshida, Phys. Lett. A 150 (1990) 262.
 */
#include <string.h>

#include "internal.h"
#include "tableau.h"

size_t pk_splitting_size(const struct pk_method *method, size_t n)
{
    (void)method;
    (void)n;
    return 0;
}

enum pk_status pk_splitting_init(struct pk_integrator *it)
{
    (void)it;
    return PK_DONE;
}

enum pk_status pk_splitting_step(struct pk_integrator *it, pk_real limit)
{
    const struct pk_splitting *table = (const struct pk_splitting *)it->method->table;
    const size_t n = it->n;
    const pk_real h = it->h;
    pk_real *q = pk_part(it->next, n, PK_Q), *v = pk_part(it->next, n, PK_V);
    pk_real *low_q = pk_part(it->next, n, PK_LOW_Q), *low_v = pk_part(it->next, n, PK_LOW_X);
    pk_real *a = pk_part(it->next, n, PK_A);
    pk_real done = 0; /* fraction of the step drifted so far */
    int have_a = it->flags & PK_HAVE_A;
    enum pk_status status = PK_DONE;
    (void)limit;

    memcpy(it->next, it->state, PK_PARTS * n * sizeof *q);
    for (int i = 0; i <= table->stages; i++) {
        const pk_real kappa = table->kick[i] * h;
        if (kappa > 0 || kappa < 0) {
            if (!have_a) {
                const pk_real t = i == table->stages ? it->next_t : it->t + done * h;
                status = pk_eval_acceleration(it, t, q, v, a);
                if (status < 0)
                    break;
            }
            for (size_t k = 0; k < n; k++)
                v[k] = pk_sum(v[k], kappa * a[k], &low_v[k]);
            have_a = 1;
        }
        if (i < table->stages) {
            const pk_real delta = table->drift[i] * h;
            for (size_t k = 0; k < n; k++)
                q[k] = pk_sum(q[k], delta * v[k], &low_q[k]);
            done += table->drift[i];
            have_a = 0;
        }
    }
    /* The cached acceleration travels with the state, so a failure here cannot spoil it. */
    if (status >= 0 && pk_all_finite(it->next, PK_P * n))
        it->flags = have_a ? it->flags | PK_HAVE_A : it->flags & ~PK_HAVE_A;
    return status;
}

#define SPLITTING(symbol, label, text, p, s, more, kicks, drifts)                             \
    static const struct pk_splitting symbol##_table = {s, kicks, drifts};                     \
    const struct pk_method pk_##symbol = {.name = label,                                      \
                                          .doc = text,                                        \
                                          .order = p,                                         \
                                          .stages = s,                                        \
                                          .traits = PK_SYMPLECTIC | (more),                   \
                                          .needs = PK_MASS_CONSTANT | PK_SEPARABLE,           \
                                          .table = &symbol##_table,                           \
                                          .size = pk_splitting_size,                          \
                                          .init = pk_splitting_init,                          \
                                          .step = pk_splitting_step}

static const pk_real one_kick[] = {PK_C(1.0), PK_C(0.0)};
static const pk_real one_drift[] = {PK_C(1.0)};
SPLITTING(symplectic_euler, "symplectic_euler",
          "symplectic Euler, kick first; R. de Vogelaere (1956), GNI I.1.9", 1, 1, 0, one_kick,
          one_drift);

static const pk_real verlet_kick[] = {PK_C(0.5), PK_C(0.5)};
SPLITTING(verlet, "verlet", "velocity Verlet (Stormer, leapfrog); Phys. Rev. 159 (1967) 98", 2, 1,
          PK_SYMMETRIC, verlet_kick, one_drift);

/* Triple jump: w1 = 1/(2 - 2^(1/3)), w0 = 1 - 2 w1; kicks w1/2, (w1 + w0)/2, .... */
static const pk_real yoshida4_kick[] = {
    PK_C(0.675603595979828817023843904485730413), PK_C(-0.175603595979828817023843904485730413),
    PK_C(-0.175603595979828817023843904485730413), PK_C(0.675603595979828817023843904485730413)};
static const pk_real yoshida4_drift[] = {PK_C(1.35120719195965763404768780897146083),
                                         PK_C(-1.70241438391931526809537561794292165),
                                         PK_C(1.35120719195965763404768780897146083)};
SPLITTING(yoshida4, "yoshida4", "triple jump of Verlet; H. Yoshida, Phys. Lett. A 150 (1990) 262",
          4, 3, PK_SYMMETRIC, yoshida4_kick, yoshida4_drift);
