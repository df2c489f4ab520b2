/* The largest Lyapunov exponent of a model, in a program of one's own; see docs/diagnostics.md. */
#include <stdio.h>

#include <pk/methods.h>
#include <pk/run.h>

#include "double_pendulum.h"

int main(void)
{
    static const struct pk_method *const methods[] = {&pk_method_dop853};
    static const struct pk_run_value q[] = {{0, 0, 2}, {1, 0, 2}}, v[] = {{0, 0, 0}, {1, 0, 0}};
    const struct pk_run_model model = {.system = &double_pendulum_system,
                                       .methods = methods,
                                       .n_methods = 1,
                                       .diagnose = &pk_run_diagnose};
    struct pk_run_settings s = pk_run_defaults();
    s.method = "dop853";
    s.until = s.every = 500;
    s.q = q, s.n_q = 2;
    s.v = v, s.n_v = 2;
    s.diagnose = pk_run_diagnostic("lyapunov"); /* several: the bits of each, with | */
    struct pk_run *run = pk_run_new(&model, &s);
    int code = pk_run_go(run);
    puts(pk_run_report(run)); /* in JSON: "diagnostics": {"lyapunov": ... */
    fputs(pk_run_messages(run), stderr);
    pk_run_free(run);
    return code;
}
