/* Saves and restores an integrator between two steps as plain bytes; a restored integrator gives
 * the same bits as one that ran without interruption. One function writes, reads or counts:
 *
 *     struct pk_keep size = {0}, out = {0}, in = {0};
 *     pk_integrator_keep(&it, &size);                        (size.used bytes)
 *     out.to = bytes, out.size = size.used;
 *     pk_integrator_keep(&it, &out);
 *
 * and later, in this process or another of the same program on the same kind of machine, after
 * pk_integrator_init() with the same system, parameters, method, options and start:
 *
 *     in.from = bytes, in.size = size.used;
 *     status = pk_integrator_keep(&it, &in);                 (it.t, it.q, it.v are there)
 *
 * The bytes contain no addresses. Only their number and the stored sizes are verified: check bytes
 * of unknown origin before, as checkpoints do (docs/dev/checkpoints.md). */
#ifndef PK_KEEP_H
#define PK_KEEP_H

#include <stddef.h>

#include <pk/subsystems.h>
#include <pk/diagnostics.h>
#include <pk/events.h>
#include <pk/integrator.h>

PK_BEGIN

/* Writes to `to`, reads from `from`, or counts bytes if both are NULL. */
struct pk_keep {
    unsigned char *to;
    const unsigned char *from;
    size_t size, used; /* used: number of bytes so far, which may exceed `size` */
    /* 1: `size` is too small for the data, or a size read differs from that of the integrator */
    int wrong;
};

/* Writes, reads or counts the `size` bytes at `what`. */
void pk_keep(struct pk_keep *k, void *what, size_t size);
#define PK_KEEP(k, x) pk_keep(k, &(x), sizeof(x)) /* of a variable */
/* Writes a number; when reading, sets `wrong` if the number read differs. */
void pk_keep_same(struct pk_keep *k, unsigned long long number);

/* Returns PK_DONE, PK_REFUSED if the memory of the method is opaque (methods of pk/gsl.h except
 * Runge-Kutta methods), or PK_BLOCK_TOO_SMALL if k->wrong is set. After PK_BLOCK_TOO_SMALL, an
 * integrator that was to be restored must be initialised again. Do not call it within a step. */
enum pk_status pk_integrator_keep(struct pk_integrator *it, struct pk_keep *k);
/* Each of these functions saves or restores the private data of its struct. pk_events_keep() does
 * not include the integrator whose events are located; save that separately. */
enum pk_status pk_events_keep(struct pk_events *events, struct pk_keep *k);
enum pk_status pk_subsystems_keep(struct pk_subsystems *apart, struct pk_keep *k);
void pk_drift_keep(struct pk_drift *drift, struct pk_keep *k);
void pk_monitor_keep(struct pk_monitor *monitor, struct pk_keep *k);

PK_END

#endif
