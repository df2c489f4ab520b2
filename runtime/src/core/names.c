/* Names in systems of variable size. The name of a coordinate is the declared name with its index,
 * such as q[3]. The name of a singularity or switch is its expression, with numbers as indices. */
#include <stdio.h>
#include <string.h>

#include <pk/system.h>

/* the linker needs the address of this symbol; its value is never read */
const char PK_SCALAR[] = "pk_real";

/* Writes the name of number i, where i counts all members of `count` declared names. With count = 0
 * it is the name of table[i]. */
static int name_of(const struct pk_system *system, const void *params, enum pk_range_of of,
                   size_t count, const struct pk_quantity *table, size_t i, char *text, size_t size)
{
    struct pk_range range = {0, 1, 0};
    size_t k;
    for (k = 0; k < count; k++) {
        range = pk_system_range(system, params, of, k);
        if (i < range.count)
            break;
        i -= range.count;
    }
    if (k >= count)
        return snprintf(text, size, "%s", table[count ? 0 : i].name);
    if (!range.is_family)
        return snprintf(text, size, "%s", table[k].name);
    /* The index precedes components and primes: r[1].x, q[1]', omega(R[1]).x. */
    const int stem = (int)strcspn(table[k].name, ".)'");
    return snprintf(text, size, "%.*s[%td]%s", stem, table[k].name, range.lo + (ptrdiff_t)i,
                    table[k].name + stem);
}

int pk_system_name(const struct pk_system *system, const void *params,
                   const struct pk_quantity *table, size_t i, char *text, size_t size)
{
    const size_t count = system->families.range ? system->families.n_coordinates : 0;
    if (!table || (!count && i >= system->n))
        return snprintf(text, size, "?");
    return name_of(system, params, PK_OF_COORDINATE, count, table, i, text, size);
}

int pk_system_output_name(const struct pk_system *system, const void *params, size_t i, char *text,
                          size_t size)
{
    return name_of(system, params, PK_OF_OUTPUT, system->families.n_outputs, system->observed, i,
                   text, size);
}

/* Reads an index such as "[i+1]" or "[j-2]" as a number. Returns its end, or NULL. */
static const char *index_of(const char *text, const struct pk_place *place, ptrdiff_t *index)
{
    ptrdiff_t number = 0;
    if (text[0] != '[' || (text[1] != 'i' && text[1] != 'j'))
        return NULL;
    *index = text[1] == 'i' ? place->i : place->j;
    const int sign = text[2] == '-' ? -1 : 1;
    text += text[2] == '+' || text[2] == '-' ? 3 : 2;
    for (; *text >= '0' && *text <= '9'; text++)
        number = 10 * number + (*text - '0');
    *index += sign * number;
    return *text == ']' ? text + 1 : NULL;
}

/* Writes a name with the indices i and j replaced by those of `place`, unless that is NULL. */
static int placed(const char *from, const struct pk_place *place, char *text, size_t size)
{
    size_t at = 0;
    if (size)
        *text = 0;
    while (*from) {
        ptrdiff_t index = 0;
        const char *end = place ? index_of(from, place, &index) : NULL;
        char *const to = at < size ? text + at : NULL;
        const size_t room = at < size ? size - at : 0;
        at += (size_t)(end ? snprintf(to, room, "[%td]", index) : snprintf(to, room, "%c", *from));
        from = end ? end : from + 1;
    }
    return (int)at;
}

int pk_system_singularity_name(const struct pk_system *system, const void *params, size_t k,
                               char *text, size_t size)
{
    const struct pk_place place = pk_system_singularity(system, params, k);
    return placed(system->singularities.table[place.which].what.name,
                  system->singularities.place ? &place : NULL, text, size);
}

int pk_system_switch_name(const struct pk_system *system, const void *params, size_t k, char *text,
                          size_t size)
{
    if (k >= pk_system_switch_count(system, params))
        return snprintf(text, size, "x");
    const struct pk_place place = pk_system_switch(system, params, k);
    return placed(system->switches.names[place.which].name, system->switches.place ? &place : NULL,
                  text, size);
}
