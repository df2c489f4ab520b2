"""Drake: plants of bodies and blocks joined by ports; a Simulator with error control.

A block in Python costs a call at each evaluation; the same blocks in C++ would be faster.
"""

from __future__ import annotations

from functools import partial
from importlib import metadata

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import (
    JacobianWrtVariable,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import (
    DiagramBuilder,
    LeafSystem,
    UnrestrictedUpdateEvent,
    WitnessFunctionDirection,
)
from pydrake.systems.primitives import ConstantVectorSource, LinearSystem, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from .cases import UNTIL, road

VERSION = f"Drake {metadata.version('drake')}"
ROD = """<link name="{0}"><inertial><origin xyz="0 0 {1}"/><mass value="{2}"/>
    <inertia ixx="{3}" iyy="{3}" izz="{4}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
HINGE = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>
    <origin xyz="0 0 {3}"/><axis xyz="0 -1 0"/>{4}</joint>"""
MOTOR = """<transmission name="{0}m"><type>SimpleTransmission</type><joint name="{0}"/>
    <actuator name="{0}m"/></transmission>"""


def wind():
    text = '<robot name="rods">' + ROD.format("upper", -0.5, 1, 0.09, 0.01)
    text += ROD.format("lower", -0.4, 0.5, 0.03, 0.005)
    text += HINGE.format("hip", "world", "upper", 0, "")
    text += HINGE.format("knee", "upper", "lower", -1, "") + "</robot>"
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.Finalize()
    drag = builder.AddSystem(Drag(plant))
    builder.Connect(plant.get_state_output_port(), drag.get_input_port())
    builder.Connect(drag.get_output_port(), plant.get_applied_spatial_force_input_port())
    return builder.Build(), [1.2, -0.5, 0, 0]


class Drag(LeafSystem):
    def __init__(self, plant):
        super().__init__()
        self.plant, self.own = plant, plant.CreateDefaultContext()
        self.frame, self.tip = plant.GetFrameByName("lower"), np.array([0, 0, -0.8])
        self.DeclareVectorInputPort("state", 4)
        forces = Value[list[ExternallyAppliedSpatialForce]]
        self.DeclareAbstractOutputPort("forces", lambda: forces(), self.forces)

    def forces(self, context, output):
        self.plant.SetPositionsAndVelocities(self.own, self.get_input_port().Eval(context))
        world = self.plant.world_frame()
        J = self.plant.CalcJacobianTranslationalVelocity(
            self.own, JacobianWrtVariable.kV, self.frame, self.tip, world, world
        )
        f = ExternallyAppliedSpatialForce()
        f.body_index, f.p_BoBq_B = self.frame.body().index(), self.tip
        v = J @ self.plant.GetVelocities(self.own)
        f.F_Bq_W = SpatialForce(np.zeros(3), 0.2 * (np.array([4, 0, 0]) - v))
        output.set_value([f])


class Springs(LeafSystem):
    def __init__(self):
        super().__init__()
        self.DeclareContinuousState(1, 1, 0)
        self.DeclareAbstractState(Value(True))  # on the right
        kind, flip = WitnessFunctionDirection.kCrossesZero, UnrestrictedUpdateEvent(self.flip)
        self.edge = self.MakeWitnessFunction("edge", kind, self.place, flip)

    def DoGetWitnessFunctions(self, context):
        return [self.edge]

    def place(self, context):
        return context.get_continuous_state_vector()[0]

    def flip(self, context, event, state):
        right = context.get_abstract_state(0).get_value()
        state.get_mutable_abstract_state(0).set_value(not right)

    def right(self, context):
        return context.get_abstract_state(0).get_value()

    def DoCalcTimeDerivatives(self, context, derivatives):
        x, v = context.get_continuous_state_vector().CopyToVector()
        derivatives.SetFromVector([v, -(4 if self.right(context) else 25) * x])


def car():
    K, C, k, M, m = 20e3, 1500, 180e3, 300, 40
    A = np.array(
        [[0, 0, 1, 0], [0, 0, 0, 1], [-K / M, K / M, -C / M, C / M],
         [K / m, -(K + k) / m, C / m, -C / m]]
    )  # fmt: skip
    B, x = np.array([[0], [0], [0], [k / m]]), np.array(road())
    height = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(x[0] / 15, x[1:])
    builder = DiagramBuilder()
    ground = builder.AddSystem(TrajectorySource(height))
    body = builder.AddSystem(LinearSystem(A, B, np.eye(4), np.zeros((4, 1))))
    builder.Connect(ground.get_output_port(), body.get_input_port())
    return builder.Build(), [0, 0, 0, 0]


def from_knot_to_knot(simulator, until):
    for t in np.array(road()[0]) / 15:
        simulator.AdvanceTo(min(t, until))


def arm():
    limit = '<limit effort="{}"/>'
    text = '<robot name="arm">' + ROD.format("upper", -0.5, 2, 0, 0)
    text += ROD.format("lower", -0.4, 1.5, 0, 0)
    text += HINGE.format("a", "world", "upper", 0, limit.format(45)) + MOTOR.format("a")
    text += HINGE.format("b", "upper", "lower", -0.5, limit.format(20)) + MOTOR.format("b")
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    Parser(plant).AddModelsFromString(text + "</robot>", "urdf")
    plant.Finalize()
    pid = builder.AddSystem(Pid(0.01))
    builder.Connect(plant.get_state_output_port(), pid.get_input_port())
    builder.Connect(pid.get_output_port(), plant.get_actuation_input_port())
    return builder.Build(), [-0.5, 0.3, 0, 0]


class Pid(LeafSystem):
    def __init__(self, T):
        super().__init__()
        self.T = T
        self.DeclareVectorInputPort("state", 4)
        held = self.DeclareDiscreteState(2)
        self.DeclareDiscreteState(2)  # the integrals of the errors
        self.DeclareStateOutputPort("torques", held)
        self.DeclarePeriodicDiscreteUpdateEvent(T, 0.0, self.sample)

    def sample(self, context, discrete):
        x, s = self.get_input_port().Eval(context), context.get_discrete_state(1).value()
        most, error = np.array([45, 20]), np.array([1, 0.5]) - x[:2]
        wanted = np.array([150, 90]) * error + np.array([200, 120]) * s - np.array([25, 12]) * x[2:]
        s = s + np.where(abs(wanted) < most, self.T * error, 0)
        discrete.set_value(0, np.clip(wanted, -most, most))
        discrete.set_value(1, s)


def motors(step):
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(step))
    left, right = motor(plant, "left", 0.02, 1.5), motor(plant, "right", 0.3, 4)
    plant.AddCouplerConstraint(left, right, 3)
    plant.Finalize()
    volts = builder.AddSystem(ConstantVectorSource([0.3 * 12 / 1.5, 0]))
    builder.Connect(volts.get_output_port(), plant.get_actuation_input_port())
    return builder.Build(), [0, 0, 3, 1]


