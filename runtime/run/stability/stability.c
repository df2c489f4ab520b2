/* Questions and their answers; see pk/stability.h. */
#include "stability.h"

#include "../settings/settings.h"

/* Sets s->idle, and by_norm if a first-order variable matters that is not part of a rotation. */
static void find_idle(struct pk_stability *s)
{
    const struct pk_system *system = s->problem.system;
#ifdef PK_WITH_GSL
    if (s->n > s->coordinates + 7 * system->n_rotations)
        pk_gsl_unread(&s->problem, s->settings->q, s->settings->v, s->idle);
#endif
    for (size_t i = 0; i < s->n; i++) {
        if (i < s->coordinates)
            s->idle[i] = system->cyclic && system->cyclic[i];
        else if (i >= s->coordinates + 7 * system->n_rotations && !s->idle[i])
            s->by_norm = 1;
    }
}

/* pk_options.stop of all integrations. */
static int ending(void *context)
{
    const struct pk_stability *s = context;
    return run_ending(NULL) || run_processor() > s->until;
}

/* Allocates the memory for all questions. */
static void prepare(void *context)
{
    struct pk_stability *s = context;
    struct memory *memory = &s->run->memory;
    const size_t n = s->run->settings.n;
    s->n = n;
    s->until = HUGE_VAL;
    s->run->settings.asked.bare = 1;
    s->run->settings.options.stop = ending;
    s->run->settings.options.context = s;
    s->problem = run_problem(s->run);
    s->coordinates = pk_system_coordinates(s->problem.system, s->problem.params);
    s->work = memory_take(memory, 4 * n + 1, sizeof *s->work);
    s->far = memory_take(memory, 3 * n, sizeof *s->far);
#ifdef PK_WITH_GSL
    s->modes = memory_take(memory, 2 * n, sizeof *s->modes);
#endif
    s->shapes = memory_take(memory, 4 * n * n, sizeof *s->shapes);
    s->idle = memory_take(memory, n, 1);
    find_idle(s);
}

struct pk_stability *pk_stability_new(const struct pk_run_model *model,
                                      const struct pk_run_settings *settings)
{
    struct pk_stability *s = calloc(1, sizeof *s);
    struct pk_run *run = pk_run_new(model, settings);
    if (s && run) {
        s->run = run;
        s->settings = &run->settings;
        if (run->code || memory_try(&run->memory, prepare, s))
            return s;
    }
    free(s);
    pk_run_free(run);
    return NULL;
}

static const struct {
    const char *what;
    stability_answer *answer;
} answers[] = {{"start", stability_ready},           {"motion", stability_motion},
#ifdef PK_WITH_GSL
               {"equilibria", stability_equilibria}, {"near", stability_near},
               {"leave", stability_leave},           {"rates", stability_fastest},
               {"orbits", stability_orbits},         {"beside", stability_neighbour},
               {"returns", stability_returns},
#endif
               {"place", stability_place},           {"resolved", stability_resolved},
               {"point", stability_point},           {"oscillator", stability_oscillator}};

static void answer(void *context)
{
    struct pk_stability *s = context;
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++) {
        if (strcmp(answers[i].what, s->what) != 0)
            continue;
        s->out = (struct json){.file = run_text(s->run, &s->answer)};
        json_open(&s->out, NULL, '{');
        s->good = answers[i].answer(s, s->question);
        json_close(&s->out, '}');
        return;
    }
    run_say(s->run, "cannot be asked: %s", s->what);
}

const char *pk_stability_ask(struct pk_stability *s, const char *what,
                             const struct pk_stability_question *question)
{
    free(s->answer);
    s->answer = NULL;
    s->what = what;
    s->question = question;
    s->until = question->cap > 0 ? run_processor() + question->cap : HUGE_VAL;
    s->good = 0;
    const int room = !s->run->code && memory_try(&s->run->memory, answer, s);
    run_text_end(s->run);
    return room && s->good ? s->answer : NULL;
}

const char *pk_stability_wrong(const struct pk_stability *s)
{
    return s->run->said ? s->run->said : "out of memory\n";
}

void pk_stability_free(struct pk_stability *s)
{
    if (!s)
        return;
    if (s->exact)
        pk_integrator_free(s->exact);
    pk_run_free(s->run);
    free(s->answer);
    free(s);
}
