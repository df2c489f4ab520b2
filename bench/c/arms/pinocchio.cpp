// Pinocchio's articulated-body algorithm, composite rigid bodies and recursive Newton-Euler, its
// templates compiled here. The word says in which frames they work: local or world.
// The file has a line a link: axis (3 numbers), mass, moment of inertia, centre, length.
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "arm.h"

namespace pin = pinocchio;

static pin::Model model;
static std::unique_ptr<pin::Data> data;
static Eigen::VectorXd zero;
static pin::Convention convention;

static pin::JointModel about(const Eigen::Vector3d &axis)
{
    if (axis.isApprox(Eigen::Vector3d::UnitX())) return pin::JointModelRX();
    if (axis.isApprox(Eigen::Vector3d::UnitY())) return pin::JointModelRY();
    if (axis.isApprox(Eigen::Vector3d::UnitZ())) return pin::JointModelRZ();
    return pin::JointModelRevoluteUnaligned(axis.normalized());
}

int arm_open(const char *file, const char *word)
{
    std::ifstream in(file);
    Eigen::Vector3d axis;
    double mass, inertia, centre, length, before = 0;
    pin::JointIndex parent = 0;

    convention = std::string(word) == "world" ? pin::Convention::WORLD : pin::Convention::LOCAL;
    model.gravity.linear(Eigen::Vector3d(0, 0, -9.81));
    while (in >> axis[0] >> axis[1] >> axis[2] >> mass >> inertia >> centre >> length) {
        const pin::SE3 place(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, before));
        parent = model.addJoint(parent, about(axis), place, "q" + std::to_string(parent + 1));
        const pin::Inertia body(mass, Eigen::Vector3d(0, 0, centre),
                                inertia * Eigen::Matrix3d::Identity());
        model.appendBodyToJoint(parent, body, pin::SE3::Identity());
        before = length;
    }
    data.reset(new pin::Data(model));
    zero = Eigen::VectorXd::Zero(model.nv);
    return model.nv == 0;
}

int arm_evaluate(enum arm_what what, const double *q, const double *v, double *out)
{
    const Eigen::Map<const Eigen::VectorXd> at(q, model.nq), rate(v, model.nv);

    if (what == ARM_ACCELERATION) {
        Eigen::Map<Eigen::VectorXd>(out, model.nv) =
            pin::aba(model, *data, at, rate, zero, convention);
    } else if (what == ARM_FORCE) {
        Eigen::Map<Eigen::VectorXd>(out, model.nv) = -pin::rnea(model, *data, at, rate, zero);
    } else {
        pin::crba(model, *data, at, convention);
        for (int i = 0; i < model.nv; i++)
            for (int j = i; j < model.nv; j++)
                out[i * model.nv + j] = out[j * model.nv + i] = data->M(i, j);
    }
    return 0;
}
