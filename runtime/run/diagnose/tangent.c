/* The derivative of a run, step by step; the lengths of adaptive steps are held. Displacements go
 * through a step by the same method on the variational equations (motion.h), so their derivative is
 * that of the step, to rounding. Models with constraints, rotations or noise, and methods that do not
 * take these equations, go by differences of the step (differences.c). */
#include "../../src/core/internal.h"
#include "../settings/settings.h"
#include "tape.h"

struct tangent {
    struct pk_run *run;
    struct differences *d; /* also the params and the inputs of the step */
    struct variation w;
    int exact;                  /* whether variational equations are used */
    size_t n, columns, m, wide; /* m: inputs and parameters; wide: numbers in a column of D */
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
    x->d = &run->tape->differences;
    const struct motion motion = {.problem = &x->d->problem,
                                  .method = s->method,
                                  .q = s->q,
                                  .v = s->v,
                                  .sided = 1,
                                  .memory = &run->memory};
    x->n = s->n;
    x->m = system->n_inputs + system->n_parameters;
    x->wide = 2 * x->n + x->m + 1;
    x->du = memory_take(&run->memory, x->columns * x->m + 1, sizeof *x->du);
    x->along = memory_take(&run->memory, 2 * x->n, sizeof *x->along);
    /* The kernel `linear` omits the derivatives of r_p. Implicit methods use it in Newton's iteration
     * alone; the result of explicit methods would be wrong. */
    const unsigned traits = s->method->traits;
    const int reads = traits & PK_EXACT || (traits & (PK_LINEAR | PK_IMPLICIT)) == PK_LINEAR;
    x->exact = !system->constraints.n && !system->n_rotations && !(traits & PK_NOISE) && !reads &&
               variation_init(&x->w, &motion, x->columns) >= 0 &&
               variation_drive(&x->w, x->du) >= 0;
}

/* Copies a row of the tape and the displacements in D to the start of the variational motion. */
static void place(struct tangent *x, const pk_real *row)
{
    struct variation *w = &x->w;
    const size_t n = w->n, n_q = w->n_q;
    differences_place(x->d, row);
    pk_copy(w->Q, x->d->q, n_q);
    variation_put(w, x->d->v, 0, w->V);
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
    place(x, row);
    m->t = row[TAPE_T0];
    m->options = differences_options(x->run, t - m->t);
    PK_TRY(motion_begin(m));
    PK_TRY(pk_integrator_to(&m->it, t));
    if (m->it.count.steps != 1)
        return PK_REFUSED;
    take(x);
    return PK_DONE;
}

/* Propagates D through step k up to t. */
static enum pk_status go(struct tangent *x, size_t k, pk_real t)
{
    const pk_real *row = tape_row(x->run->tape, k);
    const int cut = tape_is_cut(x->run, row, t);
    const struct shift times = {NULL, 1, !cut, 0};
    int shifts = 0;
    if (x->exact) {
        const enum pk_status status = varied(x, row, t);
        x->exact = status != PK_REFUSED;
        PK_TRY(x->exact ? status : PK_DONE);
    }
    for (size_t c = 0; c < x->columns; c++) {
        double *D = x->D + c * x->wide, *dt = D + x->wide - 1;
        const struct shift shift = {D, (pk_real)*dt, cut ? 0 : (pk_real)*dt, 0};
        if (!x->exact)
            PK_TRY(differences_find(x->d, k, t, &shift, D));
        else if (*dt < 0 || *dt > 0) {
            if (!shifts++)
                PK_TRY(differences_find(x->d, k, t, &times, x->along));
            for (size_t i = 0; i < 2 * x->n; i++)
                D[i] += *dt * x->along[i];
        }
        if (cut)
            *dt = 0;
    }
    return PK_DONE;
}

