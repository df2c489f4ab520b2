/* The methods, and their list in JSON: what each is and needs, and where its steps grow on linear
 * equations (pk/limits.h). A limit that is infinite is the word, one without an answer null.
 */
#define _POSIX_C_SOURCE 200809L

#include <pk/limits.h>

#include "settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>
#endif

enum { MOST_INTERVALS = 8 };
#define ENDLESS PK_C(1e30)

const struct pk_method *run_method_at(size_t index)
{
    size_t core = 0;
    while (pk_method_at(core))
        core++;
#ifdef PK_WITH_GSL
    if (index >= core)
        return pk_gsl_method_at(index - core);
#endif
    return pk_method_at(index);
}

const struct pk_method *run_method_find(const struct pk_run_model *model, const char *name)
{
    for (size_t i = 0; name && i < model->n_methods; i++)
        if (strcmp(model->methods[i]->name, name) == 0)
            return model->methods[i];
    for (size_t i = 0; name && run_method_at(i); i++)
        if (strcmp(run_method_at(i)->name, name) == 0)
            return run_method_at(i);
    return NULL;
}

const char *run_method_lack(const char *name)
{
#ifndef PK_WITH_GSL
    if (strncmp(name, "gsl_", 4) == 0)
        return "; this was built without GSL: install it (libgsl-dev), or pkgen build --gsl";
#endif
    (void)name;
    return "";
}

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

/* Both limits, and [[from, to], ...] on the imaginary axis; the last one may have no end. */
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
    static const char *const traits[] = {"symplectic", "symmetric", "adaptive", "implicit",
                                         "dense",      "jacobians", "linear",   "no_inputs",
                                         "exact",      "holonomic", "group"};
    static const char *const facts[] = {
        "mass_constant", "mass_diagonal", "quadratic", "separable", "autonomous",
        "conservative",  "variational",   "smooth",    "affine",    "switched",
        "linear_drag",   "affine_rates",  "fast"};
    json_open(j, NULL, '{');
    json_text(j, "name", m->name);
    json_reals(j, {"order", m->order}, {"stages", m->stages}, {"dense_order", m->dense_order});
    flags(j, "flags", m->traits, traits, sizeof traits / sizeof *traits);
    flags(j, "requires", m->needs, facts, sizeof facts / sizeof *facts);
    limits(j, m);
    json_text(j, "doc", m->doc);
    json_close(j, '}');
}

/* The model's own, or without a model all others, into `text`, where the last answer stood. */
static const char *list(const struct pk_run_model *model, char **text)
{
    size_t size;
    free(*text);
    *text = NULL;
    struct json json = {.file = open_memstream(text, &size)}, *j = &json;
    if (!json.file)
        return NULL;
    json_open(j, NULL, '[');
    for (size_t i = 0; model ? i < model->n_methods : run_method_at(i) != NULL; i++)
        described(j, model ? model->methods[i] : run_method_at(i));
    json_close(j, ']');
    fclose(json.file);
    return *text;
}

const char *pk_run_methods(void)
{
    static char *text; /* found once */
    return text ? text : list(NULL, &text);
}

const char *pk_run_own_methods(const struct pk_run_model *model)
{
    static char *text;
    return list(model, &text);
}
