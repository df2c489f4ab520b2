"""Drake: a plant's compliant contacts by default; at best a block of one's own with a witness.

The plant has no restitution, so that ball, cradle and graze are blocks in both ways.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import (
    LinearBushingRollPitchYaw,
    PlanarJoint,
    PrismaticJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import (
    BasicVector,
    DiagramBuilder,
    LeafSystem,
    UnrestrictedUpdateEvent,
    WitnessFunctionDirection,
)

from ..drake_ import VERSION  # noqa: F401
from .cases import GAP, LESS, MU, OVER, SLENDER, SPEED, TILT, TIMES

JUST_OPEN = 1e-300  # a witness must be positive before it triggers, after a bounce too
REST = {"default": 1e-3, "best": 1e-9}  # lower than the window of a witness: no end of bounces


class Hybrid(LeafSystem):
    """x' = rates(x, mode); where an edge falls through 0, jump(i, x, mode) gives both anew."""

    def __init__(self, start, mode, rates, edges, jump):
        super().__init__()
        self.rates, self.jump = rates, jump
        self.DeclareContinuousState(BasicVector(np.array(start, dtype=float)))
        self.DeclareAbstractState(Value(mode))
        falls = WitnessFunctionDirection.kPositiveThenNonPositive
        self.edges = [
            self.MakeWitnessFunction(
                str(i),
                falls,
                lambda context, edge=edge: edge(*self.both(context)),
                UnrestrictedUpdateEvent(partial(self.meet, i)),
            )
            for i, edge in enumerate(edges)
        ]

    def DoGetWitnessFunctions(self, context):
        return self.edges

    def both(self, context):
        x = context.get_continuous_state_vector().CopyToVector()
        return x, context.get_abstract_state(0).get_value()

    def meet(self, i, context, event, state):
        x, mode = self.jump(i, *self.both(context))
        state.get_mutable_continuous_state().SetFromVector(x)
        state.get_mutable_abstract_state(0).set_value(mode)

    def DoCalcTimeDerivatives(self, context, derivatives):
        derivatives.SetFromVector(self.rates(*self.both(context)))


def ball(way):
    def bounce(i, x, rests):
        rests = -x[1] < REST[way]
        return [0, 0] if rests else [JUST_OPEN, -0.8 * x[1]], rests

    fall = lambda x, rests: [0, 0] if rests else [x[1], -9.81]  # noqa: E731
    return Hybrid([0, 5], False, fall, [lambda x, rests: x[0]], bounce)


def cradle():
    def swap(i, x, mode):
        x[[5 + i, 6 + i]] = x[[6 + i, 5 + i]]
        return x, mode

    rates = lambda x, mode: [*x[5:], *(-9.81 / 0.3 * x[:5])]  # noqa: E731
    gaps = [lambda x, mode, i=i: x[i + 1] - x[i] + GAP for i in range(4)]
    return Hybrid([-0.1, *[0] * 9], None, rates, gaps, swap)


def graze(stop):
    rates, gap = lambda x, mode: [x[1], -x[0]], lambda x, mode: stop - x[0]
    return Hybrid([0, 1], None, rates, [gap], lambda i, x, mode: ([stop, -0.5 * x[1]], mode))


def rock(way):
    def impact(i, x, side):
        rate = (1 - 1.5 * np.sin(SLENDER) ** 2) * x[1]
        return ([0, 0], 0) if abs(rate) < REST[way] else ([-side * JUST_OPEN, rate], -side)

    def rates(x, side):
        return [x[1], -side * 0.75 * 9.81 * np.sin(SLENDER - side * x[0])]

    return Hybrid([TILT, 0], 1, rates, [lambda x, side: side * x[0]], impact)


def box(over):
    slope = np.arctan(MU + over)
    a = 9.81 * (np.sin(slope) - MU * np.cos(slope))
    rates = lambda x, slips: [x[1], a * slips]  # noqa: E731
    return Hybrid([0, SPEED], 1, rates, [lambda x, slips: x[1]], lambda i, x, _: ([x[0], 0], 0))


def belt():
    edge = lambda x, sticks: 1.5 - x[0] if sticks else 0.1 - x[1]  # noqa: E731
    rates = lambda x, sticks: [x[1], 0 if sticks else 1 - x[0]]  # noqa: E731
    return Hybrid([0, 0.1], True, rates, [edge], lambda i, x, sticks: ([x[0], 0.1], not sticks))


def material(friction):
    given = ProximityProperties()
    AddContactMaterial(properties=given, friction=CoulombFriction(*friction))
    return given


