/* Dense output: the state within the last step, projected onto the constraints. */

#include "../core/project.h"

enum pk_status pk_integrator_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const pk_real lo = pk_min(it->last_t, it->t), hi = pk_max(it->last_t, it->t);
    if (!pk_ready(it))
        return it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    if (!it->method->dense || !(it->own->passing.crossed || it->own->flags & PK_HAVE_STEP) ||
        !(t >= lo && t <= hi))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_DENSE);
    int moved;
    if (!(t > it->t) && !(t < it->t)) { /* t is the end of the step */
        pk_copy(q, it->q, it->n_q);
        pk_copy(v, it->v, it->n);
        return it->status = PK_DONE;
    }
    if (it->own->passing.crossed) {
        pk_singular_crossing_at(it, t, q, v);
        return it->status = PK_DONE;
    }
    it->status = it->method->dense(it, t, q, v);
    if (it->status >= 0 && (!pk_all_finite(q, it->n_q) || !pk_all_finite(v, it->n)))
        it->status = PK_NOT_FINITE;
    if (it->status >= 0 && it->own->project)
        it->status = pk_project(it, t, q, v, NULL, NULL, &moved);
    return it->status;
}
