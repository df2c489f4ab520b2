/* A motion to diagnose, and what is measured of it. The functions take memory of the run. */
#ifndef RUN_DIAGNOSE_MOTION_H
#define RUN_DIAGNOSE_MOTION_H

#include "../base/state.h"

/* A problem, its state at the time t, and the method that integrates it up to the time `end`. */
struct motion {
    const struct pk_problem *problem;
    const struct pk_method *method;
    struct pk_options options;
    pk_real t, end;
    const pk_real *q, *v;
    int sided; /* whether the sides of all switches are set in the params */
    struct memory *memory;
    struct pk_integrator it; /* must be freed */
    void *block;             /* memory of `it` */
};

/* Starts m->it at the state of the motion. May be called again. */
enum pk_status motion_begin(struct motion *m);
/* Updates the largest |x - x(0)| of each coordinate and rate, 2 n numbers. The displacements, which
 * may follow the n coordinates and first-order variables in the state of `it`, are skipped. */
void motion_note(pk_real *most, const struct settings *s, const struct pk_integrator *it);

/* A motion together with small displacements of it: a system made from another system, with 1 +
 * columns times as many coordinates,
 *
 *     Q = (q, dq_1, dq_2, ...),   V = (v, dv_1, dv_2, ...)
 *
 * In V all rates of coordinates come before all first-order variables. The equations are those of q
 * and their linearisation along the motion, the variational equations
 *
 *     M a = f(q, v, t),   M da = (dr/dq) dq + (dr/dv) dv,   r = f - M a at constant a,
 *
 * by the kernel `linear` that pkgen generates. Any method of the runtime can integrate the new
 * system. A Runge-Kutta method, a composition of flows or a Gauss method in (q, p), applied to this
 * system, propagates the displacements by the derivative of its own step map, not only of the flow,
 * to round-off. Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd
 * ed., VI.4, lemma 4.1.
 *
 * The new system has kernels acceleration, mass, canonical, jacobian and linear. The kernels mass,
 * jacobian and linear omit the derivatives of the variational equations by q and v, which need
 * second derivatives: Newton's method takes a few more iterations, and may not converge at step
 * sizes at which it barely converges for the motion alone (for the double pendulum gauss8 fails at
 * step sizes from .4 on instead of from .6; radau shortens its steps instead). */
struct variation {
    struct motion motion; /* of the new system; points to this struct, which must not move */
    pk_real *Q, *V; /* the start of that motion: q and v, then the displacements, 0 at first */
    struct pk_problem of, problem; /* of the motion alone; of the new system */
    struct pk_system system;
    size_t n_q, n, columns;
    /* work memory of n numbers each: v, the acceleration a, a right-hand side b; inputs */
    pk_real *work, *v, *a, *b, *u;
    /* Displacements of the inputs and then the parameters, for each column; NULL: none. `drive` has
     * the derivatives of r by inputs and parameters. */
    const pk_real *du;
    const struct pk_jacobian *r_u, *r_p, *canonical;
    pk_real *drive;
};

/* Returns PK_REFUSED without a kernel `linear`, mass or jacobian, or PK_SMOOTH. */
enum pk_status variation_init(struct variation *w, const struct motion *m, size_t columns);
/* Lets the columns also change parameters and inputs; call it after variation_init(). The system
 * needs the kernels r_p and, with inputs, r_u; without canonical_d methods in (q, p) are refused. */
enum pk_status variation_drive(struct variation *w, const pk_real *du);
/* variation_place() returns the index in V of number i of v (if k = 0) or of dv_k. variation_take()
 * copies the n numbers of v or dv_k from V, variation_put() copies them to V. */
size_t variation_place(const struct variation *w, size_t k, size_t i);
void variation_take(const struct variation *w, const pk_real *V, size_t k, pk_real *v);
void variation_put(const struct variation *w, const pk_real *v, size_t k, pk_real *V);
/* Returns the inputs at t. */
const pk_real *variation_inputs(const struct variation *w, pk_real t);

