/* CVODE, as its examples use it for problems that are not stiff (Adams, fixed-point iteration) and
 * stiff (BDF, Newton, dense difference-quotient Jacobian). The wheel that brings the library has no
 * headers, so what is used of its interface (SUNDIALS 7: doc/cvode) is declared here; its indices
 * are int, as the wheel's c_config.pxi says. argv: adams or bdf.
 */
#include <string.h>

#include "harness.h"
#include BENCH_EQUATIONS

typedef int sunindextype;
typedef struct SUNContext_ *SUNContext;
typedef struct _generic_N_Vector *N_Vector;
typedef struct _generic_SUNMatrix *SUNMatrix;
typedef struct _generic_SUNLinearSolver *SUNLinearSolver;
typedef struct _generic_SUNNonlinearSolver *SUNNonlinearSolver;
typedef int (*CVRhsFn)(double t, N_Vector y, N_Vector dy, void *data);

enum { CV_ADAMS = 1, CV_BDF = 2, CV_NORMAL = 1, CV_TSTOP_RETURN = 1 };

int SUNContext_Create(int comm, SUNContext *context);
int SUNContext_ClearErrHandlers(SUNContext context);
N_Vector N_VMake_Serial(sunindextype length, double *data, SUNContext context);
double *N_VGetArrayPointer_Serial(N_Vector v);
SUNMatrix SUNDenseMatrix(sunindextype rows, sunindextype columns, SUNContext context);
SUNLinearSolver SUNLinSol_Dense(N_Vector y, SUNMatrix A, SUNContext context);
SUNNonlinearSolver SUNNonlinSol_FixedPoint(N_Vector y, int m, SUNContext context);
void *CVodeCreate(int method, SUNContext context);
int CVodeInit(void *memory, CVRhsFn f, double t0, N_Vector y0);
int CVodeReInit(void *memory, double t0, N_Vector y0);
int CVodeSStolerances(void *memory, double rtol, double atol);
int CVodeSetMaxNumSteps(void *memory, long steps);
int CVodeSetStopTime(void *memory, double t);
int CVodeSetLinearSolver(void *memory, SUNLinearSolver solver, SUNMatrix A);
int CVodeSetNonlinearSolver(void *memory, SUNNonlinearSolver solver);
int CVode(void *memory, double t_end, N_Vector y, double *t, int task);

const size_t bench_length = 2 * N;
static void *memory;
static double state[2 * N];
static N_Vector vector;

static int right_hand_side(double t, N_Vector y_, N_Vector dy_, void *nothing)
{
    const double *y = N_VGetArrayPointer_Serial(y_);
    double *dy = N_VGetArrayPointer_Serial(dy_);

    (void)nothing;
    memcpy(dy, y + N, N * sizeof *y);
    return acceleration(t, y, y + N, dy + N);
}

const char *bench_open(int argc, char **argv)
{
    const int adams = argc > 1 && !strcmp(argv[1], "adams");
    SUNContext context;

    if (SUNContext_Create(0, &context)) return "CVODE: no context";
    SUNContext_ClearErrHandlers(context);
    vector = N_VMake_Serial(2 * N, state, context);
    memory = CVodeCreate(adams ? CV_ADAMS : CV_BDF, context);
    if (!vector || !memory || CVodeInit(memory, right_hand_side, 0, vector))
        return "CVODE: no memory";
    if (CVodeSStolerances(memory, 1e-6, 1e-6) || CVodeSetMaxNumSteps(memory, 100000000))
        return "CVODE: not set up";
    if (adams)
        return CVodeSetNonlinearSolver(memory, SUNNonlinSol_FixedPoint(vector, 0, context))
                   ? "CVODE: no fixed-point iteration"
                   : NULL;
    SUNMatrix A = SUNDenseMatrix(2 * N, 2 * N, context);
    return CVodeSetLinearSolver(memory, SUNLinSol_Dense(vector, A, context), A)
               ? "CVODE: no linear solver"
               : NULL;
}

const char *bench_prepare(double setting, const double *y0, double t_end)
{
    (void)y0, (void)t_end;
    return CVodeSStolerances(memory, setting, setting) ? "CVODE: tolerance refused" : NULL;
}

const char *bench_integrate(double setting, double *y, double t_end)
{
    double t = 0;

    (void)setting;
    memcpy(state, y, sizeof state);
    if (CVodeReInit(memory, 0, vector) || CVodeSetStopTime(memory, t_end)) return "CVODE: restart";
    if (CVode(memory, t_end, vector, &t, CV_NORMAL) != CV_TSTOP_RETURN) return "CVODE failed";
    memcpy(y, state, sizeof state);
    return NULL;
}
