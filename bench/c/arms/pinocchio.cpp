// Pinocchio's articulated-body algorithm, composite rigid bodies and recursive Newton-Euler, its
// templates compiled here. The word says in which frames they work: local or world.
// The file has a line a link, after its parent's: the parent's number or -1, r or p, the axis, the turning
// of the joint's frame by rows, its place, the mass, its centre and the inertia about that by rows.
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

static pin::JointModel about(const Eigen::Vector3d &axis, char kind)
{
    if (kind == 'p') {
        if (axis.isApprox(Eigen::Vector3d::UnitX())) return pin::JointModelPX();
        if (axis.isApprox(Eigen::Vector3d::UnitY())) return pin::JointModelPY();
        if (axis.isApprox(Eigen::Vector3d::UnitZ())) return pin::JointModelPZ();
        return pin::JointModelPrismaticUnaligned(axis.normalized());
    }
    if (axis.isApprox(Eigen::Vector3d::UnitX())) return pin::JointModelRX();
    if (axis.isApprox(Eigen::Vector3d::UnitY())) return pin::JointModelRY();
    if (axis.isApprox(Eigen::Vector3d::UnitZ())) return pin::JointModelRZ();
    return pin::JointModelRevoluteUnaligned(axis.normalized());
}

int arm_open(const char *file, const char *word)
{
    std::ifstream in(file);
    int parent;
    char kind;
    Eigen::Vector3d axis, at, centre;
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> turn, inertia;
    double mass;
    const auto read = [&in](double *to, int count) {
        for (int i = 0; i < count; i++) in >> to[i];
    };

    convention = std::string(word) == "world" ? pin::Convention::WORLD : pin::Convention::LOCAL;
    model.gravity.linear(Eigen::Vector3d(0, 0, -9.81));
    while (in >> parent >> kind) {
        read(axis.data(), 3), read(turn.data(), 9), read(at.data(), 3);
        read(&mass, 1), read(centre.data(), 3), read(inertia.data(), 9);
        const pin::JointIndex joint =
            model.addJoint((pin::JointIndex)(parent + 1), about(axis, kind), pin::SE3(turn, at),
                           "q" + std::to_string(model.njoints));
        model.appendBodyToJoint(joint, pin::Inertia(mass, centre, inertia), pin::SE3::Identity());
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
