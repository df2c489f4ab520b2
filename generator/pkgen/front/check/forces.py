"""Checks `force`, `torque` and `noise`: along a coordinate, on a rotation, at a point, on a body.

A force F at a point P gives the generalized forces Q = (dP'/dv)^T F, where v are the rates. For a
torque in space the angular velocity stands in place of P'. Reference: D. Greenwood, Advanced
Dynamics, Cambridge 2003, section 2.1.
"""

from __future__ import annotations

from dataclasses import replace

from ... import model as m
from ...tree import Call, Expr, Multiply, Name, Prime, within
from .. import statements as st
from .. import units
from ..units import NONE, si_text
from .expr import Target
from .names import Entry, Facts, Members, joined
from .rotation_statements import Rotations
from .scope import PLACES, Scope
from .shared import Checks, Shared, name_span

# `force NAME` acts at a point for these kinds. A body is an error, which lists its points.
_POINTS = ("definition", "body")
_NEEDED = {units.ENERGY: "torques [N*m]", units.FORCE: "forces [N]", NONE: "numbers"}


class Forces(Checks):
    def __init__(self, shared: Shared, rotations: Rotations) -> None:
        super().__init__(shared)
        self.rotations = rotations
        self.powers = self.expressions.powers

    def force(self, statement: st.Force) -> None:
        left, place = statement.left, statement.place
        entry = None if left is None else self.names.table.get(left.name)
        kind = "" if entry is None else entry.kind
        if place is None and kind in _POINTS:
            place = _named(left)
        if place is not None:
            self._load(statement, place, Prime(place, place.span))
        elif kind == "rotation":
            entry.used = True
            self.parts["forces"] += self.rotations.force(statement)
        else:
            self._along(statement)

    def torque(self, statement: st.Force) -> None:
        """Checks a torque on a body or a rotation, a vector in space."""
        on = statement.place or _named(statement.left)
        entry = self.names.table.get(on.id) if isinstance(on, Name) else None
        body = entry is not None and entry.kind == "body"
        if not body and (entry is None or entry.kind not in ("rotation", "poisoned")):
            message = f"a torque acts on a body or a rotation; {self.text(on)} is neither"
            self.error(message, on, "a force acts at a point: force P = [Fx, Fy, Fz]")
            return
        turn, rates = on, Call("omega", (on,), on.span)
        if body:
            turn, rates = (Name(f"{on.id}.{x}", on.index, on.span) for x in ("R", "omega"))
        self._load(statement, on, Multiply((turn, rates), (1, 1), on.span))

    def _along(self, statement: st.Force) -> None:
        """Checks a generalized force along a coordinate."""
        left = statement.left
        kinds = ("coordinate", "rotation") if self.names.rotations else ("coordinate",)
        found = self.wanted_of(left, statement.value, "a force", kinds, "force")
        if found is None:
            return
        entry, scope = found
        dimension = units.over(self.energy_dimension, entry.facts.dimension)
        needs = {units.ENERGY: "a torque [N*m]", units.FORCE: "a force [N]", NONE: "a number"}
        text = needs.get(dimension, f"[{si_text(dimension)}]")
        target = Target(dimension, f"the force along {left.name} needs {text}")
        value, facts = self.wanted(statement.value, scope, target)
        self.use_inputs(facts)
        for part in within(statement.value):
            match part:
                case Call(function="sign", arguments=(Prime(of=Name(id=left.name)),)):
                    message = "sign does not say the force of dry friction at rest"
                    law = f"a law that sticks too, for a force F: friction {left.name} = F"
                    self.warn(message, part, law)
        force = m.Force(left.name, left.index, left.range, value, statement.span)
        self.parts["forces"].append(force)

    def _load(self, statement: st.Force, place: Expr, velocity: Expr) -> None:
        """Checks a force or torque, which does work at the rate dot(force, velocity)."""
        left, keyword = statement.left, statement.keyword
        scope, members = Scope(PLACES["force"]), None
        if left is not None:
            scope, members = self.left_scope(left, "force")
        before = self.report.count
        velocity, moved = self.checked(velocity, scope)
        if moved.known and not moved.vector:
            message = f"a force acts at a point, a vector; {self.text(place)} is a number"
            self.error(message, place, "write [x, y, z], or a force along a coordinate")
        elif moved.known and not moved.rates:
            does = "turn" if keyword == "torque" else "move"
            self.warn(f"{self.text(place)} does not {does}: this {keyword} does nothing", place)
        per = moved.dimension
        over = None if per is None else units.over(self.power_dimension, per)
        at = "on" if keyword == "torque" else "at"
        needs = f"the {keyword} {at} {self.text(place)} is a vector of"
        target = Target(over, f"{needs} {_NEEDED.get(over, si_text(over or NONE))}")
        value, facts = self.wanted_vector(statement.value, scope, target)
        self.use_inputs(joined(None, True, [facts, moved]))
        if statement.place is not None and left is not None:
            power = Call("dot", (value, velocity), statement.span)
            self._name(left, power, [facts, moved], members)
        if self.report.count == before:
            index, range_ = (None, None) if left is None else (left.index, left.range)
            name = left.name if left is not None and statement.place is not None else ""
            load = m.Load(name, index, range_, value, statement.span, velocity)
            self.parts["loads"].append(load)

    def noise(self, statement: st.Force) -> None:
        """Checks a noise: of a random force along a coordinate, or of three at a point."""
        left, place, before = statement.left, statement.place, self.report.count
        entry = None if left is None else self.names.table.get(left.name)
        if place is None and entry is not None and entry.kind in _POINTS:
            place = _named(left)
        scope, velocity, of = Scope(PLACES["noise"]), None, self.energy_dimension
        if place is None:
            found = self.wanted_of(left, statement.value, "a noise", ("coordinate",), "noise")
            if found is None:
                return
            entry, scope = found
            per = entry.facts.dimension
        else:
            if left is not None:
                scope, _ = self.left_scope(left, "noise")
            velocity = Prime(place, place.span)
            velocity, moved = self.checked(velocity, replace(scope, place=PLACES["force"]))
            if moved.known and not moved.vector:
                message = f"a noise acts at a point, a vector; {self.text(place)} is a number"
                self.error(message, place, "write noise COORDINATE = S")
            elif moved.known and not moved.rates:
                self.error(f"{self.text(place)} does not move: it has no inertia", place)
            elif moved.states or moved.inputs or moved.accelerations:
                self.error("a noise acts at a point of coordinates, parameters and t", place)
            per, of = moved.dimension, self.power_dimension
        squared = None
        if per is not None:
            squared = units.times(units.power(units.over(of, per), 2), self.time_dimension)
        label = self.text(place) if left is None else left.name
        needs = "a vector of intensities" if place is not None else "an intensity"
        text = f"the noise on {label} needs {needs} [{si_text(squared or NONE)}]"
        check = self.wanted if place is None else self.wanted_vector
        value, facts = check(statement.value, scope, Target(squared, text))
        if facts.value is not None and facts.value < 0:
            self.error("the intensity of a noise is at least 0", statement.value)
        if facts.rates or facts.states or facts.inputs:
            message = "the intensity of a noise has a rate, a state or an input in it"
            self.error(message, statement.value, "it is of coordinates, parameters and t")
        if self.report.count == before:
            index, range_ = (None, None) if left is None else (left.index, left.range)
            name = "" if place is not None else left.name
            made = m.Noise(name, index, range_, value, statement.span, velocity, label)
            self.parts["noises"].append(made)

    def _name(
        self, left: st.Left, power: Expr, parts: list[Facts], members: Members | None
    ) -> None:
        """Declares the name of a force, so that power(NAME) is known."""
        part = self.source.piece(left.span.start).part
        if left.index is not None or "." in left.name.removeprefix(part):
            message = "a force is named by NAME or NAME[i = lo..hi]"
            self.error(message, left, f"force {left.name} at P = …")
        facts = joined(self.power_dimension, False, parts)
        new = Entry(left.name, "force", facts, name_span(left), members, used=True)
        if self.names.declare(new):
            self.powers[left.name] = power, left.range


def _named(left: st.Left) -> Name:
    """Returns the name on a statement's left side; a range gives its variable as the index."""
    index = left.index
    if left.range is not None:
        index = Name(left.range.variable, None, left.range.span)
    return Name(left.name, index, left.span)
