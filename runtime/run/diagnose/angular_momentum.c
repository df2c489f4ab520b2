/* Angular momentum of a run's particles, and its torque, 0 where the model conserves it. */
#include "bodies.h"

void angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                      int about_centre, pk_real L[3], pk_real *size)
{
    pk_real mass = 0, R[3] = {0, 0, 0}, V[3] = {0, 0, 0};
    for (size_t i = 0; i < n && about_centre; i++) {
        mass += m[i];
        for (size_t k = 0; k < 3; k++) {
            R[k] += m[i] * r[3 * i + k];
            V[k] += m[i] * v[3 * i + k];
        }
    }
    for (size_t k = 0; k < 3 && about_centre; k++) {
        R[k] /= mass;
        V[k] /= mass;
    }
    memset(L, 0, 3 * sizeof *L);
    *size = 0;
    for (size_t i = 0; i < n; i++) {
        pk_real x[3], u[3], l[3];
        for (size_t k = 0; k < 3; k++) {
            x[k] = r[3 * i + k] - R[k];
            u[k] = v[3 * i + k] - V[k];
        }
        pk_cross(x, u, l);
        for (size_t k = 0; k < 3; k++)
            L[k] += m[i] * l[k];
        *size += m[i] * norm(x) * norm(u);
    }
}

/* Angular momentum about the origin, or about the centre of mass. */
struct turning {
    struct pk_drift drift[3];
    /* `torque`: largest component of the torque so far; `arm`: size of its terms */
    pk_real first[3], last[3], torque, arm;
};

struct both {
    struct turning about[2]; /* the origin, the centre */
    int moves[3];            /* whether a particle moves along each axis */
};

static void turn(void *context, struct bodies *b, pk_real t)
{
    struct both *both = context;
    for (int centre = 0; centre < 2; centre++) {
        struct turning *x = &both->about[centre];
        pk_real size, torque[3];
        angular_momentum(b->n, b->m, b->r, b->v, centre, x->last, &size);
        if (!x->drift->samples)
            memcpy(x->first, x->last, sizeof x->first);
        for (int k = 0; k < 3; k++)
            pk_drift_update_scaled(&x->drift[k], t, x->last[k], size);
        angular_momentum(b->n, b->m, b->r, b->a, centre, torque, &size);
        for (int k = 0; k < 3; k++)
            x->torque = PK_F(fmax)(x->torque, PK_F(fabs)(torque[k]));
        x->arm = PK_F(fmax)(x->arm, size);
    }
    for (size_t i = 0; i < 3 * b->n; i++)
        both->moves[i % 3] |= PK_F(fabs)(b->r[i]) > 0 || PK_F(fabs)(b->v[i]) > 0;
}

static void write(struct json *j, const char *key, const struct turning *x, const int *moves)
{
    static const char *const axes[] = {"L_x", "L_y", "L_z"};
    /* the axis normal to a planar motion, or -1 if the motion is not planar */
    const int only = !moves[2] ? 2 : !moves[1] ? 1 : !moves[0] ? 0 : -1;
    json_open(j, key, '{');
    json_numbers(j, "first", x->first, 3);
    json_numbers(j, "final", x->last, 3);
    json_real(j, "torque", x->arm > 0 ? x->torque / x->arm : 0);
    json_open(j, "drifts", '[');
    for (int k = 0; k < 3; k++)
        if (only < 0 || k == only)
            report_drift(j, NULL, axes[k], &x->drift[k]);
    json_close(j, ']');
    json_close(j, '}');
}

void diagnose_angular_momentum(struct diagnostics *d)
{
    struct bodies b;
    struct both x = {0};
    if (!bodies_begin(&b, d, SIZE_MAX))
        return;
    b.see = turn;
    b.context = &x;
    turn(&x, &b, 0);
    const enum pk_status status = bodies_follow(&b);
    if (!diagnose_told(d, status, NULL, &b.motion.it))
        return;
    json_integer(&d->json, "particles", b.n);
    write(&d->json, "origin", &x.about[0], x.moves);
    if (b.n > 1)
        write(&d->json, "centre", &x.about[1], x.moves);
    else
        json_text(&d->json, "centre", NULL);
}
