/* Writes the list of methods as JSON: traits, required facts about the system, and limits of the
 * step size on linear equations (pk/limits.h). An infinite one is "infinite", an unknown null. */
#define _POSIX_C_SOURCE 200809L

#include <pk/limits.h>
#include <pk/stability.h>

#include "../settings/settings.h"

enum { MOST_INTERVALS = 8 };
#define ENDLESS PK_C(1e30)

static void flags(struct json *j, const char *key, unsigned set, const char *const *names,
                  size_t count)
{
    json_open(j, key, '[');
    for (size_t i = 0; i < count; i++)
        if (set & (1u << i))
            json_text(j, NULL, names[i]);
    json_close(j, ']');
}

static void limit(struct json *j, const char *key, pk_real x)
{
    if (x > ENDLESS)
        json_text(j, key, "infinite");
    else
        json_real(j, key, x);
}

/* Writes both limits, and the intervals [[from, to], ...] on the imaginary axis in which steps
 * grow; the last one may be infinite. */
static void limits(struct json *j, const struct pk_method *method)
{
    pk_real found[2];
    int some = pk_method_growth(method, PK_AXIS_IMAGINARY, 0, found);
    json_open(j, "limits", '{');
    limit(j, "imaginary", some ? found[0] : PK_INFINITY - PK_INFINITY);
    limit(j, "real", pk_method_limit(method, PK_AXIS_REAL));
    json_close(j, '}');
    json_open(j, "growth", '[');
    for (int i = 0; some && i < MOST_INTERVALS && found[0] < ENDLESS; i++) {
        json_numbers(j, NULL, found, 2);
        some = found[1] < ENDLESS &&
               pk_method_growth(method, PK_AXIS_IMAGINARY, found[1] * (1 + PK_C(1e-9)), found);
    }
    json_close(j, ']');
}

static void described(struct json *j, const struct pk_method *m)
{
    static const char *const traits[] = {
        "symplectic", "symmetric", "adaptive",  "implicit", "dense", "jacobians", "linear",
        "no_inputs",  "exact",     "holonomic", "group",    "noise", "jets"};
    static const char *const facts[] = {
        "mass_constant", "mass_diagonal", "quadratic", "separable", "autonomous",
        "conservative",  "variational",   "smooth",    "affine",    "switched",
        "linear_drag",   "affine_rates",  "fast",      "series"};
    json_open(j, NULL, '{');
    json_text(j, "name", m->name);
    json_reals(j, {"order", m->order}, {"stages", m->stages}, {"dense_order", m->dense_order});
    flags(j, "flags", m->traits, traits, sizeof traits / sizeof *traits);
    flags(j, "requires", m->needs, facts, sizeof facts / sizeof *facts);
    limits(j, m);
    json_text(j, "doc", m->doc);
    json_close(j, '}');
}

const char *pk_stability_methods(const struct pk_run_model *model, int own)
{
    static _Thread_local char *text;
    size_t size;
    free(text);
    text = NULL;
    struct json json = {.file = open_memstream(&text, &size)}, *j = &json;
    if (!json.file)
        return NULL;
    json_open(j, NULL, '[');
    for (size_t i = own ? 0 : model->n_own; i < (own ? model->n_own : model->n_methods); i++)
        described(j, model->methods[i]);
    json_close(j, ']');
    fclose(json.file);
    return text;
}

int pk_stability_spring(const struct pk_run_model *model, const char *method, double stiffness,
                        double damping, double h, double *map)
{
    const struct pk_method *found = run_method_find(model, method);
    pk_real entries[4] = {0, 0, 0, 0};
    if (!found || found->traits & PK_ADAPTIVE)
        return PK_BAD_ARGUMENT;
    const enum pk_status status =
        pk_method_spring(found, (pk_real)stiffness, (pk_real)damping, (pk_real)h, entries);
    for (int i = 0; i < 4; i++)
        map[i] = status < 0 ? (double)NAN : (double)entries[i];
    return status;
}
