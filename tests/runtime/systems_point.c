/* Systems of systems.h with one degree of freedom and M = 1: free, driven in time, or pushed by
 * an input.
 */
#include "systems_make.h"

static const struct pk_quantity inputs[] = {{"u", "", ""}};

POINT_MASS(pendulum, -G(params) * PK_F(cos)(q[0]), -G(params) * PK_F(sin)(q[0]),
           -G(params) * PK_F(cos)(q[0]), 0)
SIZES(pendulum, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) pendulum_##x
#include <pk/inlined.h>
SYSTEM(pendulum, 1, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(2.385)), LIST(PK_C(0.13)),
       .linear = pendulum_linear);

POINT_MASS(oscillator, G(params) * q[0] * q[0] / 2, -G(params) * q[0], -G(params), 0)
SIZES(oscillator, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) oscillator_##x
#include <pk/inlined.h>
SYSTEM(oscillator, 1, NATURAL | PK_AFFINE, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.7)),
       LIST(PK_C(0.2)), .linear = oscillator_linear);

POINT_MASS(stiffening, G(params) * q[0] * q[0] * (1 + q[0] * q[0] / 2) / 2,
           -G(params) * q[0] * (1 + q[0] * q[0]), -G(params) * (1 + 3 * q[0] * q[0]), 0)
SIZES(stiffening, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) stiffening_##x
#include <pk/inlined.h>
SYSTEM(stiffening, 1, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(1.3)), LIST(PK_C(0.2)),
       .linear = stiffening_linear);

POINT_MASS(driven, G(params) * q[0] * q[0] / 2 - q[0] * PK_F(cos)(3 * t),
           -G(params) * q[0] + PK_F(cos)(3 * t), -G(params), -3 * PK_F(sin)(3 * t))
SIZES(driven, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) driven_##x
#include <pk/inlined.h>
SYSTEM(driven, 1, DRIVEN, PK_C(2.0), 0, none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)),
       .linear = driven_linear);

void driven_exact(pk_real t, pk_real *q, pk_real *v)
{
    const pk_real w = PK_F(sqrt)(PK_C(2.0)), A = 1 / (PK_C(2.0) - 9);
    const pk_real a = PK_C(0.7) - A, b = PK_C(0.2) / w;
    *q = A * PK_F(cos)(3 * t) + a * PK_F(cos)(w * t) + b * PK_F(sin)(w * t);
    *v = -3 * A * PK_F(sin)(3 * t) - a * w * PK_F(sin)(w * t) + b * w * PK_F(cos)(w * t);
}

POINT_MASS(pushed, 0, u[0], 0, 0)
SIZES(pushed, 1, 1)
#undef PK_MODEL
#define PK_MODEL(x) pushed_##x
#include <pk/inlined.h>
SYSTEM(pushed, 1, DRIVEN, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)),
       .n_inputs = 1, .inputs = inputs, .linear = pushed_linear);

POINT_MASS(radial, G(params) / (2 * q[0] * q[0]) - 1 / q[0],
           G(params) / (q[0] * q[0] * q[0]) - 1 / (q[0] * q[0]),
           2 / (q[0] * q[0] * q[0]) - 3 * G(params) / (q[0] * q[0] * q[0] * q[0]), 0)
SIZES(radial, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) radial_##x
#include <pk/inlined.h>
SYSTEM(radial, 1, NATURAL, PK_C(0.75), 0, none_cyclic, LIST(PK_C(0.5)), LIST(0),
       .linear = radial_linear);

/* exp(-s^2), s = (x - 1.3)/limit, of which .8 bars the way. */
#define AWAY(params, q) ((q[0] - PK_C(1.3)) / LIMIT(params))
#define HILL(params, q) (PK_C(0.8) * PK_F(exp)(-AWAY(params, q) * AWAY(params, q)))
static const struct pk_quantity hill[] = {{"exp(-s^2)", "", ""}};
static void barred_marking(ARGS, pk_real *out)
{
    UNUSED;
    out[0] = -AWAY(params, q) * AWAY(params, q);
}
POINT_MASS(barred, HILL(params, q), 2 * AWAY(params, q) / LIMIT(params) * HILL(params, q),
           (2 - 4 * AWAY(params, q) * AWAY(params, q)) / (LIMIT(params) * LIMIT(params)) *
               HILL(params, q),
           0)
SIZES(barred, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) barred_##x
#include <pk/inlined.h>
SYSTEM(barred, 1, NATURAL, PK_C(1.0), PK_C(1e-3), none_cyclic, LIST(0), LIST(PK_C(1.0)),
       .linear = barred_linear, .marks.n = 1, .marks.names = hill, .marks.values = barred_marking);
