/* A method on q'' = -SIGN q - DAMPING q': the 2 by 2 map of (q, v) that one step is. It is the
 * method's own: in it are its limit of stability, its frequency, its damping.
 */
#include <math.h>

#include <pk/limits.h>

#include "output.h"
#include "stability.h"
#include "words.h"

static const double TWO_PI = 6.283185307179586476925;
static const double none = (double)NAN; /* of a step that was not made */

/* The angle in (0, 2 pi) by which the map turns; NAN where it grows, damps or flips. */
static double rotation(const double map[4])
{
    const double half = (map[0] + map[3]) / 2, det = map[0] * map[3] - map[1] * map[2];
    if (!(fabs(det - 1) < 1e-9) || !(fabs(half) < 1))
        return none;
    return map[1] < 0 ? TWO_PI - pk_map_angle(map) : pk_map_angle(map);
}

int stability_oscillator(size_t line, char *const words[])
{
    const struct pk_method *method = words[1] ? run_method_find(words[1]) : NULL;
    double stiffness, damping, y, map[4] = {none, none, none, none};
    if (!method || method->traits & PK_ADAPTIVE)
        return words_usage(line, "no method of a fixed step", words[1]);
    if (!words_real(words[2], &stiffness) || !words_real(words[3], &damping) ||
        !words_real(words[4], &y) || !(y > 0))
        return words_usage(line, "a stiffness, a damping and a step, please", words[2]);
    const enum pk_status status = pk_method_spring(method, stiffness, damping, y, map);
    printf("{\"oscillator\": \"%s\", \"y\": %.17g, \"status\": \"%s\", \"growth\": ", method->name,
           y, pk_status_name(status));
    output_real(stdout, pk_map_growth(map));
    fputs(", \"turn\": ", stdout);
    output_real(stdout, rotation(map));
    fputs(", \"trace\": ", stdout);
    output_real(stdout, map[0] + map[3]);
    fputs("}\n", stdout);
    return 0;
}
