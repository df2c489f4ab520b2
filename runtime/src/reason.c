/* Describes a status in words, with the names and numbers that belong to it. */
#include <stdio.h>

#include <pk/constraint.h>

#include "events/events.h"
#include "core/project.h"
#include "core/tableau.h"

/* Write to the caller's text; SAY() adds the last valid time. Return the length. */
#define SAY(...) pk_say(it, text, size, __VA_ARGS__)
#define TELL(...) snprintf(text, size, __VA_ARGS__)

static const char *const bad_argument[] = {
    "",
    "a pointer is null",
    "the system is of another version of the interface, or has no coordinates",
    "the step must be positive and finite, and the least one not above the largest",
    "the tolerances must be finite and not negative, and one positive",
    "the start is not finite",
    "the time is not finite",
    "the time is outside the last step, or the method has no dense output",
    "an iteration is Newton's or fixed-point, its tolerance in [0, 1), its bound not negative",
    "a parameter was changed without prepare() after it",
};

static const struct pk_words *words(const struct pk_integrator *it)
{
    static const struct pk_words none = {"", "", "", "", "", ""};
    return it->options.words ? it->options.words : &none;
}

static const struct {
    unsigned fact;
    const char *text;
} fact_text[] = {
    {PK_AFFINE, "linear: its acceleration affine in q and v, with constant coefficients"},
    {PK_SEPARABLE, "separable: M constant, forces independent of the rates"},
    {PK_LINEAR_DRAG,
     "separable: M constant, forces independent of the rates, or linear in them with "
     "constant coefficients"},
    {PK_AFFINE_RATES, "of constant M, its forces affine in the rates"},
    {PK_MASS_CONSTANT, "of constant M"},
    {PK_FAST, "of which a part is named (statement `fast`)"},
    {PK_QUADRATIC, "of second degree in the rates"},
    {PK_SMOOTH, "smooth, without abs, min, max or step (use dop853, or stop and restart at kinks)"},
    {PK_VARIATIONAL, "variational: no forces besides those of L"},
    {PK_AUTONOMOUS, "autonomous: no explicit time and no inputs"},
    {PK_CONSERVATIVE, "conservative: its energy is constant"},
    {PK_MASS_DIAGONAL, "of diagonal M"},
    {PK_SERIES, "expandable in Taylor series: written out, without constraints, inputs and noise, "
                "and only with functions such as sin and exp"},
};

static int no_convergence(const struct pk_integrator *it, char *text, size_t size)
{
    const char *what = pk_status_text(it->status);
    const double h = (double)pk_abs(it->own->h), value = (double)it->reason.value;
    if (it->reason.kind == PK_BY_NEWTON)
        return SAY("%s: by Newton's method there is a solution up to a step of %.6g, not to "
                   "%.6g: make the step shorter%s",
                   what, value, h, words(it)->step);
    if (it->reason.kind == PK_OF_RATES)
        return SAY("%s: that of the rates from the momenta, after a correction of %.3g", what,
                   value);
    if (it->problem.system->families.diagonal && (it->method->traits & PK_HOLONOMIC))
        return SAY("%s: the one by M, after a correction of %.3g of the rates; it converges for "
                   "short steps alone, and families kept as loops have no other: take a step "
                   "shorter than %.6g, or gauss2",
                   what, value, h);
    return SAY("%s: the fixed-point one, after a correction of %.3g of the rates; it "
               "converges for short steps alone: use Newton's%s or a step shorter than %.6g",
               what, value, words(it)->newton, h);
}

static const char *const singularity_use[] = {
    [PK_SINGULARITY_COORDINATES] = "M is singular there",
    [PK_SINGULARITY_DIVISOR] = "they divide by it",
    [PK_SINGULARITY_ROOT] = "they take a root of it",
    [PK_SINGULARITY_LOGARITHM] = "they take its logarithm",
    [PK_SINGULARITY_ARC] = "their asin or acos ends there",
};

