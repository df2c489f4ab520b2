/* What stands between two steps, as plain bytes: an integrator that is given them back goes on to
 * the bit as if it had never stopped. The same call writes them, reads them, or counts them:
 *
 *     struct pk_keep size = {0}, out = {0}, in = {0};
 *     pk_integrator_keep(&it, &size);                        (size.used bytes)
 *     out.to = bytes, out.size = size.used;
 *     pk_integrator_keep(&it, &out);
 *
 * and later, in this process or another of the same program on the same kind of machine, behind
 * pk_integrator_init() with the same system, parameters, method, options and start:
 *
 *     in.from = bytes, in.size = size.used;
 *     status = pk_integrator_keep(&it, &in);                 (it.t, it.q, it.v are there)
 *
 * Bytes hold no addresses. They are believed where their shape is right: whoever takes them from
 * elsewhere checks them first, as checkpoints do (docs/dev/checkpoints.md).
 */
#ifndef PK_KEEP_H
#define PK_KEEP_H

#include <stddef.h>

#include <pk/apart.h>
#include <pk/diagnostics.h>
#include <pk/events.h>
#include <pk/integrator.h>

PK_BEGIN

/* Where numbers go, or where they come from; with neither they are counted. */
struct pk_keep {
    unsigned char *to;
    const unsigned char *from;
    size_t size, used; /* used: also of what there was no room for */
    int wrong;         /* there was none, or what came is of another shape */
};

/* So many bytes at `what`. */
void pk_keep(struct pk_keep *k, void *what, size_t size);
/* A number that is to be the same where it is read: else `wrong`. */
void pk_keep_same(struct pk_keep *k, unsigned long long number);

/* PK_DONE; PK_REFUSED: the method has memory that nobody else sees (those of pk/gsl.h but for
 * Runge-Kutta's); PK_BLOCK_TOO_SMALL: k->wrong, and where it was read the integrator is to be
 * initialised again. Not within a step. */
enum pk_status pk_integrator_keep(struct pk_integrator *it, struct pk_keep *k);
/* What is behind these, without the integrator that events belong to. */
enum pk_status pk_events_keep(struct pk_events *events, struct pk_keep *k);
enum pk_status pk_apart_keep(struct pk_apart *apart, struct pk_keep *k);
void pk_drift_keep(struct pk_drift *drift, struct pk_keep *k);
void pk_monitor_keep(struct pk_monitor *monitor, struct pk_keep *k);

PK_END

#endif
