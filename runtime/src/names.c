/* Names of coordinates whose families are kept as loops: the declared name with its index. */
#include <stdio.h>
#include <string.h>

#include <pk/system.h>

int pk_system_name(const struct pk_system *system, const void *params,
                   const struct pk_quantity *table, size_t i, char *text, size_t size)
{
    struct pk_range range = {0, 1, 0};
    size_t k = i;
    if (!table)
        return snprintf(text, size, "?");
    for (k = 0; system->range && k < system->n_coordinates; k++) {
        system->range(params, 0, k, &range);
        if (i < range.count)
            break;
        i -= range.count;
    }
    if (!system->range || k >= system->n_coordinates)
        return snprintf(text, size, "%s", table[system->range ? 0 : i].name);
    if (!range.is_family)
        return snprintf(text, size, "%s", table[k].name);
    /* Primes stand behind the index. */
    const int stem = (int)strcspn(table[k].name, "'");
    return snprintf(text, size, "%.*s[%td]%s", stem, table[k].name, range.lo + (ptrdiff_t)i,
                    table[k].name + stem);
}
