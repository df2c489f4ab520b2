"""Rotations in models with loops: derivatives along the body axes, and time derivatives of
quaternions. For other models attitudes.py has these functions."""

from __future__ import annotations

from ...equations import Row
from ...graph.affine import Affine
from ...graph.frames import cross
from ...graph.graph import ZERO, Node
from ...model import Model, Rotation
from ..attitudes import along_axes, quaternion_rates
from .indexed_ir import Slot
from .slots import Slots

Slopes = dict[Node, Node]


class Rotations:
    """The rotations of a model, found by the names of their body rates, their coordinates, and the
    components of their quaternions."""

    def __init__(self, model: Model, slots: Slots):
        self.slots, self.g = slots, slots.graph
        self.all = model.rotations
        self.rates = {n: (r, axis) for r in self.all for axis, n in enumerate(r.rates)}
        self.turns = {n: (r, axis) for r in self.all for axis, n in enumerate(r.turns)}
        self.numbers = {n: (r, k) for r in self.all for k, n in enumerate(r.quaternion)}

    def moved(self, slot: Slot) -> tuple[str, ...]:
        """Returns the names of the coordinates whose equations of motion contain derivatives by the
        symbol `slot`. For a component of a quaternion, these are the three coordinates of the
        rotation."""
        own = self.turns.get(slot.name) or self.numbers.get(slot.name)
        if own:
            return own[0].turns
        return (slot.name,) if slot.kind in ("q", "v") else ()

    def quaternion(self, rotation: Rotation, at: Affine | None) -> Row:
        return tuple(self.slots.node("s", name, at) for name in rotation.quaternion)

    def body_rates(self, rotation: Rotation, at: Affine | None) -> Row:
        return tuple(self.slots.node("v", name, at) for name in rotation.turns)

    def moving(self, rotation: Rotation, at: Affine | None) -> Row:
        """Returns the time derivatives of the components of a rotation's quaternion."""
        own = self.quaternion(rotation, at)
        return quaternion_rates(self.g, own, self.body_rates(rotation, at))

    def slope(self, by: Slopes, name: str, at: Affine | None, momenta: bool) -> Node:
        """Returns the derivative of a function F along the coordinate `name`. For a coordinate of a
        rotation, this is the derivative along a body axis. `by` maps symbols to the derivatives of
        F by them. With `momenta`, F is L, and p x w is added for rotations (see attitudes.py)."""
        if name not in self.turns:
            return by.get(self.slots.node("q", name, at), ZERO)
        rotation, axis = self.turns[name]
        quaternion = self.quaternion(rotation, at)
        found = along_axes(self.g, quaternion, tuple(by.get(n, ZERO) for n in quaternion))[axis]
        if not momenta:
            return found
        w = self.body_rates(rotation, at)
        p = tuple(by.get(n, ZERO) for n in w)
        return self.g.add(found, cross(self.g, p, w)[axis])
