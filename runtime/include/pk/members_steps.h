/* Steps of splitting methods with the accelerations of members: kicks v += h a and drifts q += h v.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_STEPS_H
#define PK_MEMBERS_STEPS_H

/* Makes `steps` steps of h from time t, in place: kicks v += kick[i] h a(q, t) for i = 0 .. stages,
 * and drifts q += drift[i] h v between them. The last kick of a step and the first of the next are
 * one. e has the room that pk_compute() needs; n is the number of coordinates. */
PK_PERHAPS static void pk_advance(struct pk_members *x, const struct pk_vector *of, pk_real *e, int stages,
                                  const pk_real *kick, const pk_real *drift, pk_real t, pk_real h,
                                  unsigned long steps, ptrdiff_t n, pk_real *q, pk_real *v)
{
    const pk_real ends = kick[stages] * h;
    unsigned long k;
    ptrdiff_t j;
    int i;

    for (k = 0; k < steps; k++) {
        pk_real done = 0; /* fraction of the step drifted so far */
        for (i = 0; i < stages; i++) {
            const pk_real kappa = i == 0 && k > 0 ? ends + kick[0] * h : kick[i] * h;
            const pk_real delta = drift[i] * h;
            x->t = t + (pk_real)k * h + done * h;
            if (kappa > 0 || kappa < 0)
                (void)pk_compute(x, of, e, &v, v, kappa);
            for (j = 0; j < n; j++)
                q[j] += delta * v[j];
            done += drift[i];
        }
    }
    x->t = t + (pk_real)steps * h;
    if (steps && (ends > 0 || ends < 0))
        (void)pk_compute(x, of, e, &v, v, ends);
}

#endif
