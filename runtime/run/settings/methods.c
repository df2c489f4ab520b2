/* The methods that a program is linked with. */
#include "settings.h"

const struct pk_method *run_method_find(const struct pk_run_model *model, const char *name)
{
    for (size_t i = 0; name && i < model->n_methods; i++)
        if (strcmp(model->methods[i]->name, name) == 0)
            return model->methods[i];
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