def plant_of(step, slope, a, b, mass, friction, belt=None):
    """A block in the plane, on small spheres at its lower corners: a box touches at one point."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, step)
    plant.mutable_gravity_field().set_gravity_vector(
        [9.81 * np.sin(slope), -9.81 * np.cos(slope), 0]
    )
    body = plant.AddRigidBody(
        "block", SpatialInertia(mass, np.zeros(3), UnitInertia.SolidBox(2 * a, 2 * b, 0))
    )
    frames, ground = (plant.world_frame(), body.body_frame()), plant.world_body()
    plant.AddJoint(PlanarJoint("block", *frames, [0, 0, 0]))
    if belt:
        ground = plant.AddRigidBody("belt", SpatialInertia(1e9, np.zeros(3), UnitInertia(1, 1, 1)))
        moves = PrismaticJoint("belt", plant.world_frame(), ground.body_frame(), [1, 0, 0])
        plant.AddJoint(moves)
        spring = np.zeros(3), np.zeros(3), np.array([1.0, 0, 0]), np.zeros(3)
        plant.AddForceElement(LinearBushingRollPitchYaw(*frames, *spring))
    up = RigidTransform(HalfSpace.MakePose(np.array([0, 1, 0]), np.zeros(3)))
    plant.RegisterCollisionGeometry(ground, up, HalfSpace(), "ground", material(friction))
    for x in (-a, a):
        at, corner = RigidTransform([x, -b, 0]), Sphere(1e-9)
        plant.RegisterCollisionGeometry(body, at, corner, f"{x}", material(friction))
    plant.Finalize()
    return builder.Build(), plant


def plants(name):
    """For each run: values of the plant, the pose, the rate, and the coordinate compared."""
    a, b, c, s = np.sin(SLENDER), np.cos(SLENDER), np.cos(TILT), np.sin(TILT)
    if name == "rock":
        return [((1e-3, 0, a, b, 1, (3, 3)), [a * c - b * s, a * s + b * c, TILT], 0, 2)]
    if name == "belt":  # steps of fixed length leave out the static friction
        return [((0, 0, 0.3, 0.2, 1, (1.5 / 9.81, 1 / 9.81), 0.1), [0, 0.2, 0], 0.1, 0)]
    slopes = [np.arctan(MU + over) for over in (-OVER, OVER)]
    return [((1e-3, x, 0.3, 0.2, 2, (MU, MU)), [0, 0.2, 0], SPEED, 0) for x in slopes]


def _plants(name):
    systems = [(plant_of(*given), *start) for given, *start in plants(name)]

    def go():
        end = []
        for (diagram, plant), pose, rate, asked in systems:
            simulator = Simulator(diagram)
            own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
            block = plant.GetJointByName("block")
            block.set_pose(own, pose[:2], pose[2])
            block.set_translational_velocity(own, [rate, 0])
            if name == "belt":
                plant.GetJointByName("belt").set_translation_rate(own, 0.1)
                ResetIntegratorFromFlags(simulator, "cenic", 0.1)
            for t in TIMES[name]:
                simulator.AdvanceTo(t)
                place = [*block.get_translation(own), block.get_rotation(own)]
                rates = [*block.get_translational_velocity(own), block.get_angular_velocity(own)]
                end += [place[asked], rates[asked]]
        return end

    return go


def _hybrids(build, way, runs, short):
    systems, name = [build(*x) for x in runs], build.__name__

    def go():
        end = []
        for system in systems:
            simulator = Simulator(system)
            context = simulator.get_mutable_context()
            asked = 1e-10 if name == "graze" else 1e-12  # with less the flat pass never ends
            context.SetAccuracy(1e-4 if way == "default" else asked)
            if way == "best":
                ResetIntegratorFromFlags(simulator, "runge_kutta5", short)
                simulator.get_mutable_integrator().set_target_accuracy(1e-12)
            for t in TIMES[name]:
                simulator.AdvanceTo(t)
                end += context.get_continuous_state_vector().CopyToVector().tolist()
        return end

    return go


def _case(build, says: str, runs=None, short=0.1) -> tuple:
    name, plant = build.__name__, build in (rock, box, belt)

    def prepare(way: str):
        if plant and way == "default":
            return _plants(name)
        return _hybrids(build, way, runs or [(way,)], short)

    means = "plant / block, witness" if plant else "block, witness"
    return prepare, (Hybrid, build), means, says


SLOPES, STOPS = [(-OVER,), (OVER,)], [(1 - LESS,), (1 + LESS,)]
CASES = {
    "ball": _case(ball, "bounces for ever; own rule of rest"),
    "cradle": _case(cradle, "one by one, by own rule", [()]),
    "rock": _case(rock, "rests, no time told / own rule of rest"),
    "box": _case(box, "slides on both / own rule of stick", SLOPES),
    "belt": _case(belt, "creeps, slips early / own rule of stick", [()]),
    "graze": _case(graze, "passed silently / steps of 1 ms", STOPS, 1e-3),
}
