/* Saves and restores an integrator between two steps; see pk/keep.h. The memory of a method
 * contains only numbers, all in the block, so one function serves every method. */
#include <string.h>

#include <pk/keep.h>

#include "../core/internal.h"

/* number of bytes of the pointers in the private part; they are of this process, and not saved */
#define ADDRESSES offsetof(struct pk_integrator_private, slopes)

static unsigned long long name(const char *text)
{
    unsigned long long sum = 0;
    for (; *text; text++)
        sum = 31 * sum + (unsigned char)*text;
    return sum;
}

static int is_flag(int x) { return x == 0 || x == 1; }

/* Returns whether restored indices and flags of the private part are valid. Indices in the rest of
 * the block are checked where they are used, by pk_index(). */
static int sound(const struct pk_integrator *it, const struct pk_integrator_private *kept)
{
    const struct pk_integrator_private *own = it->own;
    const struct pk_system *system = it->problem.system;
    const int bound = own->crossing != NULL, marks = own->marks != NULL;
    if (!is_flag(kept->grid.off) || !is_flag(kept->ready) || !is_flag(kept->made) || !kept->ready ||
        kept->direction < -1 || kept->direction > 1)
        return 0;
    if ((kept->passing.crossed || kept->passing.near || kept->passing.seen) && !bound)
        return 0;
    if (!is_flag(kept->short_force.known) || kept->short_force.unlooked < 0 ||
        (kept->short_force.known && !marks))
        return 0;
    if (kept->trouble.status > PK_DONE || kept->trouble.status <= PK_STATUS_LAST)
        return 0;
    if (!pk_finite(it->t) || !pk_finite(it->last_t) || !pk_finite(kept->h) ||
        !(it->options.h >= 0) || !pk_finite(it->options.h))
        return 0;
    return it->status > PK_STATUS_LAST && it->status <= PK_STOPPED_USER &&
           it->event <= system->events.n &&
           (!it->passed_over.count || it->passed_over.which < system->marks.n);
}

enum pk_status pk_integrator_keep(struct pk_integrator *it, struct pk_keep *k)
{
    static const struct pk_integrator_private nowhere;
    struct pk_integrator_private *own = it->own;
    if (!own || !own->state || (it->method->release && !it->method->keep))
        return PK_REFUSED;
    struct pk_integrator_private kept = *own;
    int turned = own->next < own->state;
    pk_real *const first = turned ? own->next : own->state, *const end = own->params;
    pk_real *const second = first + pk_state_offset(it->n_q, it->n, PK_PARTS);

    pk_keep_same(k, name(it->method->name));
    pk_keep_same(k, sizeof kept + sizeof(pk_real));
    pk_keep_same(k, (unsigned long long)(end - first));
    memcpy(&kept, &nowhere, ADDRESSES);
    PK_KEEP(k, kept);
    memcpy(&kept, own, ADDRESSES);
    PK_KEEP(k, turned);
    pk_keep(k, first, (size_t)(end - first) * sizeof *first);
    PK_KEEP(k, it->t);
    PK_KEEP(k, it->last_t);
    PK_KEEP(k, it->count);
    PK_KEEP(k, it->passed_over);
    PK_KEEP(k, it->status);
    PK_KEEP(k, it->reason);
    PK_KEEP(k, it->event);
    PK_KEEP(k, it->options.h);
    const enum pk_status status = it->method->keep ? it->method->keep(it, k) : PK_DONE;
    k->wrong |= k->from && !sound(it, &kept);
    if (status < 0 || k->wrong)
        return status < 0 ? status : PK_BLOCK_TOO_SMALL;
    *own = kept;
    own->state = turned ? second : first;
    own->next = turned ? first : second;
    pk_point(it);
    return PK_DONE;
}
