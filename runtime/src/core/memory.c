/* Assigns parts of one block of memory; see internal.h. */
#include "internal.h"

size_t pk_lay_out(pk_real *base, const struct pk_slot *slots, size_t count)
{
    size_t used = 0;
    for (size_t i = 0; i < count; used += slots[i++].count)
        *slots[i].part = base ? base + used : NULL;
    return used;
}
