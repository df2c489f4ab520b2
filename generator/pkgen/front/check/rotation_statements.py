"""Checks `rotation`, and forces, starts (initial values) and ends of rotations.

In a Model a rotation is three coordinates, whose rates are the body rates, and four states, the
quaternion: see check/rotations.py. So a torque is three forces, an initial attitude four starts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from ... import model as m
from ...indices import made_of
from ...tree import AXES, Expr, Number
from .. import statements as st
from .. import units
from ..units import NONE, si_text
from .expr import Target
from .names import Entry, Facts
from .rotations import attitude, quaternion_names, quaternion_of, rate_names, turn_names
from .scope import Scope
from .shared import Checks
from .vectors import component

# Most factors in a product of rotations. Each factor multiplies the number of terms.
TURNS = 5


class Rotations(Checks):
    def declare(self, item: st.Declared, unit: units.Unit | None, description: str) -> None:
        """Checks `rotation NAME`; reports a unit. The argument `unit` is not used."""
        if item.unit is not None:
            self.error("a rotation has no unit", item.unit, f"rotation {item.name}")
        own, turns = frozenset((item.name,)), (attitude(item.name, None, item.span),)
        facts = Facts(NONE, True, united=True, coordinates=own, turns=turns)
        found = self.declared(item, "rotation", facts)
        if found is None:
            return
        time, energy = self.time_dimension, self.energy_dimension
        per_time, action = units.over(NONE, time), units.times(energy, time)
        momenta = tuple(f"{made_of('p_{}', item.name)}.{axis}" for axis in AXES)
        names = *(f(item.name) for f in (quaternion_names, rate_names, turn_names)), momenta
        texts = si_text(per_time, 1 if time != NONE else 0), si_text(per_time), si_text(action)
        rotation = m.Rotation(item.name, found[0], *names, *texts, description, item.span)
        self.parts["rotations"].append(rotation)

    def force(self, statement: st.Define) -> Iterable[m.Force]:
        """Checks a torque, a vector of components in the body frame; returns three forces."""
        left = statement.left
        found = self.wanted_of(left, statement.value, "a force", ("rotation",), "force")
        if found is None:
            return ()
        needs = "a torque [N*m]" if self.energy_dimension != NONE else "numbers"
        target = Target(self.energy_dimension, f"the torque on {left.name} is a vector of {needs}")
        value, facts = self.wanted_vector(statement.value, found[1], target)
        self.use_inputs(facts)
        if not facts.vector:
            return ()
        return tuple(
            m.Force(turn, left.index, left.range, component(value, k), statement.span)
            for k, turn in enumerate(turn_names(left.name))
        )

    def start(
        self, item: st.StartItem, entry: Entry | None, around: Scope
    ) -> tuple[m.Start, ...] | None:
        """Returns four starts of the quaternion for `start R = rot(...)`, three starts of the rates
        for `start omega(R) = [...]`; None after an error."""
        left = item.left
        before = self.report.count
        if item.function not in ("", "omega"):
            self.error(
                f"a start gives {left.name} or omega({left.name}), not {item.function}", item
            )
        elif entry is not None and entry.kind != "rotation":
            message = f"omega is of a rotation; '{left.name}' is none"
            self.error(message, item, f"its rate is {left.name}'")
        elif item.order:
            help = f"start omega({left.name}) = [x, y, z]"
            self.error(f"the rates of a rotation are omega({left.name})", item, help)
        scope = self.member_scope(left, entry, around) or around
        of_rates = item.function or item.order  # Above, `start R'` is reported as an error.
        if of_rates:
            values = self._rates(item, scope)
        else:
            values, _ = self.numbers("a start", f"start {left.name}", item.value, scope)
        if self.report.count > before or entry is None or not values:
            return None
        order, names = (1, turn_names) if item.function else (0, quaternion_names)
        return tuple(
            m.Start(name, left.index, left.range, order, value, item.span)
            for name, value in zip(names(left.name), values, strict=True)
        )

    def _rates(self, item: st.StartItem, around: Scope):
        dimension = units.over(NONE, self.time_dimension)
        target = Target(dimension, f"omega({item.left.name}) is a vector of rates", bare=True)
        value, facts = self.wanted_vector(item.value, around, target)
        return [component(value, k) for k in range(len(AXES))] if facts.vector else None

    def numbers(
        self, what: str, example: str, value: Expr, around: Scope
    ) -> tuple[tuple[Expr, ...] | None, Facts]:
        """Returns the quaternion of a product of rot(...), or None after an error; and the facts of
        the product."""
        _, facts = self.factor(value, around)
        if not facts.turns:
            if facts.known:
                message = f"{self.text(value)} is no rotation"
                self.error(message, value, f"e.g. {example} = rot([1, 0, 0], 0.3)")
            return None, facts
        if len(facts.turns) > TURNS:
            self.error(f"{what} of more than {TURNS} turns", value)
            return None, facts
        if any(turn.quaternion is not None for turn in facts.turns):
            return None, facts  # A declared rotation is an error, reported elsewhere.
        if any(turn.angle is None for turn in facts.turns):
            self.error(f"{what} is a product of rot(AXIS, ANGLE)", value)
            return None, facts
        return quaternion_of(facts.turns, value.span), facts


def ends_of(end: m.End, numbers: tuple[Expr, ...] | None) -> Iterable[m.End]:
    """Yields the end of a family of rotations as ends of the four states and three coordinates of
    the family. `numbers` is the quaternion of a fixed end, which is the value of the states. The
    coordinates get the value None, since their rates follow from the quaternion."""
    for k, number in enumerate(quaternion_names(end.name)):
        yield replace(end, name=number, value=numbers and numbers[k])
    for turn in turn_names(end.name):
        yield replace(end, name=turn, value=None)


def coordinates_of(rotation: m.Rotation) -> Iterable[m.Coordinate]:
    """Yields the three coordinates whose rates are the body rates; they have no unit."""
    units_of = "", rotation.rate_unit, rotation.momentum_unit
    for k, axis in enumerate(AXES):
        says = rotation.description or f"body rate about {axis}"
        own = rotation.rates[k], rotation.momenta[k]
        yield m.Coordinate(rotation.turns[k], rotation.range, *units_of, says, rotation.span, *own)


def states_of(rotation: m.Rotation) -> Iterable[m.State]:
    """Yields the four states of the quaternion w, x, y, z, dimensionless."""
    for number in rotation.quaternion:
        what = rotation.description or "of its unit quaternion, body to space"
        yield m.State(number, rotation.range, "", rotation.per_time, what, rotation.span)


def identity(rotation: m.Rotation) -> m.Start:
    """Returns the default start, the identity quaternion (1, 0, 0, 0)."""
    one = Number(Fraction(1), rotation.span)
    return m.Start(rotation.quaternion[0], None, rotation.range, 0, one, rotation.span)