/* If the acceleration does not grow on the way to a division by zero, it seems to have a limit
 * there: the expression is undefined there, and the motion may go on. */
static int singular(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_system *system = it->problem.system;
    const void *params = it->problem.params;
    if (it->reason.index >= it->own->n_singularities)
        return SAY("%s", pk_status_text(it->status));
    const struct pk_singularity *singularity =
        &system->singularities.table[pk_system_singularity(system, params, it->reason.index).which];
    char name[128];
    pk_system_singularity_name(system, params, it->reason.index, name, sizeof name);
    if (singularity->kind == PK_SINGULARITY_CUT)
        return SAY("%s: %s jumps by 2 pi at t = %.17g, and the Lagrangian with it, so that no "
                   "motion follows: take the angle as a coordinate, or write a force, which "
                   "does not jump there",
                   pk_status_text(it->status), name, (double)it->reason.time);
    const int removable = singularity->kind == PK_SINGULARITY_DIVISOR &&
                          it->reason.kind == PK_REASON_BOUNDED;
    return SAY("%s: %s vanishes at t = %.17g, and %s%s", pk_status_text(it->status), name,
               (double)it->reason.time, singularity_use[singularity->kind],
               removable ? "; the acceleration stays finite on the way there: if the "
                           "expression has a limit, as sin(x)/x has, write it without the "
                           "division"
                         : "");
}

/* Writes which fact, kernel or side of a switch the method lacks. */
static int refused(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_system *system = it->problem.system;
    char name[128];
    for (size_t i = 0; i < sizeof fact_text / sizeof *fact_text; i++)
        if (pk_missing_facts(system, it->method) & fact_text[i].fact)
            return TELL("%s needs a system that is %s; %s is not", it->method->name,
                        fact_text[i].text, system->name);
    if (system->noise.n && !(it->method->traits & PK_NOISE))
        return TELL("%s takes no noise, and %s has some, on %s: take baoab, stochastic_verlet or "
                    "heun",
                    it->method->name, system->name, system->noise.names[0]);
    if (pk_sides_missing(it) && system->switches.impulses)
        return TELL("the rates of %s jump where one of its switches vanishes: make steps by "
                    "pk_events_step(), which does what follows there",
                    system->name);
    if (pk_sides_missing(it)) {
        pk_system_switch_name(system, it->problem.params, 0, name, sizeof name);
        return TELL("%s needs a smooth system; %s changes where %s vanishes: make steps by "
                    "pk_events_step(), which ends them there",
                    it->method->name, system->name, name);
    }
    if (system->families.n_sizes && (it->method->traits & PK_HOLONOMIC) &&
        pk_missing_kernel(system, it->method))
        return TELL(
            "%s needs M, which %s, a chain of lets, solves link by link: take dop853, or fewer "
            "members, which are written out",
            it->method->name, system->name);
    if (system->families.count && !system->families.jacobian && (it->method->traits & PK_JACOBIANS))
        return TELL("%s needs Jacobians, and those of %s, whose families are loops, are no "
                    "band: sums over pairs, lets beside constraints; take dop853",
                    it->method->name, system->name);
    if (!system->linear && (it->method->traits & PK_LINEAR))
        return TELL("%s needs the derivatives of the acceleration; %s has none", it->method->name,
                    system->name);
    if (pk_missing_kernel(system, it->method))
        return TELL("%s calls the kernel %s, which %s was compiled without", it->method->name,
                    pk_missing_kernel(system, it->method), system->name);
    if (system->n_inputs && (it->method->traits & PK_NO_INPUTS))
        return TELL("%s needs the derivative by time, and %s has inputs, whose is unknown",
                    it->method->name, system->name);
    if (system->contacts.n && (it->method->traits & PK_HOLONOMIC))
        return TELL("%s takes no constraints that hold at times, such as the contact %s: use gauss",
                    it->method->name, system->contacts.table[0].name);
    if (pk_rolls(system) && (it->method->traits & PK_HOLONOMIC)) {
        pk_constraint_name(system, it->problem.params,
                           pk_system_rows(system, it->problem.params, 1), name, sizeof name);
        return TELL("%s takes constraints of positions alone, and %s is one of the rates "
                    "(rolling): use gauss",
                    it->method->name, name);
    }
    if (it->n > PK_EXPONENTIAL_MOST &&
        (it->method->traits & PK_EXACT || pk_splitting_table(it->method)))
        return TELL("%s is for at most %d coordinates; %s has %zu", it->method->name,
                    PK_EXPONENTIAL_MOST, system->name, it->n);
    if (it->method->resolved)
        return SAY("crossings of events could be missed in steps of %.6g: give at most "
                   "%.6g",
                   (double)it->options.h, (double)it->reason.value);
    return TELL("%s: %s", it->method->name, pk_status_text(it->status));
}