/* Small displacements without units. With M = C C^T at one state and a time tau of the motion
 *
 *     Q = C^T dq / sqrt(tau),   P = C^-1 dp sqrt(tau)
 *
 * are canonical and all have the same unit, whatever the units of the coordinates. tau is 1/omega;
 * omega^2 is the Frobenius norm of C^-1 (dr/dq) C^-T, where M q'' = r are the equations of motion.
 * The length of a displacement is the root of |C^T dq/tau|^2 + |C^T dv|^2: velocity times root of
 * mass. */
struct metric {
    size_t n, seen; /* n: number of components of dv; seen: of dq */
    pk_real tau;
    pk_real *L; /* L and D of M = L D L^T in one n by n array */
};

/* Initialises the metric at a state. If dr/dq is 0, tau is set to `otherwise`. */
enum pk_status metric_init(struct metric *metric, const struct variation *w, pk_real t,
                           const pk_real *q, const pk_real *v, pk_real otherwise);
/* These functions convert in place: Q to dq, P to dp, dq to Q, dp to P. */
void metric_dq(const struct metric *metric, pk_real *x);
void metric_dp(const struct metric *metric, pk_real *x);
void metric_Q(const struct metric *metric, pk_real *x);
void metric_P(const struct metric *metric, pk_real *x);
pk_real metric_length(const struct metric *metric, const pk_real *dq, const pk_real *dv);

/* The largest Lyapunov exponent, from a displacement that the variational equations propagate along
 * the motion, normalised at the ends of blocks of time. With G(t) the logarithm of the growth of
 * the displacement since the start, and T the time reached:
 *
 *     exponent = (G(T) - G(T/10)) / (T - T/10)
 *     megno    = time average of 2 (G(t) - time average of G over [0, t])
 *
 * The first tenth of the time, in which the displacement turns towards the direction of fastest
 * growth, is left out. `error` is the standard error of the exponent by the method of batch means.
 * The batches are the growth rates in 14 to 58 equal intervals of the remaining time. On a regular
 * motion a displacement grows like t, G like ln t, so the exponent is about 2.6/T and keeps
 * falling. megno tends to 2 on a regular motion (0 on a harmonic one) and grows as exponent T/2 on
 * a chaotic one. References: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15
 * (1980) 9; P. M. Cincotta, C. Simo, Astron. Astrophys. Suppl. 147 (2000) 205 (megno). */
enum { LYAPUNOV_BLOCKS = 1000 };

/* The kind of a motion: REGULAR if its megno is at most 3, CHAOTIC if it is at least 6. CHAOTIC
 * means exponential growth. It is chaos only if the motion is bounded; the motion away from an
 * unstable equilibrium has exponential growth too. */
enum chaos { REGULAR, CHAOTIC, UNDECIDED };

struct lyapunov {
    struct variation variation;
    struct metric metric;
    pk_real block; /* time of a block */
    size_t blocks; /* number of completed blocks */
    pk_real *G;    /* at the end of each block */
    pk_real grown; /* G now */
};

/* Before about 20 blocks the exponent is 0 and its error infinite. */
struct growth {
    pk_real exponent, error, megno;
    enum chaos kind;
};

/* block: a thousandth of the planned time, rounded to whole steps if they are fixed. */
enum pk_status lyapunov_begin(struct lyapunov *l, const struct motion *m, pk_real block);
/* Integrates over one block, at most LYAPUNOV_BLOCKS times. Returns the integrator's status. */
enum pk_status lyapunov_step(struct lyapunov *l);
struct growth lyapunov_growth(const struct lyapunov *l);
/* The same for the motion of a run that events change at once, from a neighbour of it. Writes the
 * reason of a failure to *why, and the excursions of both halves of the motion to `most`. */
enum pk_status lyapunov_beside(struct lyapunov *l, struct pk_run *run, struct memory *memory,
                               pk_real *most, const char **why);

