/* A method on q'' = -STIFFNESS q - DAMPING q': one step is a 2 by 2 map of (q, v), which gives the
 * method's stability limit, frequency and damping.
 */

#include <pk/limits.h>

#include "stability.h"

static const double TWO_PI = 6.283185307179586476925;
static const double none = (double)NAN; /* entries of the map if the step fails */

/* Returns the rotation angle of the map in (0, 2 pi); NAN if it grows, damps or flips. */
static double rotation(const double map[4])
{
    const double half = (map[0] + map[3]) / 2, det = map[0] * map[3] - map[1] * map[2];
    if (!(fabs(det - 1) < 1e-9) || !(fabs(half) < 1))
        return none;
    return map[1] < 0 ? TWO_PI - pk_map_angle(map) : pk_map_angle(map);
}

int stability_oscillator(struct pk_stability *s, const struct pk_stability_question *x)
{
    const struct pk_method *method = stability_method(s, x->method);
    double map[4] = {none, none, none, none};
    const double y = x->h;
    if (!method)
        return 0;
    if (!(y > 0))
        return stability_wrong(s, "a step is positive");
    const enum pk_status status = pk_method_spring(method, x->stiffness, x->damping, y, map);
    json_text(&s->out, "oscillator", method->name);
    json_real(&s->out, "y", y);
    json_text(&s->out, "status", pk_status_name(status));
    json_reals(&s->out, {"growth", pk_map_growth(map)}, {"turn", rotation(map)},
               {"trace", map[0] + map[3]});
    return 1;
}
