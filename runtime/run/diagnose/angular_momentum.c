/* Angular momentum of a run's particles, and its torque. If the torque is always 0, the model
 * conserves angular momentum. */
#include "bodies.h"

struct turning {
    struct pk_drift drift[2][3]; /* [0] about the origin; [1] about the centre of mass */
    /* `torque`: largest component of the torque so far; `arm`: size of the terms of which it is the
     * sum */
    pk_real first[2][3], last[2][3], torque[2], arm[2];
    int moves[3]; /* whether a particle moves along each axis */
};

static void turn(void *context, struct bodies *b, pk_real t)
{
    struct turning *x = context;
    for (int centre = 0; centre < 2; centre++) {
        pk_real size, torque[3];
        pk_angular_momentum(b->n, b->m, b->r, b->v, centre, x->last[centre], &size);
        for (int k = 0; k < 3; k++)
            pk_drift_update_scaled(&x->drift[centre][k], t, x->last[centre][k], size);
        pk_angular_momentum(b->n, b->m, b->r, b->a, centre, torque, &size);
        for (int k = 0; k < 3; k++)
            x->torque[centre] = PK_F(fmax)(x->torque[centre], PK_F(fabs)(torque[k]));
        x->arm[centre] = PK_F(fmax)(x->arm[centre], size);
    }
    for (size_t i = 0; i < 3 * b->n; i++)
        x->moves[i % 3] |= PK_F(fabs)(b->r[i]) > 0 || PK_F(fabs)(b->v[i]) > 0;
}

/* Returns the axis normal to a planar motion, or -1 if the motion is not planar. */
static int normal(const struct turning *x)
{
    return !x->moves[2] ? 2 : !x->moves[1] ? 1 : !x->moves[0] ? 0 : -1;
}

static void about(struct json *j, const char *key, const struct turning *x, int centre)
{
    static const char *const axes[] = {"L_x", "L_y", "L_z"};
    const int only = normal(x);
    json_open(j, key, '{');
    json_numbers(j, "first", x->first[centre], 3);
    json_numbers(j, "final", x->last[centre], 3);
    json_real(j, "torque", x->arm[centre] > 0 ? x->torque[centre] / x->arm[centre] : 0);
    json_open(j, "drifts", '[');
    for (int k = 0; k < 3; k++)
        if (only < 0 || k == only)
            report_drift(j, NULL, axes[k], &x->drift[centre][k]);
    json_close(j, ']');
    json_close(j, '}');
}

void diagnose_angular_momentum(struct pk_run *run, struct diagnostics *d)
{
    struct bodies b;
    struct turning x = {0};
    struct json *j = &d->json;
    if (!bodies_begin(&b, run)) {
        diagnose_told(d, PK_REFUSED, BODIES_NONE, NULL);
        return;
    }
    b.see = turn;
    b.context = &x;
    turn(&x, &b, 0);
    memcpy(x.first, x.last, sizeof x.first);
    const enum pk_status status = bodies_follow(&b);
    if (!diagnose_told(d, status, NULL, &b.it))
        return;
    json_integer(j, "particles", b.n);
    about(j, "origin", &x, 0);
    if (b.n > 1)
        about(j, "centre", &x, 1);
    else
        json_text(j, "centre", NULL);
}
