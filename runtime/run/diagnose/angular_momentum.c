/* Angular momentum of a run's particles, and whether the model conserves it: by its torque. */
#include "bodies.h"

#include <stdlib.h>
#include <string.h>

struct turning {
    struct pk_drift drift[2][3]; /* about the origin, about the centre of mass */
    pk_real first[2][3], last[2][3], torque[2], arm[2];
    int moves[3]; /* along which axes */
};

static void turn(void *context, struct bodies *b, pk_real t)
{
    struct turning *x = (struct turning *)context;
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

/* The axis that a motion in a plane turns about; -1: it is one in space. */
static int normal(const struct turning *x)
{
    return !x->moves[2] ? 2 : !x->moves[1] ? 1 : !x->moves[0] ? 0 : -1;
}

static void about(FILE *file, const struct turning *x, int centre)
{
    static const char *const axes[] = {"L_x", "L_y", "L_z"};
    const int only = normal(x);
    const char *before = "";
    fputs("{", file);
    report_numbers(file, "first", x->first[centre], 3);
    fputs(", ", file);
    report_numbers(file, "final", x->last[centre], 3);
    fputs(", \"torque\": ", file);
    report_real(file, x->arm[centre] > 0 ? x->torque[centre] / x->arm[centre] : 0);
    fputs(", \"drifts\": [", file);
    for (int k = 0; k < 3; k++) {
        if (only >= 0 && k != only)
            continue;
        fputs(before, file);
        report_drift(file, axes[k], &x->drift[centre][k]);
        before = ", ";
    }
    fputs("]}", file);
}

void diagnose_angular_momentum(struct run *run, struct diagnostics *d)
{
    struct bodies b;
    struct turning x = {0};
    char reason[512];
    if (!bodies_begin(&b, run)) {
        diagnose_member(d, "angular_momentum", PK_REFUSED, BODIES_NONE);
        return;
    }
    b.see = turn;
    b.context = &x;
    turn(&x, &b, 0);
    memcpy(x.first, x.last, sizeof x.first);
    const enum pk_status status = bodies_follow(&b, reason, sizeof reason);
    if (diagnose_member(d, "angular_momentum", status, reason)) {
        fprintf(d->file, ", \"particles\": %zu, \"origin\": ", b.n);
        about(d->file, &x, 0);
        fputs(", \"centre\": ", d->file);
        if (b.n > 1)
            about(d->file, &x, 1);
        else
            fputs("null", d->file);
        fputs("}", d->file);
    }
}
