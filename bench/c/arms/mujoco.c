/* MuJoCo's mj_forward() of a model without contacts, constraints and actuators. The file is MJCF. */
#include <stdio.h>
#include <string.h>

#include <mujoco/mujoco.h>

#include "arm.h"

static mjModel *model;
static mjData *data;

int arm_open(const char *file, const char *word)
{
    (void)word;
    char why[1000] = "";
    model = mj_loadXML(file, NULL, why, sizeof why);
    if (!model) return fprintf(stderr, "%s\n", why), 1;
    data = mj_makeData(model);
    return !data;
}

int arm_evaluate(enum arm_what what, const double *q, const double *v, double *out)
{
    const size_t n = (size_t)model->nv;
    memcpy(data->qpos, q, n * sizeof *q);
    memcpy(data->qvel, v, n * sizeof *v);
    if (what == ARM_ACCELERATION) {
        mj_forward(model, data);
        memcpy(out, data->qacc, n * sizeof *out);
    } else {
        mj_fwdPosition(model, data);
        if (what == ARM_MASS) return mj_fullM(model, data, out), 0;
        mj_fwdVelocity(model, data);
        for (size_t i = 0; i < n; i++) out[i] = data->qfrc_passive[i] - data->qfrc_bias[i];
    }
    return 0;
}
