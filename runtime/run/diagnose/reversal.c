/* Integrates the run forward and then back to its start. Finds the time after which integrating
 * back no longer leads to the initial state. */

#include "parts.h"

/* largest relative error at which integrating back still counts as leading to the start */
static const double THRESHOLD = 1e-3;

void diagnose_reversal(struct pk_run *run, struct diagnostics *d)
{
    const struct settings *s = &run->settings;
    const size_t size = pk_reversal_size(&run->problem, s->method);
    void *block = memory_take(&run->memory, size, 1);
    struct pk_integrator it = {0};
    struct pk_reversal r = {0};
    const enum pk_status status = pk_reversal_find(&r, &it, &run->problem, s->method, &s->options,
                                                   0, s->q, s->v, run->it.t, (pk_real)THRESHOLD,
                                                   block, size);
    const struct pk_system *system = s->system;
    const int sides = system->switches.n && !system->switches.impulses;
    const char *why = status == PK_REFUSED && sides && !(system->facts & PK_SMOOTH)
                          ? "the way back is not followed through switches: give a method that "
                            "needs no smooth equations, as dop853"
                          : NULL;
    if (diagnose_told(d, status, why, &it)) {
        struct json *j = &d->json;
        const pk_real digits = PK_F(log)(r.threshold / PK_EPSILON);
        json_real(j, "threshold", r.threshold);
        json_flag(j, "symmetric", (s->method->traits & PK_SYMMETRIC) != 0);
        json_flag(j, "lost", r.passed);
        json_reals(j, {"horizon_lo", r.horizon_lo},
                   {"horizon_hi", r.passed ? r.horizon_hi : PK_INFINITY},
                   {"predicted", d->exponent > 0 ? digits / (pk_real)d->exponent : PK_INFINITY});
        json_open(j, "times", '[');
        for (size_t i = 0; i < r.count; i++)
            json_numbers(j, NULL, (const pk_real[]){r.at[i].t, r.at[i].error}, 2);
        json_close(j, ']');
    }
    pk_integrator_free(&it);
}
