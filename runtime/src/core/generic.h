/* Compiles the code of pk/step/ for any system, with the function pointers of struct pk_system and
 * n known at run time. pk/inlined.h does so for one system with its kernels inlined. */
#ifndef PK_GENERIC_H
#define PK_GENERIC_H

#define PK_ANY_TABLE /* tables are not compile-time constants; see pk/step/tableau.h */

#include "internal.h"

#define PK_STEPPER(x) generic_##x
#define PK_STEPPER_N(it) ((it)->n)
#define PK_STEPPER_COORDINATES(it) ((it)->n_q)
#define PK_STEPPER_ACCELERATION(it, t, q, v, u, a) \
    (it)->problem.system->acceleration((it)->problem.params, t, q, v, u, a)
#define PK_STEPPER_INPUT(it, t) pk_eval_input(it, t)
#define PK_STEPPER_FEEDBACK(it, t, q, v) pk_eval_feedback(it, t, q, v)
#define PK_STEPPER_LANES(it, t, q, v, u, a) pk_eval_lanes(it, t, q, v, u, a)
#define PK_STEPPER_JET(it, t, q, v, u, order, c) \
    (it)->problem.system->jet((it)->problem.params, t, q, v, u, order, c)

#include <pk/step/evaluate.h>

#endif
