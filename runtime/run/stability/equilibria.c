/* The equilibria of the system and their modes. Only built with GSL. */
#include "stability.h"

#ifdef PK_WITH_GSL

enum { MOST = 32 };
static const double SAME = 1e-2; /* relative difference of lambda at the root and near it */

/* Up to 2 n modes, as pk_gsl_modes() gives them. */
struct modes {
    struct pk_mode *list;
    double *shapes;
    size_t count;
};

/* Sets lambda of spurious modes to 0. If the linear terms vanish at the root, their numerical value
 * is proportional to the error of the root, about Newton's last correction. A mode that changes
 * when the root is shifted by that much is spurious. */
static void clear_doubtful(struct pk_stability *s, const double *q, const double *v,
                           const double *doubt, struct modes *modes, struct modes *beside)
{
    double *const place = s->work, *const rate = place + s->n;
    for (size_t i = 0; i < s->n; i++) {
        const int c = i >= s->coordinates || stability_idle(s, i);
        place[i] = q[i] + (c ? 0 : doubt[i]);
        rate[i] = v[i] + (c ? doubt[i] : 0);
    }
    if (pk_gsl_modes(&s->problem, place, rate, beside->list, beside->shapes, &beside->count))
        return;
    for (size_t k = 0; k < modes->count; k++) {
        struct pk_mode *one = &modes->list[k];
        int stays = 0;
        for (size_t i = 0; i < beside->count && !stays; i++)
            stays = hypot(one->growth - beside->list[i].growth,
                          one->frequency - beside->list[i].frequency) <=
                    SAME * hypot(one->growth, one->frequency);
        if (!stays)
            one->growth = one->frequency = 0;
    }
}

static void print_modes(struct pk_stability *s, const struct modes *modes)
{
    const size_t n = s->n;
    struct json *j = &s->out;
    json_open(j, "modes", '[');
    for (size_t m = 0; m < modes->count; m++) {
        json_open(j, NULL, '{');
        json_reals(j, {"growth", modes->list[m].growth}, {"frequency", modes->list[m].frequency});
        json_numbers(j, "re", modes->shapes + m * 2 * n, n);
        json_numbers(j, "im", modes->shapes + m * 2 * n + n, n);
        json_close(j, '}');
    }
    json_close(j, ']');
}

static void print(struct pk_stability *s, const struct pk_equilibria *found, struct modes *modes,
                  struct modes *beside)
{
    const size_t n = s->n;
    struct json *j = &s->out;
    json_open(j, "equilibria", '[');
    for (size_t k = 0; k < found->count; k++) {
        double energy, vp, size;
        const double *q = found->q + k * n, *v = found->v + k * n;
        const enum pk_status solved =
            pk_gsl_modes(&s->problem, q, v, modes->list, modes->shapes, &modes->count);
        clear_doubtful(s, q, v, found->doubt + k * n, modes, beside);
        stability_energies(s, 0, q, v, &energy, &vp, &size);
        json_open(j, NULL, '{');
        json_numbers(j, "q", q, n);
        json_numbers(j, "v", v, n);
        json_real(j, "energy", energy);
        json_text(j, "status", pk_status_name(solved));
        json_integer(j, "slack", found->slack[k]);
        print_modes(s, modes);
        json_close(j, '}');
    }
    json_close(j, ']');
}

int stability_equilibria(struct pk_stability *s, const struct pk_stability_question *x)
{
    const size_t n = s->n;
    double *const room =
        memory_take(&s->run->memory, 3 * MOST * n + 2 * n + 8 * n * n, sizeof *room);
    double *const shapes = room + 3 * MOST * n + 2 * n;
    struct pk_mode *const list = memory_take(&s->run->memory, 4 * n, sizeof *list);
    struct modes modes = {list, shapes, 0}, beside = {list + 2 * n, shapes + 4 * n * n, 0};
    struct pk_equilibria found = {.most = MOST,
                                  .q = room,
                                  .v = room + MOST * n,
                                  .doubt = room + 2 * MOST * n,
                                  .middle = room + 3 * MOST * n,
                                  .box = room + 3 * MOST * n + n,
                                  .slack = memory_take(&s->run->memory, MOST, sizeof(size_t)),
                                  .turns = memory_take(&s->run->memory, n, 1)};
    const enum pk_status status =
        pk_gsl_equilibria(&s->problem, s->settings->q, s->settings->v, x->count, &found);
    for (size_t i = 0; i < n; i++)
        s->work[i] = found.turns[i];
    json_text(&s->out, "status", pk_status_name(status));
    json_counts(&s->out, {"failed", found.failed}, {"singular", found.singular});
    json_flag(&s->out, "more", found.more);
    json_numbers(&s->out, "turns", s->work, n);
    json_numbers(&s->out, "middle", found.middle, n);
    json_numbers(&s->out, "box", found.box, n);
    print(s, &found, &modes, &beside);
    memory_drop(&s->run->memory, found.slack);
    memory_drop(&s->run->memory, found.turns);
    memory_drop(&s->run->memory, list);
    memory_drop(&s->run->memory, room);
    return 1;
}

#else
extern int stability_equilibria_need_gsl; /* ISO C forbids an empty file */
#endif