/* Writes the names of all contacts. */
static const char *contacts_of(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_part_contacts *all = &it->problem.system->contacts;
    size_t used = 0;
    for (size_t k = 0; k < all->n && used < size; k++)
        used +=
            (size_t)snprintf(text + used, size - used, "%s%s", k ? ", " : "", all->table[k].name);
    return text;
}

int pk_integrator_reason(const struct pk_integrator *it, char *text, size_t size)
{
    const char *what = pk_status_text(it->status);
    const double t = (double)it->t, value = (double)it->reason.value;
    const double time = (double)it->reason.time;
    const size_t index = it->reason.index, kind = (size_t)it->reason.kind;
    const struct pk_system *system = it->problem.system;
    char name[128];

    switch (it->status) {
    case PK_BAD_ARGUMENT:
        if (it->reason.kind == BAD_PERIOD)
            return TELL("the sample block %s: its period, %.6g, must be positive and above the "
                        "round-off of the time, and its offset not negative",
                        system->samples.table[it->reason.index].name, (double)it->reason.value);
        if (it->reason.kind == BAD_SCALE)
            return TELL("%s: da/dq vanishes at the start, so it gives no step: give a largest "
                        "step%s, and a tolerance instead of a first step%s",
                        what, words(it)->max_step, words(it)->step);
        return TELL("%s: %s", what,
                    kind < sizeof bad_argument / sizeof *bad_argument ? bad_argument[kind] : "");
    case PK_REFUSED:
        return refused(it, text, size);
    case PK_OUT_OF_BOUNDS:
        if (index < system->n_parameters)
            return TELL("%s: %s", what, system->parameters[index].what.name);
        if (index > system->n_parameters)
            return TELL("%s: a size is too small, or memory for it is missing", what);
        return TELL("%s: what follows from the parameters is not finite", what);
    case PK_SINGULAR_MASS:
        pk_system_name(system, it->problem.params, index < it->n ? system->coordinates : NULL,
                       index, name, sizeof name);
        if (!pk_finite(it->reason.value))
            return SAY("%s: pivot of coordinate %s is not positive at t = %.17g", what, name, time);
        return SAY("%s: pivot of coordinate %s is %.3g of its diagonal entry at t = %.17g", what,
                   name, value, time);
    case PK_SINGULAR_TIME:
    case PK_SINGULAR_COORDINATES:
        return singular(it, text, size);
    case PK_STEP_TOO_LONG:
        snprintf(name, sizeof name, "a singularity");
        if (index < it->own->n_singularities)
            pk_system_singularity_name(system, it->problem.params, index, name, sizeof name);
        return SAY("%s: the one from t = %.17g to %.17g passes %s = 0, where by short steps "
                   "from there the motion does not: make the steps shorter%s",
                   what, t, time, name, words(it)->step_or_rtol);
    case PK_SLIDING:
        pk_system_switch_name(system, it->problem.params, index, name, sizeof name);
        return SAY("the motion stays on %s = 0: on either side of it the equations lead "
                   "back to it, and what follows they do not say; 'friction NAME = F' does, and "
                   "so does a smooth function in place of the jump, such as tanh",
                   name);
    case PK_PENETRATES:
        return SAY("%s: %s is %.6g", what, system->contacts.table[index].name, value);
    case PK_NO_CONTACT:
        if (kind >= PK_REASON_RESTITUTION)
            return SAY("%s: %s of %s is %.6g: it is %s", what,
                       kind == PK_REASON_RESTITUTION ? "the restitution"
                                                     : "a bound of the friction",
                       system->contacts.table[index].name, value,
                       kind == PK_REASON_RESTITUTION ? "from 0 to 1" : "at least 0");
        return SAY("%s: %s of %s: friction that grows with the force that it causes (Painleve), "
                   "or impulses that contradict each other",
                   what, kind == PK_REASON_IMPULSES ? "impulses" : "accelerations",
                   contacts_of(it, name, sizeof name));
    case PK_NO_IMPULSE:
        return pk_impulse_reason(it, text, size);
    case PK_OFF_CONSTRAINTS:
    case PK_NO_PROJECTION:
        return pk_project_reason(it, text, size);
    case PK_NO_CONVERGENCE:
        return no_convergence(it, text, size);
    case PK_AMBIGUOUS_STEP:
        return SAY("%s: the one that belongs to short steps is followed up to a step of %.6g, "
                   "not to %.6g: make the step shorter%s",
                   what, value, (double)pk_abs(it->own->h), words(it)->step);
    case PK_STEP_UNDERFLOW:
        if (kind == PK_REASON_TIME_SCALE)
            return SAY("%s cannot follow: the time scale changes too much within a step; give "
                       "a smaller tolerance%s, a largest step%s or a shorter first one",
                       it->method->name, words(it)->rtol, words(it)->max_step);
        return SAY("%s: step %.3g: the motion may end there, at infinity or in a singularity", what,
                   value);
    case PK_TOO_MANY_STEPS:
        return SAY("%s%s: %lu", what, words(it)->max_steps, it->count.steps);
    case PK_NO_PROGRESS:
        if (kind == PK_REASON_CROWD)
            return SAY("%s: %.0f changes of %s within %.3g: the motion may stay where they happen",
                       what, value, contacts_of(it, name, sizeof name), time);
        return SAY("%s: the last %lu%s lead from t = %.17g to here, and at this rate %.3g more "
                   "would arrive, or double the time passed: the motion may end here in a "
                   "singularity, or be stiff (method radau)%s%s",
                   what, it->count.steps + it->count.rejections - it->own->progress.judged,
                   pk_often_rejected(it) ? ", many of them rejected," : "",
                   (double)it->own->progress.judged_t, value,
                   pk_often_rejected(it) ? ", or the tolerance be below what forces are good for"
                                         : "",
                   pk_often_rejected(it) ? words(it)->rtol : "");
    case PK_STOPPED_EVENT:
        if (it->event)
            return TELL("stopped at event %s at t = %.17g",
                        system->events.table[it->event - 1].what.name, t);
        return TELL("%s at t = %.17g", what, t);
    case PK_NOT_FINITE:
        if (system->noise.n && kind == PK_OF_NOISE)
            return SAY("the intensity of the noise on %s is %.6g, and must not be negative",
                       system->noise.names[index], value);
        if (it->event > system->events.n) {
            const size_t k = it->event - 1 - system->events.n;
            pk_system_switch_name(system, it->problem.params, k, name, sizeof name);
            return TELL("%s, at whose zeros the equations change, is not finite at "
                        "t = %.17g",
                        name, t);
        }
        if (it->event)
            return TELL("the function of event %s is not finite at t = %.17g",
                        system->events.table[it->event - 1].what.name, t);
        return SAY("%s", what);
    case PK_DONE:
    case PK_STOPPED_USER:
        return TELL("%s at t = %.17g", what, t);
    default:
        return SAY("%s", what);
    }
}
