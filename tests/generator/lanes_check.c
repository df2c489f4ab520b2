/* Lane kernels against the scalar kernel of one model, bit for bit (with -ffp-contract=off), also
 * where a lane is singular, not a number, or beyond the range of the inline sine.
 *
 *     cc -DMODEL=double_pendulum -DSOURCE='"double_pendulum.c"' lanes_check.c -lm
 *
 * Prints how many lanes were compared, how many of them failed, and how many differ.
 */
#include <stdio.h>
#include <string.h>

#include SOURCE

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define OF(x) JOIN(MODEL, x)

enum {
    N = OF(_N),
    INPUTS = OF(_INPUTS),
    SIZE = sizeof(struct OF(_params)) / sizeof(pk_real),
    MOST = 12, /* lanes: also a number that fills no vector */
    ROUNDS = 400
};

static unsigned long seed = 2385;

static pk_real uniform(void) /* in [-1, 1): the minimal standard generator */
{
    seed = seed * 48271ul % 2147483647ul;
    return (pk_real)seed / (pk_real)1073741824.0 - 1;
}

struct lanes {
    struct OF(_params) p[MOST];
    pk_real P[SIZE * MOST], t[MOST], q[N * MOST], v[N * MOST], u[(INPUTS + 1) * MOST], a[N * MOST];
};

/* States around the start; in every other round one of them is unusual. */
static void fill(struct lanes *s, size_t W, int round)
{
    const size_t odd = (size_t)round % W;
    size_t i, k, l;

    for (l = 0; l < W; l++) {
        pk_real q[N], v[N];
        OF(_defaults)(&s->p[l]);
        for (k = 0; k < OF(_PARAMETERS); k++)
            ((pk_real *)&s->p[l])[k] *= 1 + uniform() / 64;
        (void)OF(_prepare)(&s->p[l]);
        OF(_start)(&s->p[l], q, v);
        for (i = 0; i < N; i++) {
            s->q[i * W + l] = q[i] + uniform();
            s->v[i * W + l] = v[i] + 3 * uniform();
        }
        for (i = 1; i <= INPUTS; i++)
            s->u[(i - 1) * W + l] = uniform();
        s->t[l] = uniform();
    }
    for (i = 0; i < N; i++) {
        pk_real *x = &s->q[i * W + odd];
        switch (round % 10) {
        case 1: *x = 0; break;
        case 3: *x *= PK_C(1e8); break;
        case 5: *x -= *x / (*x - *x); break;
        case 7: *x = PK_INFINITY; break;
        case 9: s->v[i * W + odd] *= PK_C(1e30); break;
        }
    }
    for (l = 0; l < W; l++)
        for (k = 0; k < SIZE; k++)
            s->P[k * W + l] = ((const pk_real *)&s->p[l])[k];
}

static int lanes, failures, differ;

/* To the bit, the sign of a zero too; any NaN is as good as another. */
static int same(pk_real a, pk_real b)
{
    return a == b ? !signbit(a) == !signbit(b) : a != a && b != b;
}

/* What one lane should have given, and whether it did. */
static void compare(const struct lanes *s, const struct OF(_params) *p, size_t W, size_t l,
                    unsigned long long failed)
{
    pk_real q[N], v[N], u[INPUTS + 1], a[N], found[N];
    size_t i;
    int status;

    for (i = 0; i < N; i++) {
        q[i] = s->q[i * W + l];
        v[i] = s->v[i * W + l];
        found[i] = s->a[i * W + l];
        a[i] = 0;
    }
    for (i = 1; i <= INPUTS; i++)
        u[i - 1] = s->u[(i - 1) * W + l];
    status = OF(_acceleration)(p, s->t[l], q, v, u, a);
    lanes++;
    failures += status != 0;
    if ((status != 0) != (int)(failed >> l & 1))
        differ++;
    for (i = 0; i < N && status == 0; i++)
        differ += !same(a[i], found[i]);
}

static void compare_all(struct lanes *s, size_t W, int members)
{
    unsigned long long failed;
    size_t l;

    memset(s->a, 0, sizeof s->a);
    if (W == PK_LANES)
        failed = members ? OF(_members)(s->P, s->t, s->q, s->v, s->u, s->a)
                         : OF(_lanes)(&s->p[0], s->t, s->q, s->v, s->u, s->a);
    else
        failed = members ? OF(_members_inline)(W, s->P, s->t, s->q, s->v, s->u, s->a)
                         : OF(_lanes_inline)(W, &s->p[0], s->t, s->q, s->v, s->u, s->a);
    for (l = 0; l < W; l++)
        compare(s, members ? &s->p[l] : &s->p[0], W, l, failed);
}

int main(void)
{
    static const size_t widths[] = {PK_LANES, 1, 3, MOST};
    static struct lanes s;
    int round, w;

    for (round = 0; round < ROUNDS; round++)
        for (w = 0; w < 4; w++) {
            fill(&s, widths[w], round);
            compare_all(&s, widths[w], 0);
            compare_all(&s, widths[w], 1);
        }
    printf("%d lanes, %d failed, %d differ\n", lanes, failures, differ);
    return differ != 0;
}
