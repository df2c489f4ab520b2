/* The registry of pk/methods.h, as an array. */
#include <string.h>

#include "core/tableau.h"

#define ADDRESS(A, name, ...) &pk_method_##name,
static const struct pk_method *const methods[] = {PK_METHODS_CORE(ADDRESS, )};

const struct pk_method *pk_method_at(size_t index)
{
    return index < sizeof methods / sizeof *methods ? methods[index] : NULL;
}

const struct pk_method *pk_method_find(const char *name)
{
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        if (strcmp(methods[i]->name, name) == 0)
            return methods[i];
    return NULL;
}