/* Time reversal: steps from the start to a time and the same number backward. A symmetric method
 * returns to the start except for round-off. A chaotic motion amplifies round-off like any
 * displacement, to about 1 at t = ln(1/PK_EPSILON)/lambda, where lambda is the Lyapunov exponent.
 * Methods that are not symmetric miss the start by their own errors. */
enum { REVERSAL_TIMES = 24 };

struct reversal {
    /* number of entries of at[]: first the times end/2^k ascending, then those of the bisection */
    size_t count;
    /* t: time from the start, > 0; error: the largest over coordinates and rates of |x - x0| / max
     * |x - x0|, the maximum taken over the whole motion */
    struct {
        pk_real t, error;
    } at[REVERSAL_TIMES];
    int passed; /* whether the error exceeds the threshold at a time tried */
    /* latest time tried with an error below the threshold, earliest with one above */
    pk_real horizon_lo, horizon_hi;
};

/* Tries the times end/2^k, from at least one step to `end`, stops at the first time whose error
 * exceeds the threshold, and brackets this horizon to a sixteenth of it. With a fixed step size,
 * times are whole numbers of steps. The integrations take about 5 times the motion's time. */
enum pk_status reversal_find(struct reversal *r, struct motion *m, pk_real threshold);

/* The effect of one step on small displacements and on the symplectic form. For the step map (Q, P)
 * -> (Q1, P1) with S = d(Q1, P1)/d(Q, P) in the variables of struct metric,
 *
 *     defect = max |S^T J S - J|,   volume = det S - 1.
 *
 * They are zero for a symplectic method on a variational system; otherwise they show the error of a
 * step, or that forces dissipate energy. S is exact: it comes from the variational equations under
 * the same method. `rounding` bounds the error of both defect and volume. */
struct stepmap {
    struct variation variation;
    struct metric metric;
    pk_real *S, *LU, *J, *dp, *pivot;
    pk_real defect, volume, rounding;
};

enum pk_status stepmap_begin(struct stepmap *w, const struct motion *m);
/* Makes one step of size h > 0, forward from a state. An adaptive method makes a step of that size
 * with its equations solved to round-off and its error ignored. Returns PK_REFUSED if the method
 * cannot do this or if its steps depend on the motion (adaptive_verlet). */
enum pk_status stepmap_find(struct stepmap *w, pk_real h, pk_real t, const pk_real *q,
                            const pk_real *v);

/* Hamilton's principle: among all paths with the same end points and times, the motion makes the
 * action S = integral of L dt stationary. S is a minimum if the motion has no point conjugate to
 * its start, where neighbouring motions from the start meet again. The neighbouring paths are, with
 * k = 1 .. modes,
 *
 *     q(t) + sum a_ik e_i sin(k pi (t - t0)/time),   S(a) = S + slope.a + a.C a/2 + ...
 *
 * slope is zero for a motion. B is the contribution of v.M v to C. The eigenvalues of C a = lambda
 * B a tend to 1 with increasing k; the number of negative ones is the number of conjugate points
 * within the path, counted with multiplicity (Morse's index theorem). For an oscillator lambda_k =
 * 1 - (omega time/(k pi))^2. Conjugate points are where det dq(t)/dv(t0) changes its sign, by the
 * variational equations. References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, chapter 5;
 * J. Milnor, Morse Theory, paragraph 15; C. G. Gray, E. F. Taylor, Am. J. Phys. 75 (2007) 434. */
enum { CONJUGATE_MOST = 64 };

/* Values of the kernels and of the modes, which are sines of t, at one node of the quadrature. */
struct node {
    pk_real *p, *g, *q, *v, *M, *p_q, *g_q, *g_v; /* g: dL/dq at the node */
    pk_real *sine, *rate;                         /* value and time derivative of each mode */
};

