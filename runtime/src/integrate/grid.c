/* Chooses the length of the next step, or ends the run: the grid of fixed steps, the limit on their
 * number, checks of progress. Times of fixed steps are anchor + k h, rounded twice, so that
 * rounding does not accumulate. */
#include "../core/internal.h"

/* Number of trial steps before the first check of progress: FIRST_LOOK if many of them are
 * rejected, otherwise LATER_LOOK. */
enum { FIRST_LOOK = 1 << 12, LATER_LOOK = 1 << 16 };
/* largest number of further steps that may be needed, if max_steps is 0 */
#define MOST_AHEAD PK_C(1e9)
/* If many trial steps are rejected, and steps are shorter than SHRUNK times the longest rejected
 * one, the error estimates are noise. Then the run ends if it needs over MOST_SHRUNK / n steps. */
#define SHRUNK PK_C(1e-6)
#define MOST_SHRUNK PK_C(1e7)

struct pk_planned pk_step_planned(const struct pk_integrator *it, pk_real limit)
{
    const pk_real sign = pk_direction(it), h = sign * it->options.h;
    const pk_real target = it->own->grid.anchor + (it->own->grid.count + 1) * h;
    const pk_real close = 4 * PK_EPS * pk_max(pk_abs(it->t), pk_abs(limit));
    if (pk_abs(target - limit) <= close) /* target and limit differ only by rounding */
        return (struct pk_planned){h, limit, 0};
    if (sign * (target - limit) < 0)
        return (struct pk_planned){h, target, 0};
    return (struct pk_planned){limit - it->t, limit, 1};
}

unsigned long pk_step_count(const struct pk_integrator *it, pk_real limit, unsigned long most)
{
    /* Times are rounded: a step that ends within `close` of the limit is the last one, and does not
     * count. */
    const pk_real close = 4 * PK_EPS * pk_max(pk_abs(it->t), pk_abs(limit));
    const pk_real count = (pk_abs(limit - it->t) - close) / it->options.h, ceiling = PK_C(1e9);
    if (!(count > 0))
        return 0;
    const unsigned long steps = (unsigned long)(count < ceiling ? count : ceiling);
    return steps < most ? steps : most;
}

int pk_often_rejected(const struct pk_integrator *it)
{
    const struct pk_progress *p = &it->own->progress;
    const unsigned long tried = it->count.steps + it->count.rejections - p->judged;
    return 4 * (it->count.rejections - p->judged_rejections) > tried;
}

/* Returns whether time hardly advances, so that the run is to end. It checks this whenever the
 * number of trial steps has doubled since the last check; so the result does not depend on the
 * speed of the machine. Progress sums the lengths of steps, since a caller may go back. */
static int stands_still(struct pk_integrator *it, pk_real left)
{
    struct pk_progress *p = &it->own->progress;
    const unsigned long tried = it->count.steps + it->count.rejections;
    if (tried < FIRST_LOOK || tried / 2 < p->judged)
        return 0;
    const unsigned long given = it->options.max_steps;
    const pk_real rate = (p->passed - p->judged_passed) / (pk_real)(tried - p->judged);
    const int shrunk = !given && pk_often_rejected(it) && rate < SHRUNK * p->longest;
    const pk_real most = given    ? (pk_real)given
                         : shrunk ? MOST_SHRUNK / (pk_real)it->n
                                  : MOST_AHEAD;
    const pk_real ahead = shrunk ? pk_abs(left) : pk_min(p->passed, pk_abs(left));
    if (ahead > most * rate && (shrunk || tried >= LATER_LOOK)) {
        it->reason = PK_WHY(.value = rate > 0 ? ahead / rate : PK_INFINITY);
        return 1;
    }
    p->judged = tried;
    p->judged_rejections = it->count.rejections;
    p->judged_t = it->t;
    p->judged_passed = p->passed;
    return 0;
}

static enum pk_status check_step(struct pk_integrator *it, pk_real limit, int fixed)
{
    if (pk_sides_missing(it))
        return PK_REFUSED;
    if (it->options.max_steps && it->count.steps >= it->options.max_steps)
        return PK_TOO_MANY_STEPS;
    if (stands_still(it, limit - it->t))
        return PK_NO_PROGRESS;
    if (!fixed)
        return PK_DONE;
    /* only trial steps of adaptive methods set this status again */
    it->own->trouble.status = PK_DONE;
    if (it->options.h <= 10 * PK_EPS * pk_abs(it->t) && pk_abs(limit - it->t) > it->options.h)
        return pk_fail_with(it, PK_STEP_UNDERFLOW, PK_WHY(.value = it->options.h));
    return PK_DONE;
}

enum pk_status pk_step_choose(struct pk_integrator *it, pk_real limit, int fixed)
{
    struct pk_integrator_private *const own = it->own;
    PK_TRY(check_step(it, limit, fixed));
    const int direction = limit > it->t ? 1 : -1;
    if (direction != own->direction) {
        own->direction = direction;
        own->grid.anchor = it->t;
        own->grid.count = 0;
        own->h = 0;
    }
    own->grid.off = 0;
    if (fixed) {
        const struct pk_planned x = pk_step_planned(it, limit);
        own->h = x.h;
        own->next_t = x.end;
        own->grid.off = x.off_grid;
    }
    return PK_DONE;
}

void pk_step_advance_time(struct pk_integrator *it, int fixed)
{
    it->last_t = it->t;
    it->t = it->own->next_t;
    it->own->progress.passed += pk_abs(it->t - it->last_t);
    it->count.steps++;
    if (it->own->grid.off) {
        it->own->grid.anchor = it->t;
        it->own->grid.count = 0;
    } else if (fixed) {
        it->own->grid.count += 1;
    }
}

int pk_integrator_is_at(const struct pk_integrator *it, pk_real t)
{
    return pk_abs(it->t - t) <= 4 * PK_EPS * pk_max(pk_abs(it->t), pk_abs(t));
}

pk_real pk_integrator_limit(const struct pk_integrator *it, pk_real t, pk_real limit)
{
    const int direction = t > it->t ? 1 : -1;
    /* the direction is new, so the step begins a new grid */
    const int begins = direction != it->own->direction;
    const pk_real anchor = begins ? it->t : it->own->grid.anchor,
                  h = (pk_real)direction * it->options.h;
    const pk_real count = PK_F(floor)((t - anchor) / h + PK_C(0.5));
    const struct pk_integrator then = {.t = anchor + count * h};
    return count > (begins ? 0 : it->own->grid.count) && pk_integrator_is_at(&then, t) ? t : limit;
}
