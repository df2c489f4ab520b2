/* The symplecticity defect of the steps of a run. */
#include "parts.h"

enum { STATES = 16 };

/* Reports the largest defect at states spread over the rows. Failed steps are counted; the
 * diagnostic fails only if all steps fail. */
void diagnose_symplectic(struct pk_run *run, struct diagnostics *d)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = run->problem.system;
    const size_t size = pk_stepmap_size(&run->problem, s->method);
    const size_t states = d->n_rows < 1 ? 1 : d->n_rows < STATES ? d->n_rows : STATES;
    const int fixed = !(s->method->traits & PK_ADAPTIVE);
    const pk_real h = fixed ? s->options.h : run->it.t / (pk_real)run->it.count.steps;
    void *block = memory_take(&run->memory, size, 1);
    struct pk_stepmap most = {.defect = -1}, map;
    pk_real t = 0;
    enum pk_status status = PK_DONE, last = PK_DONE;
    size_t made = 0;
    for (size_t k = 0; k < states && status != PK_REFUSED; k++) {
        /* NULL: the initial state */
        const pk_real *row = d->rows ? diagnose_row(d, k, states) : NULL;
        status = pk_stepmap_find(&map, &run->problem, s->method, &s->options, h, row ? row[0] : 0,
                                 row ? row + 1 : s->q, row ? row + 1 + s->n : s->v, NULL, block,
                                 size);
        if (status < 0) {
            last = status;
            continue;
        }
        made++;
        if (map.defect - map.rounding > most.defect - most.rounding || most.defect < 0) {
            most = map;
            t = row ? row[0] : 0;
        }
    }
    const char *reason = pk_status_text(made ? PK_DONE : last);
    if (!made && last == PK_REFUSED)
        reason = diagnose_not_free(system) ? diagnose_not_free(system)
                 : system->n_first_order
                     ? "states have no momenta, so there is no symplectic form to be kept"
                 : diagnose_no_variation(run)
                     ? diagnose_no_variation(run)
                     : "steps of this method have no length of their own: take one of fixed steps";
    if (diagnose_told(d, made ? PK_DONE : last, reason, NULL)) {
        struct json *j = &d->json;
        json_reals(j, {"defect", most.defect}, {"volume", most.volume}, {"rounding", most.rounding},
                   {"step", most.h}, {"t", t});
        json_counts(j, {"states", made}, {"failed", states - made});
        json_flag(j, "symplectic", most.defect <= most.rounding);
        json_flag(j, "variational", (system->facts & PK_VARIATIONAL) != 0);
    }
}
