/* The acceleration within a step: inputs filled, the call counted, a failure named. Over the
 * macros of pk/inlined.h; to be included once, ahead of every text that evaluates.
 */
static inline enum pk_status PK_STEPPER(acceleration)(struct pk_integrator *it, pk_real t,
                                                      const pk_real *q, const pk_real *v,
                                                      pk_real *a)
{
    const pk_real *u = PK_STEPPER_INPUT(it, t);
    const int failed = PK_STEPPER_ACCELERATION(it, t, q, v, u, a);
    it->count.evaluations++;
    return failed ? pk_eval_failed(it, t, q, v, failed) : PK_DONE;
}
