"""`rotation`, and what is started and applied along one.

In the model a rotation is three coordinates of its own, whose rates are its body rates, and four
states, its quaternion: see check/rotations.py. So a torque is three forces, and a start four.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from ... import model as m
from ...tree import AXES, Number
from .. import statements as st
from .. import units
from ..units import NONE, si_text
from .expr import Target
from .names import Entry, Facts
from .rotations import attitude, quaternion_names, quaternion_of, rate_names, turn_names
from .scope import PLACES, Scope
from .shared import Checks
from .vectors import component

TURNS = 5  # of a start: more are more terms than anyone writes


class Rotations(Checks):
    def declare(self, item: st.Declared, unit: units.Unit | None, description: str) -> None:
        """`rotation NAME`; a unit or a range is reported, so that `unit` is of no use here."""
        if item.unit is not None:
            self.report.error("a rotation has no unit", item.unit.span, f"rotation {item.name}")
        if item.lo is not None:
            self.report.error(
                "a family of rotations cannot be compiled", item.span, "declare them one by one"
            )
        own, turns = frozenset((item.name,)), (attitude(item.name, item.span),)
        facts = Facts(NONE, True, united=True, coordinates=own, turns=turns)
        self.names.declare(Entry(item.name, "rotation", facts, item.name_span))
        time, energy = self.expressions.time_dimension, self.expressions.energy_dimension
        per_time, action = units.over(NONE, time), units.times(energy, time)
        momenta = tuple(f"p_{item.name}.{axis}" for axis in AXES)
        names = *(f(item.name) for f in (quaternion_names, rate_names, turn_names)), momenta
        texts = si_text(per_time, 1 if time != NONE else 0), si_text(per_time), si_text(action)
        rotation = m.Rotation(item.name, *names, *texts, description, item.span)
        self.parts["rotations"].append(rotation)

    def force(self, statement: st.Define) -> Iterable[m.Force]:
        """A torque, in body components."""
        left, scope = statement.left, Scope(PLACES["force"])
        self._plain(left)
        needs = "a torque [N*m]" if self.expressions.energy_dimension != NONE else "numbers"
        target = Target(
            self.expressions.energy_dimension, f"the torque on {left.name} is a vector of {needs}"
        )
        value, facts = self.expressions.wanted_vector(statement.value, scope, target)
        self.shared.use_inputs(facts)
        if not facts.vector:
            return ()
        return tuple(
            m.Force(turn, None, None, component(value, k), statement.span)
            for k, turn in enumerate(turn_names(left.name))
        )

    def start(
        self, item: st.StartItem, entry: Entry | None, around: Scope
    ) -> tuple[m.Start, ...] | None:
        """`start R = rot(...)` as four starts of numbers, or `start omega(R) = [...]` as three of
        rates; None where that is wrong, said already."""
        left = item.left
        before = len(self.report.errors)
        self._plain(left)
        if item.function not in ("", "omega"):
            self.report.error(
                f"a start gives {left.name} or omega({left.name}), not {item.function}", item.span
            )
        elif entry is not None and entry.kind != "rotation":
            message = f"omega is of a rotation; '{left.name}' is none"
            self.report.error(message, item.span, f"its rate is {left.name}'")
        elif item.order:
            help = f"start omega({left.name}) = [x, y, z]"
            self.report.error(f"the rates of a rotation are omega({left.name})", item.span, help)
        of_rates = item.function or item.order  # R' gives rates, if under a wrong name
        values = self._rates(item, around) if of_rates else self._attitude(item, around)
        if len(self.report.errors) > before or entry is None or not values:
            return None
        order, names = (1, turn_names) if item.function else (0, quaternion_names)
        return tuple(
            m.Start(name, None, None, order, value, item.span)
            for name, value in zip(names(left.name), values, strict=True)
        )

    def _rates(self, item: st.StartItem, around: Scope):
        dimension = units.over(NONE, self.expressions.time_dimension)
        target = Target(dimension, f"omega({item.left.name}) is a vector of rates", bare=True)
        value, facts = self.expressions.wanted_vector(item.value, around, target)
        return [component(value, k) for k in range(len(AXES))] if facts.vector else None

    def _attitude(self, item: st.StartItem, around: Scope):
        _, facts = self.expressions.factor(item.value, around)
        if not facts.turns:
            if facts.known:
                message = f"{self.expressions.mismatch.text(item.value)} is no rotation"
                help = f"e.g. start {item.left.name} = rot([1, 0, 0], 0.3)"
                self.report.error(message, item.value.span, help)
            return None
        if len(facts.turns) > TURNS:
            self.report.error(f"a start of more than {TURNS} turns", item.value.span)
            return None
        if any(turn.quaternion is not None for turn in facts.turns):
            return None  # a rotation is no parameter: said already
        return quaternion_of(facts.turns, item.value.span)

    def _plain(self, left: st.Left) -> None:
        if left.index is not None or left.range is not None:
            self.report.error(f"'{left.name}' is one rotation: it takes no index", left.span)


def coordinates_of(rotation: m.Rotation) -> Iterable[m.Coordinate]:
    """Three, whose rates are the body rates; their own unit is that of an angle, none."""
    units_of = "", rotation.rate_unit, rotation.momentum_unit
    for k, axis in enumerate(AXES):
        says = rotation.description or f"body rate about {axis}"
        own = rotation.rates[k], rotation.momenta[k]
        yield m.Coordinate(rotation.turns[k], None, *units_of, says, rotation.span, *own)


def states_of(rotation: m.Rotation) -> Iterable[m.State]:
    """Four pure numbers w, x, y, z."""
    for number in rotation.quaternion:
        what = rotation.description or "of its unit quaternion, body to space"
        yield m.State(number, None, "", rotation.per_time, what, rotation.span)


def identity(rotation: m.Rotation) -> m.Start:
    """What is started nowhere else."""
    one = Number(Fraction(1), rotation.span)
    return m.Start(rotation.quaternion[0], None, None, 0, one, rotation.span)
