/* The acceleration within a step: computes inputs, counts the call, reports a failure. Uses the
 * macros of pk/inlined.h; included once, before every header that calls it. */
static inline enum pk_status PK_STEPPER(acceleration)(struct pk_integrator *it, pk_real t,
                                                      const pk_real *q, const pk_real *v,
                                                      pk_real *a)
{
    const pk_real *u = PK_STEPPER_FEEDBACK(it, t, q, v);
    const int failed = PK_STEPPER_ACCELERATION(it, t, q, v, u, a);
    it->count.evaluations++;
    return failed ? pk_eval_failed(it, t, q, v, failed) : PK_DONE;
}

/* Writes k = (q', v') at y, where q' is the rates of coordinates and v' the acceleration. */
static PK_INLINE enum pk_status PK_STEPPER(slope)(struct pk_integrator *it, pk_real t,
                                                  const pk_real *y, pk_real *k)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it);
    for (size_t i = 0; i < n_q; i++)
        k[i] = y[n_q + i];
    return PK_STEPPER(acceleration)(it, t, y, y + n_q, k + n_q);
}
