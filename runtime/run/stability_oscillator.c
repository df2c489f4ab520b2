/* A method on q'' = -SIGN q - DAMPING q': the 2 by 2 map of (q, v) that one step is, read from two
 * starts. It is the method's own: in it are its limit of stability, its frequency, its damping.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "stability.h"
#include "words.h"

struct spring {
    double stiffness, damping;
};

#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED (void)t, (void)v, (void)q, (void)u
#define STIFFNESS (((const struct spring *)params)->stiffness)
#define DAMPING (((const struct spring *)params)->damping)

static void defaults(void *params)
{
    struct spring *spring = (struct spring *)params;
    spring->stiffness = 1;
    spring->damping = 0;
}
static void derive(void *params, const unsigned char *given) { (void)params, (void)given; }
static int prepare(void *params) { return (void)params, 0; }
static void bounds(const void *params, pk_real *lo, pk_real *hi)
{
    (void)params;
    lo[0] = lo[1] = -HUGE_VAL;
    hi[0] = hi[1] = HUGE_VAL;
}
static void start(const void *params, pk_real *q, pk_real *v)
{
    (void)params;
    *q = 1;
    *v = 0;
}
static void gradient(ARGS, pk_real *dLdq)
{
    UNUSED;
    *dLdq = -STIFFNESS * *q;
}
static void force(ARGS, pk_real *f)
{
    UNUSED;
    *f = -STIFFNESS * *q - DAMPING * *v;
}
static int acceleration(ARGS, pk_real *a)
{
    force(params, t, q, v, u, a);
    return 0;
}
static void mass(ARGS, pk_real *M)
{
    UNUSED, (void)params;
    *M = 1;
}
static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    *p = *v;
    force(params, t, q, v, u, pdot);
}
static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    *p_q = 0;
    *pdot_q = -STIFFNESS;
    *pdot_v = -DAMPING;
}
static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    UNUSED, (void)a;
    *r_q = -STIFFNESS;
    *r_v = -DAMPING;
    *r_t = 0;
}
static pk_real energy(ARGS)
{
    UNUSED;
    return (*v * *v + STIFFNESS * *q * *q) / 2;
}

static const struct pk_quantity names[] = {{"q", "", ""}, {"q'", "", ""}, {"p_q", "", ""}};
static const struct pk_parameter parameters[] = {{{"stiffness", "", ""}, 0, 0, 0, 0},
                                                 {{"damping", "", ""}, sizeof(double), 0, 0, 0}};
static const unsigned char cyclic[] = {0};

enum {
    DAMPED = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH,
    FREE = DAMPED | PK_SEPARABLE | PK_CONSERVATIVE | PK_VARIATIONAL
};

static const struct pk_system oscillator = {
    .abi = PK_ABI,
    .name = "oscillator",
    .source_hash = "",
    .facts = FREE,
    .n = 1,
    .n_parameters = 2,
    .params_size = sizeof(struct spring),
    .coordinates = names,
    .rates = names + 1,
    .momenta = names + 2,
    .parameters = parameters,
    .cyclic = cyclic,
    .defaults = defaults,
    .derive = derive,
    .prepare = prepare,
    .bounds = bounds,
    .start = start,
    .acceleration = acceleration,
    .mass = mass,
    .force = force,
    .canonical = canonical,
    .gradient = gradient,
    .jacobian = jacobian,
    .linear = linear,
    .energy = energy,
};

int stability_oscillator(size_t line, char *const words[])
{
    const struct pk_method *method = words[1] ? run_method_find(words[1]) : NULL;
    struct spring spring;
    struct pk_options options = pk_options_default();
    double y, map[4];
    if (!method || method->traits & PK_ADAPTIVE)
        return words_usage(line, "no method of a fixed step", words[1]);
    if (!words_real(words[2], &spring.stiffness) || !words_real(words[3], &spring.damping) ||
        !words_real(words[4], &y) || !(y > 0))
        return words_usage(line, "a stiffness, a damping and a step, please", words[2]);
    struct pk_system system = oscillator;
    if (spring.damping > 0 || spring.damping < 0)
        system.facts = DAMPED;
    const struct pk_problem problem = {.system = &system, .params = &spring};
    enum pk_status status = PK_DONE;
    options.h = y;
    for (int k = 0; k < 2 && status >= 0; k++) {
        const double q = k == 0, v = k == 1;
        struct pk_integrator *it =
            stability_begin(&problem, method, &options, &q, &v, &status);
        if (it)
            status = pk_integrator_step(it, 2 * y);
        if (status >= 0) {
            map[k] = *it->q;
            map[2 + k] = *it->v;
        }
        stability_end(it);
    }
    printf("{\"oscillator\": \"%s\", \"y\": %.17g, \"status\": \"%s\", \"map\": ", method->name, y,
           pk_status_name(status));
    if (status < 0)
        fputs("null}\n", stdout);
    else
        printf("[%.17g, %.17g, %.17g, %.17g]}\n", map[0], map[1], map[2], map[3]);
    return 0;
}
