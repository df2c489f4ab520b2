/* Saves or restores bytes; see pk/keep.h. */
#include <string.h>

#include <pk/keep.h>

void pk_keep(struct pk_keep *k, void *what, size_t size)
{
    const size_t at = k->used;
    k->used = size > (size_t)-1 - at ? (size_t)-1 : at + size;
    if (!k->to && !k->from)
        return;
    if (k->wrong || k->used > k->size)
        k->wrong = 1;
    else if (size && k->to)
        memcpy(k->to + at, what, size);
    else if (size)
        memcpy(what, k->from + at, size);
}

void pk_keep_same(struct pk_keep *k, unsigned long long number)
{
    unsigned long long found = number;
    PK_KEEP(k, found);
    k->wrong |= found != number;
}
