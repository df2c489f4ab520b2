/* An observer that computes condition numbers along a run (pk/condition.h). It examines about 64
 * states, evenly spread in time. It also examines states where a rate changes twice as fast as at
 * any earlier step: near such states the mass matrix M may be nearly singular for a short time.
 * After 1024 steps it only considers one step in 8, for a cost below 5 % of explicit runs. */
#include "condition.h"

/* accelerations that amplify rounding by more than this factor give a warning */
#define LOST PK_C(1e5)
/* No warning below this condition number: digits are then lost only since forces cancel. */
#define NEAR PK_C(1e3)
#define FASTER 2 /* A state is examined if a |dv_i/dt| exceeds all earlier ones by this factor. */
enum {
    LOOKS = 64, /* states examined at equal intervals of the run */
    /* Least number of steps between two states; with n unknowns, 1 + n / FEW times as many. */
    STEPS = 64,
    FEW = 16,
    MOST_RECORDS = 256, /* limit of additional states, where a rate changes faster than before */
    ALL = 1024,         /* after ALL steps, only one step in PART is considered */
    PART = 8
};

struct looking { /* the arrays v and turned, and block, follow this struct in memory */
    struct pk_condition found;
    const struct pk_problem *problem;
    void *block;
    size_t n;
    /* time at which a state is examined next; time and rates at the last step considered */
    pk_real next, t, *v;
    pk_real *turned; /* for each rate: FASTER times the largest |dv_i/dt| so far */
    unsigned long seen, steps, records;
};

struct looking *condition_begin(struct memory *memory, const struct pk_problem *problem,
                                const struct pk_method *method)
{
    const size_t size = pk_condition_size(problem, method), n = pk_count_of(problem);
    if (!size)
        return NULL;
    struct looking *l = memory_take(memory, 1, sizeof *l + 2 * n * sizeof *l->v + size);
    l->problem = problem;
    l->n = n;
    l->v = (pk_real *)(l + 1);
    l->turned = l->v + n;
    l->block = l->turned + n;
    l->t = PK_INFINITY;
    return l;
}

static int record(struct looking *l, const struct moment *at)
{
    const pk_real h = at->t - l->t;
    int found = 0;
    for (size_t i = 0; i < l->n; i++) {
        const pk_real turned = PK_F(fabs)(at->v[i] - l->v[i]);
        l->v[i] = at->v[i];
        if (turned > l->turned[i] * h && h > 0) {
            l->turned[i] = FASTER * turned / h;
            found = 1;
        }
    }
    l->t = at->t;
    return found && l->records++ < MOST_RECORDS;
}

void condition_step(struct looking *l, struct pk_integrator *it, pk_real until,
                    const struct moment *at)
{
    if (!l || (++l->seen > ALL && l->seen % PART))
        return;
    l->steps++;
    if (!record(l, at) && l->found.looks &&
        (at->t < l->next || l->steps < STEPS * (1 + l->n / FEW)))
        return;
    pk_condition_look(&l->found, l->problem, l->found.looks ? it : NULL, at->t, at->q, at->v,
                      l->block);
    l->next = at->t + until / LOOKS;
    l->steps = 0;
}

static void report_most(struct json *j, const char *key, const struct pk_condition_most *most)
{
    if (most->x > 0)
        json_object(j, key, {"cond", most->x}, {"t", most->t});
}

static void where(const struct looking *l, char *text, size_t size)
{
    const struct pk_problem *of = l->problem;
    pk_system_name(of->system, of->params, of->system->rates, l->found.where, text, size);
}

static pk_real digits(pk_real magnified)
{
    return PK_F(log10)(PK_F(fmax)(1, PK_F(fmin)(magnified, 1 / PK_EPSILON)));
}

pk_real condition_of_step(struct memory *memory, const struct pk_problem *problem,
                          struct pk_integrator *it)
{
    struct pk_condition found = {0};
    const size_t size = it->method->equations ? pk_condition_size(problem, it->method) : 0;
    if (!size)
        return 0;
    void *block = memory_take(memory, size, 1);
    pk_condition_look(&found, problem, it, it->t, it->q, it->v, block);
    memory_drop(memory, block);
    return found.step.x;
}

void condition_report(const struct looking *l, struct json *j)
{
    char name[128];
    if (!l || !l->found.looks)
        return;
    where(l, name, sizeof name);
    json_open(j, "condition", '{');
    report_most(j, "mass", &l->found.mass);
    report_most(j, "constraints", &l->found.constraints);
    report_most(j, "step", &l->found.step);
    json_open(j, "lost", '{');
    json_reals(j, {"digits", digits(l->found.lost.x)}, {"t", l->found.lost.t});
    json_text(j, "rate", name);
    json_close(j, '}');
    json_integer(j, "looks", l->found.looks);
    json_close(j, '}');
}

int condition_warning(const struct looking *l, char *text, size_t size)
{
    if (!l || !(l->found.lost.x > LOST))
        return 0;
    const struct pk_condition *c = &l->found;
    const int rows = c->constraints.x > c->mass.x;
    if (!((rows ? c->constraints.x : c->mass.x) > NEAR))
        return 0;
    const pk_real lost = digits(c->lost.x), all = digits(PK_INFINITY);
    char name[128];
    where(l, name, sizeof name);
    snprintf(text, size,
             "%s' loses %.0f of %.0f digits at t = %.6g, where %s is nearly singular (condition "
             "number %.2g): at any tolerance, some %.0f digits at most of the motion after that "
             "are right: %s",
             name, (double)lost, (double)all, (double)c->lost.t, rows ? "J M^-1 J^T" : "M",
             (double)(rows ? c->constraints.x : c->mass.x), (double)(all - lost),
             rows ? "leave out a constraint that all but follows from the others"
                  : "leave a mass or length that is all but zero out of the model, with its "
                    "coordinate");
    return 1;
}

static void step(struct pk_run *run, const struct moment *at)
{
    const struct settings *s = &run->settings;
    if (s->asked.bare || s->asked.compared || s->asked.members)
        return;
    if (!run->looking && !(at->t > 0))
        run->looking = condition_begin(&run->memory, &run->problem, s->method);
    condition_step(run->looking, s->n_parts ? NULL : &run->it, s->until, at);
}

static void report(const struct pk_run *run, struct json *j) { condition_report(run->looking, j); }

static void keep(struct pk_run *run, struct pk_keep *k)
{
    const struct settings *s = &run->settings;
    int begun = run->looking != NULL;
    PK_KEEP(k, begun);
    if (begun && !run->looking)
        run->looking = condition_begin(&run->memory, &run->problem, s->method);
    struct looking *l = run->looking;
    k->wrong |= begun && !l;
    if (!begun || !l)
        return;
    PK_KEEP(k, l->found);
    PK_KEEP(k, l->next);
    PK_KEEP(k, l->t);
    PK_KEEP(k, l->seen);
    PK_KEEP(k, l->steps);
    PK_KEEP(k, l->records);
    pk_keep(k, l->v, 2 * l->n * sizeof *l->v);
    k->wrong |= l->found.where >= l->n;
}

const struct observer condition_observer = {.step = step, .report = report, .keep = keep};
