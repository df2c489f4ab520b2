/* Reads what is asked and answers line by line; see stability.h. */
#include "stability.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "words.h"

void stability_energies(struct stability *s, double t, const double *q, const double *v,
                        double *energy, double *vp, double *size)
{
    const struct pk_system *system = s->problem.system;
    double *p = s->work + 2 * s->n, *pdot = p + s->n;
    system->canonical(s->problem.params, t, q, v, s->settings.u, p, pdot);
    *energy = system->energy(s->problem.params, t, q, v, s->settings.u);
    *vp = 0;
    for (size_t i = 0; i < s->n; i++)
        *vp += v[i] * p[i];
    *size = fabs(*vp) + fabs(*vp - *energy);
}

struct pk_integrator *stability_begin(const struct pk_problem *problem,
                                      const struct pk_method *method,
                                      const struct pk_options *options, const double *q,
                                      const double *v, enum pk_status *status)
{
    struct pk_integrator *it = (struct pk_integrator *)words_allocate(1, sizeof *it);
    const size_t size = pk_integrator_size(problem, method);
    void *block = words_allocate(size, 1);
    *status = pk_integrator_init(it, problem, method, options, 0, q, v, block, size);
    if (*status >= 0)
        return it;
    pk_integrator_free(it);
    free(block);
    free(it);
    return NULL;
}

void stability_end(struct pk_integrator *it)
{
    if (!it)
        return;
    pk_integrator_free(it);
    free(it->quadratures); /* what the block begins with */
    free(it);
}

static int answer(struct stability *s, size_t line, char *const words[])
{
    if (strcmp(words[0], "start") == 0)
        return stability_ready(s);
    if (strcmp(words[0], "motion") == 0)
        return stability_motion(s);
    if (strcmp(words[0], "point") == 0)
        return stability_point(s, line, words);
    if (strcmp(words[0], "oscillator") == 0)
        return stability_oscillator(line, words);
#ifdef PK_WITH_GSL
    if (strcmp(words[0], "equilibria") == 0)
        return stability_equilibria(s, line, words);
    if (strcmp(words[0], "near") == 0)
        return stability_near(s, line, words);
    if (strcmp(words[0], "leave") == 0)
        return stability_leave(s, line, words);
#endif
    return words_usage(line, "cannot be asked", words[0]);
}

int stability_run(const char *path)
{
    static struct stability s;
    char text[512];
    FILE *file = fopen(path, "r");
    if (!file) {
        fprintf(stderr, "run: cannot read %s: %s\n", path, strerror(errno));
        return EXIT_USAGE;
    }
    int code = settings_read(&s.settings, run_model, stdin);
    if (code == 0) {
        const size_t n = s.n = s.settings.n;
        s.problem = settings_motion(&s.settings);
        s.work = (double *)words_allocate(4 * n + 1, sizeof *s.work);
        s.far = (double *)words_allocate(3 * n, sizeof *s.far);
#ifdef PK_WITH_GSL
        s.modes = (struct pk_mode *)words_allocate(2 * n, sizeof *s.modes);
#endif
        s.shapes = (double *)words_allocate(4 * n * n, sizeof *s.shapes);
    }
    for (size_t line = 1; code == 0 && fgets(text, sizeof text, file); line++) {
        char *words[11] = {NULL};
        size_t count = 0;
        for (char *w = strtok(text, " \r\n"); w && count < 10; w = strtok(NULL, " \r\n"))
            words[count++] = w;
        if (count)
            code = answer(&s, line, words);
    }
    fclose(file);
    if (fflush(stdout) || ferror(stdout))
        code = code ? code : EXIT_USAGE;
    stability_end(s.exact);
    settings_free(&s.settings);
    free(s.work);
    free(s.far);
    free(s.records);
    free(s.modes);
    free(s.shapes);
    return code;
}
