/* A model of the layer of runs with all that it can be linked with. */
#include <pk/gsl.h>
#include <pk/methods.h>
#include <pk/run.h>

#include "systems.h"

PK_METHODS_GSL(PK_DECLARE_METHOD, )
#define ADDRESS(A, name, ...) &pk_method_##name,
static const struct pk_method *const methods[] = {PK_METHODS_CORE(ADDRESS, )
                                                      PK_METHODS_GSL(ADDRESS, )};
#define RUN_MODEL(of, of_parts, count)              \
    {.system = &of,                                 \
     .parts = of_parts,                             \
     .n_parts = count,                              \
     .methods = methods,                            \
     .n_methods = sizeof methods / sizeof *methods, \
     .diagnose = &pk_run_diagnose,                  \
     .ensemble = &pk_run_ensemble}
