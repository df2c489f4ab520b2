/* The derivative of a run, step by step; the lengths of adaptive steps are held. Displacements go
 * through a step by the same method on the variational equations (motion.h), so their derivative is
 * that of the step, to rounding. Other methods, and models with constraints or rotations, go by
 * differences of the step (differences.c). */
#include "../../src/core/internal.h"
#include "../settings/settings.h"
#include "tape.h"

struct tangent {
    struct pk_run *run;
    struct variation w;
    struct differences d;
    int exact;                  /* whether variational equations are used */
    size_t n, columns, m, wide; /* m: inputs and parameters; wide: numbers in a column of D */
    void *params;               /* a copy with the sides of switches */
    struct pk_constant_input inputs;
    pk_real *du;
    double *along; /* the derivative of a step by its times */
    enum pk_status status;
    /* arguments of pk_run_tangent() */
    size_t begin, end, n_times;
    double *D, *out;
    const double *times;
};

static void make(struct tangent *x)
{
    struct pk_run *run = x->run;
    const struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    const unsigned traits = s->method->traits;
    struct pk_problem problem = {
        .system = system, .input = pk_constant_input, .context = &x->inputs};
    x->inputs.count = system->n_inputs;
    struct motion motion = {
        .problem = &problem, .method = s->method, .sided = 1, .memory = &run->memory};
    x->params = memory_take(&run->memory, system->params_size, 1);
    problem.params = x->params;
    motion.q = s->q;
    motion.v = s->v;
    x->n = s->n;
    x->m = system->n_inputs + system->n_parameters;
    x->wide = 2 * x->n + x->m + 1;
    x->du = memory_take(&run->memory, x->columns * x->m + 1, sizeof *x->du);
    x->along = memory_take(&run->memory, 2 * x->n, sizeof *x->along);
    differences_make(&x->d, run);
    x->exact = !system->constraints.n && !system->n_rotations && !(traits & PK_NOISE) &&
               variation_init(&x->w, &motion, x->columns) >= 0 &&
               variation_drive(&x->w, x->du) >= 0;
}

/* Copies row k of the tape and the displacements in D to the start of the variational motion. */
static void place(struct tangent *x, const pk_real *row)
{
    struct variation *w = &x->w;
    const size_t n = w->n, n_q = w->n_q;
    memcpy(w->Q, row + TAPE_STATE, n_q * sizeof *w->Q);
    variation_put(w, row + TAPE_STATE + n, 0, w->V);
    for (size_t k = 0; k < x->columns; k++) {
        const double *D = x->D + k * x->wide;
        for (size_t i = 0; i < n; i++) {
            if (i < n_q)
                w->Q[(k + 1) * n_q + i] = (pk_real)D[i];
            w->V[variation_place(w, k + 1, i)] = (pk_real)D[n + i];
        }
        for (size_t j = 0; j < x->m; j++)
            x->du[k * x->m + j] = (pk_real)D[2 * n + j];
    }
    tape_params(x->run, row, x->params);
}

/* Copies the displacements at the end of the step to D. */
static void take(struct tangent *x)
{
    const struct variation *w = &x->w;
    const struct pk_integrator *it = &w->motion.it;
    for (size_t k = 0; k < x->columns; k++) {
        double *D = x->D + k * x->wide;
        for (size_t i = 0; i < w->n; i++) {
            D[i] = i < w->n_q ? (double)it->q[(k + 1) * w->n_q + i] : 0;
            D[w->n + i] = (double)it->v[variation_place(w, k + 1, i)];
        }
    }
}

/* Makes the step from the start of a row to t on the variational equations. PK_REFUSED: the method
 * does not take them. */
static enum pk_status varied(struct tangent *x, const pk_real *row, pk_real t)
{
    struct motion *m = &x->w.motion;
    x->inputs.u = row + TAPE_STATE + 4 * x->n;
    place(x, row);
    m->t = row[TAPE_T0];
    m->options = tape_options(x->run, t - m->t);
    if (m->it.own) {
        m->it.options = m->options;
        PK_TRY(pk_integrator_reset(&m->it, m->t, m->q, m->v));
        PK_TRY(pk_integrator_set_step(&m->it, m->options.h));
    } else
        PK_TRY(motion_begin(m));
    const unsigned long before = m->it.count.steps;
    PK_TRY(pk_integrator_to(&m->it, t));
    if (m->it.count.steps != before + 1)
        return PK_REFUSED;
    take(x);
    return PK_DONE;
}

/* Propagates D through step k up to t. */
static void go(struct tangent *x, size_t k, pk_real t)
{
    const pk_real *row = tape_row(x->run->tape, k);
    const int cut = tape_is_cut(x->run, row, t);
    int shifts = 0;
    if (x->exact)
        x->status = varied(x, row, t);
    for (size_t c = 0; c < x->columns; c++) {
        double *D = x->D + c * x->wide, *dt = D + x->wide - 1;
        const int shifted = *dt < 0 || *dt > 0;
        const struct shift shift = {D, (pk_real)*dt, cut ? 0 : (pk_real)*dt, 0};
        const struct shift times = {NULL, 1, cut ? 0 : 1, 0};
        if (!x->exact && x->status >= 0)
            x->status = differences_find(&x->d, k, t, &shift, D);
        else if (shifted && x->status >= 0) {
            if (!shifts++)
                x->status = differences_find(&x->d, k, t, &times, x->along);
            for (size_t i = 0; i < 2 * x->n; i++)
                D[i] += *dt * x->along[i];
        }
        if (cut)
            *dt = 0;
    }
}

