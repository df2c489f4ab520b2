/* Residuals of constraints, the check of a start, and texts for failures; see pk/constraint.h. */
#include <stdio.h>
#include <string.h>

#include <pk/constraint.h>

#include "../core/project.h"

enum { SHOWN = 8 };
/* if a row is a sum of multiples of other rows, factors below this count as 0 */
#define SHARE PK_C(1e-6)

size_t pk_constraint_size(const struct pk_problem *problem)
{
    if (!problem || !problem->system || problem->system->abi != PK_ABI)
        return 0;
    const size_t n = pk_count_of(problem);
    return (pk_project_size(problem, n) + problem->system->n_inputs + 1) * sizeof(pk_real);
}

/* Uses the caller's block: it holds the memory of the projection, then the inputs. */
static enum pk_status begin(struct pk_projection *w, const struct pk_problem *problem, pk_real t,
                            const pk_real *q, const pk_real *v, void *block, size_t size)
{
    if (!problem || !problem->system || problem->system->abi != PK_ABI || !q || !v || !block)
        return PK_BAD_ARGUMENT;
    if (size < pk_constraint_size(problem) || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    const size_t n = pk_count_of(problem);
    pk_real *u = (pk_real *)block + pk_project_size(problem, n);
    pk_input(problem, t, u);
    *w = pk_project_parts(problem, n, (pk_real *)block);
    w->t = t;
    w->u = u;
    return PK_DONE;
}

static pk_real norm_error(const struct pk_projection *w, const pk_real *v, size_t rotation)
{
    const struct pk_turning at = pk_system_turning(w->system, w->params, rotation);
    pk_real norm2 = 0;
    for (size_t k = 0; k < 4; k++)
        norm2 += v[at.number + k * at.step] * v[at.number + k * at.step];
    return pk_abs(norm2 - 1) / (1 + PK_F(sqrt)(norm2));
}

enum pk_status pk_constraint_residuals(const struct pk_problem *problem, pk_real t,
                                       const pk_real *q, const pk_real *v,
                                       struct pk_residuals *found, void *block, size_t size)
{
    struct pk_projection w;
    PK_TRY(begin(&w, problem, t, q, v, block, size));
    if (!found)
        return PK_BAD_ARGUMENT;
    memset(found, 0, sizeof *found);
    for (size_t r = 0; r < pk_system_rotations(w.system, w.params); r++)
        if (norm_error(&w, v, r) > found->norm)
            found->norm = norm_error(&w, v, r), found->rotation = r;
    if (!w.c)
        return pk_finite(found->norm) ? PK_DONE : PK_NOT_FINITE;
    pk_project_rows(&w, q, v);
    pk_project_terms(&w, q, v);
    found->position_relative = pk_project_worst(w.phi, w.phi_size, w.h, &found->position_row);
    found->position = w.h ? pk_abs(w.phi[found->position_row]) : 0;
    found->rate_relative = pk_project_worst(w.rate, w.rate_size, w.c, &found->rate_row);
    found->rate = pk_abs(w.rate[found->rate_row]);
    return pk_all_finite(w.phi, w.h) && pk_all_finite(w.rate, w.c) && pk_finite(found->norm)
               ? PK_DONE
               : PK_NOT_FINITE;
}

enum pk_status pk_constraint_multipliers(const struct pk_problem *problem, pk_real t,
                                         const pk_real *q, const pk_real *v, pk_real *lambda,
                                         void *block, size_t size)
{
    struct pk_projection w;
    PK_TRY(begin(&w, problem, t, q, v, block, size));
    if (!lambda)
        return PK_BAD_ARGUMENT;
    if (!w.c || !w.system->constraints.multipliers)
        return PK_REFUSED;
    w.system->constraints.multipliers(w.params, t, q, v, w.u, lambda);
    return pk_all_finite(lambda, w.c) ? PK_DONE : PK_NOT_FINITE;
}

enum pk_status pk_constraint_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    int moved;
    return it->own->project ? pk_project(it, t, q, v, NULL, NULL, &moved) : PK_DONE;
}

/* Returns 1 + the index of the first row of the constraint Jacobian J that is zero up to the effect
 * of rounding errors of q, or 0 if there is none. */
static size_t nothing(struct pk_projection *w, const pk_real *q, const pk_real *v, pk_real *near)
{
    for (size_t k = 0; k < w->rotation; k++)
        near[k] = q[k] * (1 + 64 * PK_EPS);
    w->system->constraints.jacobian(w->params, w->t, near, v, w->u, w->W, w->mu);
    size_t found = 0;
    for (size_t i = w->c; i-- > 0;) {
        pk_real size = 0, change = 0;
        for (size_t k = 0; k < w->m; k++) {
            size += pk_abs(w->J[i * w->n + k]);
            change += pk_abs(w->J[i * w->n + k] - w->W[i * w->n + k]);
        }
        found = size <= change ? i + 1 : found;
    }
    return found;
}

