/* Keeps the steps of a run. A step ends before the jump of an event or of the equations, and the
 * next one begins after it. */
#include "tape.h"

#include "parts.h"

static void put(struct pk_run *run, pk_real *to, const pk_real *q, const pk_real *v)
{
    memcpy(to, q, run->it.n_q * sizeof *to);
    memcpy(to + run->it.n, v, run->it.n * sizeof *to);
}

static void sides(const struct pk_run *run, pk_real *to)
{
    if (run->tape->n_sides)
        memcpy(to, run->events.sides, run->tape->n_sides * sizeof *to);
}

static void begin(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    if (!s->asked.tape)
        return;
    struct tape *tape = memory_take(&run->memory, 1, sizeof *tape);
    tape->n_sides = pk_system_switch_count(s->system, s->params);
    tape->width = TAPE_STATE + 4 * s->n + s->system->n_inputs + tape->n_sides;
    tape->now = memory_take(&run->memory, tape->width, sizeof *tape->now);
    run->tape = tape;
}

/* Returns whether the motion ends, or it or its equations may jump, at a crossing. */
static int jumps(const struct pk_run *run, size_t event)
{
    const struct pk_part_resets *resets = &run->settings.system->resets;
    const struct pk_part_events *events = &run->settings.system->events;
    if (event >= events->n || events->table[event].stop)
        return 1;
    const struct pk_part_contacts *contacts = &run->settings.system->contacts;
    int found = 0;
    for (size_t k = 0; k < resets->n; k++)
        found |= resets->table[k].event == event;
    for (size_t k = 0; k < contacts->n; k++)
        found |= contacts->table[k].event == event || contacts->table[k].open == event;
    return found;
}

static void event(struct pk_run *run, size_t event, const struct moment *at)
{
    struct tape *tape = run->tape;
    if (!tape || !jumps(run, event))
        return;
    const size_t n = run->it.n;
    tape->now[TAPE_MARK] = tape->caught ? -1 : (pk_real)event + 1;
    if (!tape->caught)
        sides(run, tape->now + tape->width - tape->n_sides);
    tape->caught = 1;
    put(run, tape->now + TAPE_STATE + 2 * n, at->q, at->v);
}

static void step(struct pk_run *run, const struct moment *at)
{
    struct tape *tape = run->tape;
    if (!tape)
        return;
    const size_t n = run->it.n, m = run->settings.system->n_inputs;
    pk_real *now = tape->now;
    now[TAPE_T1] = at->t;
    if (!tape->caught) {
        put(run, now + TAPE_STATE + 2 * n, at->q, at->v);
        sides(run, now + tape->width - tape->n_sides);
    }
    if (now[TAPE_T1] > now[TAPE_T0] || tape->caught) {
        tape->rows = memory_room(&run->memory, tape->rows, tape->count + 1, &tape->room,
                                 tape->width * sizeof *tape->rows);
        memcpy(tape->rows + tape->count++ * tape->width, now, tape->width * sizeof *now);
    }
    now[TAPE_T0] = at->t;
    now[TAPE_MARK] = tape->caught = 0;
    put(run, now + TAPE_STATE, at->q, at->v);
    memcpy(now + TAPE_STATE + 4 * n, run->settings.u, m * sizeof *now);
}

const struct observer tape_observer = {.begin = begin, .event = event, .step = step};

void tape_params(const struct pk_run *run, const pk_real *row, void *params)
{
    const struct settings *s = &run->settings;
    const struct tape *tape = run->tape;
    memcpy(params, s->params, s->system->params_size);
    if (tape->n_sides)
        memcpy((char *)params + s->system->switches.sides, row + tape->width - tape->n_sides,
               tape->n_sides * sizeof *row);
}

struct pk_options tape_options(const struct pk_run *run, pk_real h)
{
    struct pk_options options = run->settings.options;
    options.h = h;
    options.max_steps = 0;
    if (!pk_is_fixed(run->settings.method)) {
        options.h_max = h;
        options.rtol = options.atol = PK_C(1e10); /* no error is too large */
        options.newton_tol = 8 * PK_EPSILON;
    }
    return options;
}

int tape_is_cut(const struct pk_run *run, const pk_real *row, pk_real t)
{
    const pk_real h = run->settings.options.h, took = t - row[TAPE_T0];
    return !pk_is_fixed(run->settings.method) || PK_F(fabs)(took - h) > PK_C(1e-6) * h;
}

static void copy(void *context)
{
    struct pk_run *run = context;
    struct tape *tape = run->tape;
    const size_t shown = tape->width - tape->n_sides;
    tape->copy = memory_take(&run->memory, tape->count * shown + 1, sizeof *tape->copy);
    for (size_t k = 0; k < tape->count; k++)
        for (size_t i = 0; i < shown; i++)
            tape->copy[k * shown + i] = (double)tape_row(tape, k)[i];
}

size_t pk_run_tape(const struct pk_run *run, const double **rows, size_t *width)
{
    struct tape *tape = run->tape;
    *width = tape ? tape->width - tape->n_sides : 0;
    if (!tape || (!tape->copy && !memory_try((struct memory *)&run->memory, copy, (void *)run)))
        return 0;
    *rows = tape->copy;
    return tape->count;
}