def geared():
    """The right motor's joint; the left one is the rotor of its actuator."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    motor(plant, "right", 0.3, 4, b=0.01 + 3**2 * (0.01 + 0.3**2 / 1.5))
    actuator = plant.GetJointActuatorByName("right")
    actuator.set_default_gear_ratio(3)
    actuator.set_default_rotor_inertia(0.02)
    plant.Finalize()
    torque = builder.AddSystem(ConstantVectorSource([3 * 0.3 * 12 / 1.5]))
    builder.Connect(torque.get_output_port(), plant.get_actuation_input_port())
    return builder.Build(), [0, 1]


def motor(plant, name, J, R, K=0.3, b=0.01):
    body = plant.AddRigidBody(name, SpatialInertia(1, np.zeros(3), UnitInertia(J, J, J)))
    here = RigidTransform(), plant.world_frame(), body.body_frame()
    damping = b + K**2 / R
    joint = RevoluteJoint(name, here[1], here[2], [0, 0, 1], damping=damping)
    joint = plant.AddJoint(joint)
    plant.AddJointActuator(name, joint)
    return joint


def crossed():
    """The springs without the witness."""
    system = Springs()
    system.DoGetWitnessFunctions = lambda context: []
    system.right = lambda context: system.place(context) > 0
    return system, [0.3, 0]


BUILD = {"wind": wind, "springs": lambda: (Springs(), [0.3, 0]), "road": car, "arm": arm}
BUILD |= {"springs across": crossed, "motors": geared, "motors default": lambda: motors(1e-3)}


def _prepared(name: str, way: str):
    system, start = BUILD.get(f"{name} {way}", BUILD[name])()

    def go():
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        if context.num_continuous_states():
            state = context.get_mutable_continuous_state_vector()
        else:
            state = context.get_mutable_discrete_state_vector()
        state.SetFromVector(start)
        if way != "default":
            ResetIntegratorFromFlags(simulator, "runge_kutta5", 0.1)
            simulator.get_mutable_integrator().set_target_accuracy(1e-12)
        if name == "springs" and way != "across":
            context.SetAccuracy(1e-12 if way == "best" else 1e-4)  # a witness asks for it
        if name == "road" and way == "best":
            from_knot_to_knot(simulator, UNTIL[name])
        simulator.AdvanceTo(UNTIL[name])
        end = state.CopyToVector()
        geared_down = name == "motors" and way == "best"
        return [3 * end[0], end[0], 3 * end[1], end[1]] if geared_down else end

    return go


def _case(name: str, counted: tuple, means: str, kink: str = "–") -> tuple:
    return partial(_prepared, name), counted, means, kink


ACROSS = ("springs", "road")
CASES = {
    "wind": _case("wind", (ROD, HINGE, wind, Drag), "URDF, block for the force"),
    "springs": _case("springs", (Springs,), "block, witness", "to the accuracy; else silent"),
    "road": _case(
        "road", (car, from_knot_to_knot), "LinearSystem, spline source", "own stops; else silent"
    ),
    "arm": _case("arm", (ROD, HINGE, MOTOR, arm, Pid), "URDF, periodic update", "stops by itself"),
    "motors": _case("motors", (geared, motor), "coupler / actuator's gear ratio"),
}