enum pk_status pk_project_start(struct pk_integrator *it)
{
    pk_real *q = pk_state(it, PK_Q), *v = pk_state(it, PK_V);
    int moved;
    if (!it->own->project)
        return PK_DONE;
    struct pk_projection w = pk_projection(it);
    pk_zero(w.most, w.c);
    pk_zero(w.sizes, w.whole ? w.c * w.n : 0);
    w.t = it->t;
    w.u = pk_eval_input(it, it->t);
    for (size_t r = 0; r < pk_system_rotations(w.system, w.params); r++)
        if (!(norm_error(&w, v, r) <= PK_WRITTEN))
            return pk_fail_with(
                it, PK_OFF_CONSTRAINTS,
                PK_WHY(.kind = PK_REASON_QUATERNION, .index = r, .value = norm_error(&w, v, r)));
    if (!w.c)
        return pk_project(it, it->t, q, v, NULL, NULL, &moved);
    w.depends[0] = 0;
    if (PK_SYSTEM_HAS(w.system, consistent) && !it->count.steps &&
        !pk_project_nearest(&w, q, v, pk_next(it, PK_Q)))
        return pk_fail_with(it, PK_NO_PROJECTION, PK_WHY(.kind = PK_REASON_NO_START));
    const int singular = pk_project_inertia(&w, q, v);
    if (singular)
        return pk_eval_failed(it, it->t, q, v, singular);
    pk_project_rows(&w, q, v);
    pk_project_terms(&w, q, v);
    pk_project_slopes(&w, q, v, w.J, w.c, w.mu);
    if (!pk_all_finite(w.mu, w.c)) /* J is not finite */
        return pk_fail_with(it, PK_OFF_CONSTRAINTS, PK_WHY(.value = (pk_real)NAN));
    size_t row =
        pk_project_broken(&w, w.phi, w.phi_size, w.mu, w.h, q, 0, pk_project_passed(it, &w));
    const size_t off = pk_project_broken(&w, w.rate, w.rate_size, w.mu, w.c, v, 1,
                                         pk_project_rest(it, &w, q));
    size_t depends = w.whole && !w.system->contacts.modes ? nothing(&w, q, v, w.d) : 0;
    if (depends)
        w.depends[0] = (pk_real)depends, pk_zero(w.depends + 1, w.c);
    else
        depends = pk_project_factor(&w, w.c, q, v);
    if (w.inertia)
        return pk_eval_failed(it, it->t, q, v, w.inertia);
    if (row < w.h)
        return pk_fail_with(it, PK_OFF_CONSTRAINTS,
                            PK_WHY(.kind = PK_REASON_ROW, .index = pk_project_row(&w, row), .value = w.phi[row]));
    row = off;
    if (row < w.c)
        return pk_fail_with(it, PK_OFF_CONSTRAINTS,
                            PK_WHY(.kind = PK_REASON_ROW_RATE, .index = pk_project_row(&w, row), .value = w.rate[row]));
    if (depends)
        return pk_fail_with(it, PK_NO_PROJECTION, PK_WHY(.index = depends - 1));
    PK_TRY(pk_project(it, it->t, q, v, NULL, NULL, &moved));
    return pk_project_redundant(it, it->t, q, v, PK_OFF_CONSTRAINTS);
}

static int named(const struct pk_quantity *names, size_t n, size_t row, char *text, size_t size)
{
    static const char force[] = "lambda_";
    const char *name = names && row < n ? names[row].name : "";
    if (strncmp(name, force, sizeof force - 1) == 0)
        name += sizeof force - 1;
    return *name ? snprintf(text, size, "%s", name) : snprintf(text, size, "number %zu", row + 1);
}

int pk_constraint_name(const struct pk_system *system, const void *params, size_t row, char *text,
                       size_t size)
{
    const struct pk_part_constraints *c = &system->constraints;
    struct pk_range range = {0, 1, 0};
    size_t k = 0;
    if (!c->count)
        return named(c->names, c->n, row, text, size);
    for (; k < c->n_declared; k++) {
        system->families.range(params, PK_OF_ROW, k, &range);
        if (row < range.count)
            break;
        row -= range.count;
    }
    const int length = named(c->names, c->n_declared, k, text, size);
    const size_t at = (size_t)length < size ? (size_t)length : size;
    return length + (range.is_family ? snprintf(at < size ? text + at : NULL, size - at, "[%td]",
                                                range.lo + (ptrdiff_t)row)
                                     : 0);
}

