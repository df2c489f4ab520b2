/* Saves and restores an integrator between two steps as plain bytes; a restored one continues to
 * the same bits as if it had never stopped. One function writes, reads or counts the bytes:
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
 * The bytes contain no addresses. They are trusted if their shape is right: check bytes from
 * elsewhere before, as checkpoints do (docs/dev/checkpoints.md).
 */
#ifndef PK_KEEP_H
#define PK_KEEP_H

#include <stddef.h>

#include <pk/subsystems.h>
#include <pk/diagnostics.h>
#include <pk/events.h>
#include <pk/integrator.h>

PK_BEGIN

/* Writes to `to` or reads from `from`; counts if both are NULL. */
struct pk_keep {
    unsigned char *to;
    const unsigned char *from;
    size_t size, used; /* used: bytes so far, including those without room */
    int wrong;         /* no room, or the bytes read have another shape */
};

/* Keeps `size` bytes at `what`. */
void pk_keep(struct pk_keep *k, void *what, size_t size);
/* Keeps a number; sets `wrong` if the number read differs. */
void pk_keep_same(struct pk_keep *k, unsigned long long number);

/* Returns PK_DONE; PK_REFUSED if the memory of the method is opaque (methods of pk/gsl.h except
 * Runge-Kutta ones); PK_BLOCK_TOO_SMALL if k->wrong, and then an integrator being restored must be
 * initialised again. Not to be called within a step. */
enum pk_status pk_integrator_keep(struct pk_integrator *it, struct pk_keep *k);
/* Keep the private data of these structs; events without their integrator. */
enum pk_status pk_events_keep(struct pk_events *events, struct pk_keep *k);
enum pk_status pk_subsystems_keep(struct pk_subsystems *apart, struct pk_keep *k);
void pk_drift_keep(struct pk_drift *drift, struct pk_keep *k);
void pk_monitor_keep(struct pk_monitor *monitor, struct pk_keep *k);

PK_END

#endif