/* Writes the state at the end of a step to t, and the displacements. */
static enum pk_status write(struct tangent *x, size_t k, pk_real t, double *out)
{
    const size_t n = x->n;
    const enum pk_status status = differences_step(x->d, k, t);
    for (size_t i = 0; i < n; i++) {
        out[i] = i < x->d->n_q ? (double)x->d->q[i] : 0;
        out[n + i] = (double)x->d->v[i];
    }
    for (size_t c = 0; c < x->columns; c++)
        memcpy(out + (c + 1) * 2 * n, x->D + c * x->wide, 2 * n * sizeof *out);
    return status;
}

/* Writes the state and the displacements at t inside the step that go() has made, by its dense
 * output. */
static enum pk_status interpolate(struct tangent *x, pk_real t, double *out)
{
    struct variation *w = &x->w;
    const size_t n = x->n, n_q = w->n_q;
    PK_TRY(pk_integrator_dense(&w->motion.it, t, w->Q, w->V));
    for (size_t c = 0; c <= x->columns; c++, out += 2 * n)
        for (size_t i = 0; i < n; i++) {
            out[i] = i < n_q ? (double)w->Q[c * n_q + i] : 0;
            out[n + i] = (double)w->V[variation_place(w, c, i)];
        }
    return PK_DONE;
}

/* Propagates D through step k, and writes the rows in it and at its end. `start` and `end` have
 * room for D. */
static enum pk_status pass(struct tangent *x, size_t k, size_t *done, double *start, double *end)
{
    const pk_real *row = tape_row(x->run->tape, k), t0 = row[TAPE_T0], t1 = row[TAPE_T1];
    const size_t n = x->n, size = x->columns * x->wide * sizeof *x->D;
    memcpy(start, x->D, size);
    if (t1 > t0)
        PK_TRY(go(x, k, t1));
    memcpy(end, x->D, size);
    for (; *done < x->n_times && (pk_real)x->times[*done] <= t1; ++*done) {
        const pk_real t = (pk_real)x->times[*done];
        double *const out = x->out + *done * (1 + x->columns) * 2 * n;
        if (t < t1 && x->exact && x->run->settings.method->traits & PK_DENSE)
            PK_TRY(interpolate(x, t, out));
        else {
            if (t < t1)
                memcpy(x->D, start, size);
            if (t > t0 && t < t1)
                PK_TRY(go(x, k, t));
            PK_TRY(write(x, k, t, out));
            memcpy(x->D, end, size);
        }
    }
    return PK_DONE;
}

static void steps(void *context)
{
    struct tangent *x = context;
    make(x);
    const size_t size = x->columns * x->wide;
    double *room = memory_take(&x->run->memory, 2 * size + 1, sizeof *room);
    size_t done = 0;
    for (size_t k = x->begin; k < x->end && x->status >= 0; k++)
        x->status = pass(x, k, &done, room, room + size);
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
    return done ? x.status : PK_NO_MEMORY;
}

int pk_run_tape_rates(struct pk_run *run, size_t k, int end, double *out)
{
    struct differences *d = &run->tape->differences;
    const size_t n = d->n;
    const pk_real *row = tape_row(run->tape, k), t = row[end ? TAPE_T1 : TAPE_T0];
    const pk_real *q = row + TAPE_STATE + (end ? 2 * n : 0);
    const struct shift shift = {NULL, 0, 1, 0};
    if (end > 1)
        return differences_find(d, k, t, &shift, out);
    differences_place(d, row);
    if (d->problem.system->acceleration(d->params, t, q, q + n, d->u, d->found))
        return PK_SINGULAR_MASS;
    for (size_t i = 0; i < n; i++) {
        out[i] = i < d->n_q ? (double)q[n + i] : 0;
        out[n + i] = (double)d->found[i];
    }
    return PK_DONE;
}

int pk_run_tape_jump(struct pk_run *run, size_t k, const double *D, double *out)
{
    struct differences *d = &run->tape->differences;
    const struct pk_system *system = d->problem.system;
    const pk_real dt = (pk_real)D[2 * d->n + system->n_inputs + system->n_parameters];
    const struct shift shift = {D, 0, dt, 1};
    return differences_find(d, k, tape_row(run->tape, k)[TAPE_T1], &shift, out);
}