/* Writes the names of the rows on which the dependent row depends: "a, b". */
static void of_others(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_projection w = pk_projection(it);
    char name[96];
    size_t used = 0;
    int count = 0;
    text[0] = 0;
    if (!w.c || !(w.depends[0] > 0))
        return;
    const size_t last = w.whole ? pk_index(w.depends[0] - 1, w.c) : w.c;
    for (size_t i = 0; i < last && used < size; i++)
        if (pk_abs(w.depends[1 + i]) > SHARE) {
            if (count == SHOWN) { /* lists no more than SHOWN rows */
                snprintf(text + used, size - used, ", ...");
                break;
            }
            pk_constraint_name(w.system, w.params, i, name, sizeof name);
            used += (size_t)snprintf(text + used, size - used, "%s%s", count++ ? ", " : "", name);
        }
}

/* Returns whether a row of J is linearly independent of the previous rows although the
 * factorisation of J M^-1 J^T has found no pivot for it. */
static int inertia_hides(const struct pk_integrator *it, size_t row)
{
    struct pk_projection w = pk_projection(it);
    if (!w.whole)
        return 0;
    pk_project_rank(&w);
    return w.sines[row] > PK_DEPENDENT;
}

/* Writes to the caller's text, then the last valid time. */
#define SAY(...) pk_say(it, text, size, __VA_ARGS__)

int pk_project_reason(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_system *system = it->problem.system;
    const struct pk_reason *reason = &it->reason;
    const size_t c = pk_system_rows(system, it->problem.params, 0);
    const size_t row = reason->index % (c ? c : 1); /* a restored index may be out of range */
    const char *what = pk_status_text(it->status);
    const char *alone = system->constraints.count
                            ? "; families kept as loops take no rows that follow from others"
                            : "";
    const double value = (double)reason->value;
    char name[128], others[256], more[512] = "";
    switch (reason->kind) {
    case PK_REASON_REDUNDANT:
    case PK_REASON_REDUNDANT_RATE:
        named(system->constraints.redundant_names, system->constraints.n_redundant, reason->index,
              name, sizeof name);
        return SAY("%s: %s follows from the others where the model starts, not "
                   "here: %sit is broken by %.3g",
                   what, name, reason->kind == PK_REASON_REDUNDANT ? "" : "as rates go, ", value);
    case PK_REASON_BRANCH:
        pk_constraint_name(system, it->problem.params, row, name, sizeof name);
        return SAY("%s: at t = %.9g %s ends or depends on others, and behind it the branch of "
                   "the motion cannot be told",
                   what, (double)reason->time, name);
    case PK_REASON_NO_START:
        return SAY("%s: no start on them is found near the given values", what);
    case PK_REASON_NO_ROW:
        return SAY("%s", what);
    case PK_REASON_QUATERNION:
        if (reason->index >= pk_system_rotations(system, it->problem.params))
            return SAY("%s", what);
        pk_system_name(system, it->problem.params, system->rates,
                       pk_system_turning(system, it->problem.params, reason->index).rate, name,
                       sizeof name);
        const char *of = strncmp(name, "omega(", 6) == 0 ? name + 6 : name;
        return snprintf(text, size, "%s: the quaternion of %.*s is not of unit length, by %.3g",
                        what, (int)strcspn(of, ")."), of, value);
    default:
        break;
    }
    pk_constraint_name(system, it->problem.params, row, name, sizeof name);
    of_others(it, others, sizeof others);
    if (it->status == PK_OFF_CONSTRAINTS) {
        const struct pk_projection w = pk_projection(it);
        char last[96];
        if (w.depends[0] > 0) {
            pk_constraint_name(system, w.params, pk_index(w.depends[0] - 1, w.c), last,
                               sizeof last);
            snprintf(more, sizeof more, "; and %s depends on %s%s", last,
                     *others ? others : "nothing that moves", alone);
        }
        char whole[1024];
        snprintf(whole, sizeof whole, "%s: %s%s by %.3g%s", what, name,
                 reason->kind == PK_REASON_ROW_RATE ? ", as rates go," : "", value, more);
        return it->count.steps ? SAY("%s", whole) : snprintf(text, size, "%s", whole);
    }
    if (*others && inertia_hides(it, row))
        return SAY("%s: beside %s the multiplier of %s loses all digits: by their inertia these "
                   "rows are all but one",
                   what, others, name);
    if (*others)
        return SAY("%s: %s depends on %s%s", what, name, others, alone);
    if (pk_projection(it).depends[0] > 0)
        return SAY("%s: nothing that moves enters %s", what, name);
    return SAY("%s: %s is left broken by %.3g", what, name, value);
}