/* Writes the state at the end of a step to t, and the displacements. */
static void write(struct tangent *x, size_t k, pk_real t, double *out)
{
    const size_t n = x->n, n_q = pk_coordinates_of(&x->d.problem);
    if (x->status >= 0)
        x->status = differences_step(&x->d, k, t);
    for (size_t i = 0; i < n; i++) {
        out[i] = i < n_q ? (double)x->d.q[i] : 0;
        out[n + i] = (double)x->d.v[i];
    }
    for (size_t c = 0; c < x->columns; c++)
        memcpy(out + (c + 1) * 2 * n, x->D + c * x->wide, 2 * n * sizeof *out);
}

/* Writes the state and the displacements at t inside step k, which has been made, by its dense
 * output. */
static void interpolate(struct tangent *x, pk_real t, double *out)
{
    struct variation *w = &x->w;
    const size_t n = x->n, n_q = w->n_q;
    x->status = pk_integrator_dense(&w->motion.it, t, w->Q, w->V);
    for (size_t c = 0; c <= x->columns; c++, out += 2 * n)
        for (size_t i = 0; i < n; i++) {
            out[i] = i < n_q ? (double)w->Q[c * n_q + i] : 0;
            out[n + i] = (double)w->V[variation_place(w, c, i)];
        }
}

static void steps(void *context)
{
    struct tangent *x = context;
    make(x);
    const size_t width = (1 + x->columns) * 2 * x->n, size = x->columns * x->wide;
    double *kept = memory_take(&x->run->memory, size + 1, sizeof *kept);
    size_t done = 0;
    for (size_t k = x->begin; k < x->end && x->exact; k++) { /* does the method take them? */
        const pk_real *row = tape_row(x->run->tape, k);
        if (!(row[TAPE_T1] > row[TAPE_T0]))
            continue;
        memcpy(kept, x->D, size * sizeof *kept);
        x->exact = varied(x, row, row[TAPE_T1]) != PK_REFUSED;
        memcpy(x->D, kept, size * sizeof *kept);
        break;
    }
    for (size_t k = x->begin; k < x->end && x->status >= 0; k++) {
        const pk_real t0 = tape_row(x->run->tape, k)[TAPE_T0];
        const pk_real t1 = tape_row(x->run->tape, k)[TAPE_T1];
        int made = 0;
        const int inside = done < x->n_times && (pk_real)x->times[done] > t0 &&
                           (pk_real)x->times[done] < t1;
        if (inside && x->exact && x->run->settings.method->traits & PK_DENSE) {
            go(x, k, t1);
            made = 1;
        }
        for (; made && x->status >= 0 && done < x->n_times && (pk_real)x->times[done] < t1; done++)
            interpolate(x, (pk_real)x->times[done], x->out + done * width);
        for (; x->status >= 0 && done < x->n_times && (pk_real)x->times[done] < t1; done++) {
            const pk_real t = (pk_real)x->times[done];
            memcpy(kept, x->D, size * sizeof *kept);
            if (t > t0)
                go(x, k, t);
            write(x, k, t, x->out + done * width);
            memcpy(x->D, kept, size * sizeof *kept);
        }
        if (t1 > t0 && x->status >= 0 && !made)
            go(x, k, t1);
        for (; done < x->n_times && (pk_real)x->times[done] <= t1; done++)
            write(x, k, t1, x->out + done * width);
    }
}

int pk_run_tangent(struct pk_run *run, size_t begin, size_t end, size_t columns, double *D,
                   size_t n_times, const double *times, double *out)
{
    struct tangent x = {.run = run,
                        .columns = columns,
                        .begin = begin,
                        .end = end,
                        .D = D,
                        .n_times = n_times,
                        .times = times,
                        .out = out};
    const int done = memory_try(&run->memory, steps, &x);
    pk_integrator_free(&x.w.motion.it);
    pk_integrator_free(&x.d.it);
    return done ? x.status : PK_NO_MEMORY;
}

struct end {
    struct pk_run *run;
    size_t row;
    int end;
    const double *D;
    double *rates;
    enum pk_status status;
};

/* Of the equations: q' and v' at the start (0) or the end (1) of a row; of the step: the derivative
 * of its end by the time of this end (2). */
static void rates(void *context)
{
    struct end *x = context;
    const struct settings *s = &x->run->settings;
    const size_t n = s->n, n_q = settings_coordinates(s);
    const pk_real *row = tape_row(x->run->tape, x->row);
    const pk_real *q = row + TAPE_STATE + (x->end ? 2 * n : 0), t = row[x->end ? TAPE_T1 : TAPE_T0];
    const size_t last = 2 * n + s->system->n_inputs + s->system->n_parameters;
    const struct shift shift = {x->D, 0, x->D ? (pk_real)x->D[last] : 1, x->D != NULL};
    struct differences d;
    differences_make(&d, x->run);
    if (x->end > 1)
        x->status = differences_find(&d, x->row, t, &shift, x->rates);
    pk_integrator_free(&d.it);
    if (x->end > 1)
        return;
    tape_params(x->run, row, d.params);
    if (s->system->acceleration(d.params, t, q, q + n, row + TAPE_STATE + 4 * n, d.found))
        x->status = PK_SINGULAR_MASS;
    for (size_t i = 0; i < n; i++) {
        x->rates[i] = i < n_q ? (double)q[n + i] : 0;
        x->rates[n + i] = (double)d.found[i];
    }
}

int pk_run_tape_rates(struct pk_run *run, size_t k, int end, double *out)
{
    struct end x = {run, k, end, NULL, out, PK_DONE};
    const int done = memory_try(&run->memory, rates, &x);
    return done ? x.status : PK_NO_MEMORY;
}

int pk_run_tape_jump(struct pk_run *run, size_t k, const double *D, double *out)
{
    struct end x = {run, k, 2, D, out, PK_DONE};
    const int done = memory_try(&run->memory, rates, &x);
    return done ? x.status : PK_NO_MEMORY;
}
