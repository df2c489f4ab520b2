/* Marks: hashes of all settings that determine the results of a run. A checkpoint stores them, and
 * only a run with the same marks can resume it. Output files and callbacks have no marks. */
#include "settings.h"

#define FIRST 0xcbf29ce484222325u /* 64-bit FNV-1a */
#define PRIME 0x100000001b3u

static uint64_t mark(uint64_t before, const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++)
        before = (before ^ byte[i]) * PRIME;
    return before;
}

static uint64_t text(uint64_t before, const char *of)
{
    return of ? mark(before, of, strlen(of) + 1) : before;
}

/* Hashes struct members one by one, since padding bytes are undefined. */
static uint64_t columns(uint64_t before, const struct pk_run_column *of, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        before = mark(before, &of[i].kind, sizeof of[i].kind);
        before = mark(before, &of[i].index, sizeof of[i].index);
        before = mark(before, &of[i].member, sizeof of[i].member);
    }
    return before;
}

static uint64_t expected(const struct pk_run_settings *x)
{
    uint64_t found = FIRST;
    for (size_t i = 0; i < x->n_expected; i++) {
        const struct pk_run_expected *e = &x->expected[i];
        const struct pk_run_column sides[] = {e->a, e->b, e->within};
        found = mark(found, &e->relation, sizeof e->relation);
        found = mark(found, &e->when, sizeof e->when);
        found = mark(columns(found, sides, 3), &e->at, sizeof e->at);
        found = mark(found, &e->event, sizeof e->event);
    }
    return found;
}

static uint64_t reduced(const struct pk_run_settings *x)
{
    uint64_t found = FIRST;
    for (size_t i = 0; i < x->n_reduced; i++) {
        found = mark(found, &x->reduced[i].what, sizeof x->reduced[i].what);
        found = mark(found, &x->reduced[i].index, sizeof x->reduced[i].index);
    }
    return found;
}

static uint64_t parts(const struct pk_run_settings *x)
{
    uint64_t found = FIRST;
    for (size_t i = 0; x->parts && i < x->n_parts; i++) {
        const double numbers[] = {x->parts[i].step, x->parts[i].rtol, x->parts[i].h_max};
        found = mark(text(found, x->parts[i].method), numbers, sizeof numbers);
    }
    return found;
}

#define ONE(name) {#name, mark(FIRST, &x->name, sizeof x->name)}
#define LIST(name) {#name, mark(FIRST, x->name, x->n_##name * sizeof *x->name)}
#define COLUMNS(name) {#name, columns(FIRST, x->name, x->n_##name)}

void settings_mark(struct settings *s)
{
    const struct pk_run_settings *x = &s->asked;
    const size_t values = x->members * x->n_member_columns;
    const int computed = x->compute != NULL || x->sample != NULL;
    const struct mark all[MARKS] = {
        {"method", text(FIRST, x->method)},
        ONE(until),
        ONE(every),
        ONE(step),
        ONE(rtol),
        ONE(atol),
        ONE(h_min),
        ONE(h_max),
        ONE(fixed_point),
        ONE(max_steps),
        ONE(seed),
        ONE(land),
        ONE(at),
        ONE(diagnose),
        ONE(bare),
        ONE(compared),
        ONE(members),
        ONE(first_member),
        ONE(watch),
        LIST(sizes),
        LIST(parameters),
        LIST(inputs),
        {"compute", mark(FIRST, &computed, sizeof computed)},
        ONE(only_stops),
        LIST(stops),
        LIST(q),
        LIST(v),
        LIST(hidden),
        COLUMNS(columns),
        COLUMNS(drifts),
        COLUMNS(member_columns),
        {"expected", expected(x)},
        {"parts", parts(x)},
        {"reduced", reduced(x)},
        ONE(no_rows),
        ONE(lenient),
        {"ensemble", mark(FIRST, x->member_values, values * sizeof *x->member_values)},
        {"member_name", text(FIRST, x->member_name)}};
    memcpy(s->marks, all, sizeof all);
}