struct least_action {
    struct variation variation;
    pk_real action, size; /* S; the integral of |p.v| + |h|, the scale of round-off of S */
    /* max |dS/da_ik|, each divided by the sum of its terms' absolute values; near 0 for a motion */
    pk_real slope;
    size_t n, modes;    /* number of coordinates, number of modes */
    pk_real *C, *B;     /* n modes by n modes */
    size_t n_conjugate; /* number of conjugate points; the first are in conjugate[] */
    pk_real conjugate[CONJUGATE_MOST];
    size_t nodes;
    pk_real t0, time;
    pk_real *path; /* q and v of the motion at each node of the quadrature */
    pk_real *slopes, *J, *pivot;
    struct node node;
};

/* Integrates the action in `panels` intervals of 8 Gauss nodes each. An interval should be no
 * longer than half a wavelength of the shortest mode, k = modes. */
enum pk_status least_action_find(struct least_action *found, const struct motion *m, size_t panels,
                                 size_t modes);
/* Returns the action S(a) of the neighbouring path with the coefficients a, n by modes: the
 * integral itself, not its expansion to second order in a. */
pk_real least_action_at(const struct least_action *found, const pk_real *a);
/* Computes the eigenvalues lambda of C a = lambda B a in ascending order, from the first `modes`
 * modes of each coordinate, and the eigenvector of the least one, with a.B a = 1. Returns the
 * number of negative eigenvalues, or 0 if *status is a failure. Not defined without GSL. */
size_t least_action_eigenvalues(const struct least_action *found, size_t modes, double *lambda,
                                double *lowest, enum pk_status *status);

/* Action and period of a motion of one degree of freedom, at the energy of a given state and with t
 * held fixed:
 *
 *     J = (1/2 pi) closed integral of p dq,     T = closed integral of dq/v = 2 pi dJ/dh,
 *
 * for L = M(q) v^2/2 + b(q) v - W(q), where p = M v + b and h is the energy. The motion oscillates
 * between two positions with v = 0 (libration), or q grows by 2 pi in each period if the equations
 * have the period 2 pi in q (rotation). For a libration, with q = middle + amplitude sin s, the
 * integrands are smooth and periodic in s; for a rotation they are smooth and periodic in q. Sums
 * over equidistant nodes then converge geometrically: the number of nodes is doubled until the
 * result converges. The kinetic energy at q, h - W, is computed by integrating from the ends of the
 * libration, where it is 0, so that no digits are lost for small librations.
 *
 * If L depends on time slowly, J is an adiabatic invariant of the motion.
 *
 * References: L. Landau, E. Lifshitz, Mechanics, 49 and 50; L. N. Trefethen, J. A. C. Weideman, The
 * exponentially convergent trapezoidal rule, SIAM Rev. 56 (2014) 385. */
#define ORBITS(X)                                                                \
    X(LIBRATION, "to and fro")                                                   \
    X(ROTATION, "round and round")                                               \
    X(EQUILIBRIUM, "at rest in an equilibrium: it has no orbit")                 \
    X(SEPARATRIX, "on a separatrix, as far as rounding tells: it never returns") \
    X(UNBOUNDED, "not periodic: it goes to infinity or into a singularity")      \
    X(UNSETTLED, "not smooth enough for the sums to settle")                     \
    X(SEVERAL, "not of one degree of freedom")                                   \
    X(NOT_QUADRATIC, "of an L that is not of second degree in the rate")         \
    X(NO_KERNELS, "compiled without its kernels gradient, mass and canonical")

enum orbit { ORBITS(PK_EACH_NAME) ORBIT_COUNT };

struct action {
    enum orbit orbit;
    pk_real action, period;
    pk_real lo, hi; /* the two positions between which a libration oscillates */
    /* estimated relative error of action and period: their change when the number of nodes was
     * doubled last; near a separatrix it includes the effect of rounding of the energy */
    pk_real error;
    size_t nodes;
};

/* Computes action and period of the motion through (q, v) at t. u: inputs, or NULL. PK_REFUSED: the
 * action of this motion is not defined or cannot be computed; found->orbit is the reason. */
enum pk_status action_find(struct action *found, const struct pk_problem *problem, pk_real t,
                           const pk_real *q, const pk_real *v, const pk_real *u);
const char *orbit_text(enum orbit orbit);

#endif
