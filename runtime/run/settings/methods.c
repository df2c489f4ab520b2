/* The methods, and their list, a line of JSON each: what each is and needs, and where its steps grow on
 * linear equations (pk/limits.h). A limit that is infinite is the word, one without an answer null.
 */
#define _POSIX_C_SOURCE 200809L

#include <pk/limits.h>

#include <string.h>

#include "../base/json.h"
#include "settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>
#endif

enum { MOST_INTERVALS = 8 };

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

const struct pk_method *run_method_find(const char *name)
{
    for (size_t i = 0; name && run_method_at(i); i++)
        if (strcmp(run_method_at(i)->name, name) == 0)
            return run_method_at(i);
    return NULL;
}

static void flags(FILE *file, unsigned set, const char *const *names, size_t count)
{
    int first = 1;
    fputc('[', file);
    for (size_t i = 0; i < count; i++)
        if (set & (1u << i)) {
            fprintf(file, "%s\"%s\"", first ? "" : ", ", names[i]);
            first = 0;
        }
    fputc(']', file);
}

static void limit(FILE *file, pk_real x)
{
    if (x > PK_C(1e30))
        fputs("\"infinite\"", file);
    else
        report_real(file, x);
}

/* Both limits, and [[from, to], ...] on the imaginary axis; the last one may have no end. */
static void limits(FILE *file, const struct pk_method *method)
{
    pk_real found[2];
    int some = pk_method_growth(method, PK_AXIS_IMAGINARY, 0, found);
    fputs("\"limits\": {\"imaginary\": ", file);
    limit(file, some ? found[0] : PK_INFINITY - PK_INFINITY);
    fputs(", \"real\": ", file);
    limit(file, pk_method_limit(method, PK_AXIS_REAL));
    fputs("}, \"growth\": [", file);
    for (int i = 0; some && i < MOST_INTERVALS && found[0] < PK_C(1e30); i++) {
        fputs(i ? ", [" : "[", file);
        report_real(file, found[0]);
        fputs(", ", file);
        report_real(file, found[1]);
        fputc(']', file);
        some = found[1] < PK_C(1e30) &&
               pk_method_growth(method, PK_AXIS_IMAGINARY, found[1] * (1 + PK_C(1e-9)), found);
    }
    fputc(']', file);
}

const char *pk_run_methods(void)
{
    static char *text; /* found once */
    size_t size;
    FILE *file = text ? NULL : open_memstream(&text, &size);
    if (!file)
        return text;
    static const char *const traits[] = {"symplectic", "symmetric", "adaptive",  "implicit",
                                         "dense",      "jacobians", "linear",    "no_inputs",
                                         "quadrature", "exact",     "holonomic", "group"};
    static const char *const facts[] = {"mass_constant", "mass_diagonal", "quadratic",
                                        "separable",     "autonomous",    "conservative",
                                        "variational",   "smooth",        "affine"};
    for (size_t i = 0; run_method_at(i); i++) {
        const struct pk_method *m = run_method_at(i);
        fprintf(file, "{\"name\": \"%s\", \"order\": %d, \"stages\": %d, \"dense_order\": %d, ",
                m->name, m->order, m->stages, m->dense_order);
        fputs("\"flags\": ", file);
        flags(file, m->traits, traits, sizeof traits / sizeof *traits);
        fputs(", \"requires\": ", file);
        flags(file, m->needs, facts, sizeof facts / sizeof *facts);
        fputs(", ", file);
        limits(file, m);
        fputs(", \"doc\": ", file);
        report_text(file, m->doc);
        fputs("}\n", file);
    }
    fclose(file);
    return text;
}
