// The generated program of mechanicsdsl-core, whole, driven by its own rk4_step(); its main(),
// which writes a file at a step of 0.001, is put aside. Its state is q1, q1', q2, q2', ...
#define main generated_main
#include BENCH_EQUATIONS
#undef main

#include "harness.h"

const size_t bench_length = DIM;

const char *bench_open(int, char **) { return nullptr; }
const char *bench_prepare(double, const double *, double) { return nullptr; }

const char *bench_integrate(double setting, double *y, double t_end)
{
    const unsigned long steps = (unsigned long)(t_end / setting + 0.5);
    std::vector<double> state(DIM);

    for (int i = 0; i < DIM / 2; i++) state[2 * i] = y[i], state[2 * i + 1] = y[DIM / 2 + i];
    for (unsigned long k = 0; k < steps; k++)
        rk4_step(state, t_end * (double)k / (double)steps, t_end / (double)steps);
    for (int i = 0; i < DIM / 2; i++) y[i] = state[2 * i], y[DIM / 2 + i] = state[2 * i + 1];
    return nullptr;
}
