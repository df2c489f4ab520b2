/* Blocks of zeros and of other patterns, and traces of what they leave: of test_memory*.c. */
#ifndef BLOCKS_H
#define BLOCKS_H

#include "fixture.h"
#include "core/internal.h"

#if defined __has_feature
#if __has_feature(memory_sanitizer)
#include <sanitizer/msan_interface.h>
#define WATCHED /* what is read before it is written, decides and is an address or a result */
#endif
#endif

#ifdef WATCHED
enum { REALS = 1 << 15, PADDING = 1, TRACE = 4096 };
#else
enum { REALS = 1 << 15, PADDING = 300, TRACE = 4096 };
#endif

struct pattern {
    const char *name;
    unsigned long long bits;
};
static const struct pattern zero = {"zero", 0};
static const struct pattern patterns[] = {
    {"signalling NaN", 0x7ff4dead0000beefull}, {"all ones", ~0ull}, {"one", 0x3ff0000000000000ull},
    {"-2e300", 0xfe47e43c8800759cull},         {"least number", 1},
};
enum { PATTERNS = sizeof patterns / sizeof *patterns };

static const struct pk_system *const systems[] = {
    &pendulum_system, &oscillator_system,   &double_pendulum_system,
    &kepler_system,   &relativistic_system, &driven_system,
    &forced_system,   &van_der_pol_system,  &damped_system,
    &turning_system,  &brusselator_system,  &maxwell_system,
    &pushed_system,   &free_body_system,    &top_system,
    &carriage_system, &swift_system,        &rod_system,
    &rods_system,     &wire_system,         &jointed_system,
    &sleigh_system,   &ball_system,         &barred_system,
};
enum { SYSTEMS = sizeof systems / sizeof *systems };

struct trace {
    size_t count;
    double x[TRACE];
};

static inline void note(struct trace *to, double x)
{
#ifdef WATCHED
    __msan_check_mem_is_initialized(&x, sizeof x);
#endif
    if (to->count < TRACE)
        to->x[to->count++] = x;
}

static inline void fill(void *at, size_t bytes, const struct pattern *with)
{
    for (size_t i = 0; i + sizeof with->bits <= bytes; i += sizeof with->bits)
        memcpy((char *)at + i, &with->bits, sizeof with->bits);
}

/* As memory that nobody has written. */
static inline void poison(void *at, size_t bytes, const struct pattern *with)
{
    fill(at, bytes, with);
#ifdef WATCHED
    __msan_poison(at, bytes);
#endif
}

static inline void note_all(struct trace *to, const double *x, size_t count)
{
    for (size_t i = 0; x && i < count; i++)
        note(to, x[i]);
}

/* The state; the motion inside the last step and at its end. */
static inline void look(struct trace *to, struct pk_integrator *it)
{
    const size_t n = it->n;
    note(to, it->status);
    note(to, it->t);
    note(to, (double)it->count.evaluations);
    note_all(to, it->q, it->n_q);
    note_all(to, it->v, n);
    note_all(to, it->p, n);
    for (int k = 1; it->status >= 0 && it->method->dense && k <= 3; k++) {
        double q[16], v[16];
        const double t = k == 3 ? it->t : it->last_t + k * (it->t - it->last_t) / 3;
        const enum pk_status status = pk_integrator_dense(it, t, q, v);
        note(to, status);
        note_all(to, q, status < 0 ? 0 : it->n_q);
        note_all(to, v, status < 0 ? 0 : n);
    }
}

static double room[2 * REALS];

/* Where the traces differ, or -1. */
static inline long difference(const struct trace *a, const struct trace *b)
{
    for (size_t i = 0; i < a->count || i < b->count; i++)
        if (i >= a->count || i >= b->count || memcmp(&a->x[i], &b->x[i], sizeof *a->x))
            return (long)i;
    return -1;
}

static struct trace plain, other;

static inline int same(const char *what, const struct pk_system *system,
                       const struct pk_method *method, const struct pattern *with, size_t padding)
{
    const long at = difference(&plain, &other);
    if (at >= 0)
        printf(
            "\n    %s: %s, %s in memory of %s, %zu parameters more: number %ld is %.17g, not %.17g",
            what, system->name, method->name, with->name, padding, at, other.x[at], plain.x[at]);
    return at < 0;
}

#endif
