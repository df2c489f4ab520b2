/* Keeps the steps of a run. A step ends before the jump of an event or of the equations, and the
 * next one begins after it. */
#include "tape.h"

#include "parts.h"

static void put(const struct pk_run *run, pk_real *to, const struct moment *at)
{
    memcpy(to, at->q, run->it.n_q * sizeof *to);
    memcpy(to + run->it.n, at->v, run->it.n * sizeof *to);
}

/* Sets the end of the step, unless a crossing in it has done so. */
static void finish(struct pk_run *run, const struct moment *at)
{
    const struct tape *tape = run->tape;
    if (tape->caught)
        return;
    put(run, tape->now + TAPE_STATE + 2 * run->it.n, at);
    if (tape->n_sides)
        memcpy(tape->now + tape->width - tape->n_sides, run->events.sides,
               tape->n_sides * sizeof *tape->now);
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
    differences_make(&tape->differences, run);
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
    tape->now[TAPE_MARK] = tape->caught ? -1 : (pk_real)event + 1;
    finish(run, at);
    tape->caught = 1;
}

static void step(struct pk_run *run, const struct moment *at)
{
    struct tape *tape = run->tape;
    if (!tape)
        return;
    pk_real *now = tape->now;
    finish(run, at);
    now[TAPE_T1] = at->t;
    if (now[TAPE_T1] > now[TAPE_T0] || tape->caught) {
        tape->rows = memory_room(&run->memory, tape->rows, tape->count + 1, &tape->room,
                                 tape->width * sizeof *tape->rows);
        memcpy(tape->rows + tape->count++ * tape->width, now, tape->width * sizeof *now);
    }
    now[TAPE_T0] = at->t;
    now[TAPE_MARK] = tape->caught = 0;
    put(run, now + TAPE_STATE, at);
    memcpy(now + TAPE_STATE + 4 * run->it.n, run->settings.u,
           run->settings.system->n_inputs * sizeof *now);
}

const struct observer tape_observer = {.begin = begin, .event = event, .step = step};

int tape_is_cut(const struct pk_run *run, const pk_real *row, pk_real t)
{
    const pk_real h = run->settings.options.h, took = t - row[TAPE_T0];
    return !pk_is_fixed(run->settings.method) || PK_F(fabs)(took - h) > PK_C(1e-6) * h;
}

size_t pk_run_tape(const struct pk_run *run, double *rows)
{
    const struct tape *tape = run->tape;
    const size_t shown = tape->width - tape->n_sides;
    for (size_t k = 0; rows && k < tape->count; k++)
        for (size_t i = 0; i < shown; i++)
            *rows++ = (double)tape_row(tape, k)[i];
    return tape->count;
}
