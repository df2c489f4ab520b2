"""Checks that a model has the statements it needs, after all statements have been checked."""

from __future__ import annotations

from ...source import Span
from .. import statements as st
from ..joints import joint_names
from ..table import STATEMENTS
from .shared import Checks, Shared

_MOVING = {"coord", "state", "rotation", "body", "joint"}
_ENERGIES = {"kinetic", "lagrangian", "hamiltonian", "body", "joint"}
# What statements fill that cannot stand beside a Hamiltonian.
_NOT_BESIDE_H = ("kinetic", "potential", "lagrangian", "fast", "rotations")


class Required(Checks):
    """Checks that no statement is missing. `broken` has the keywords of statements that did not
    parse; "" stands for an unknown keyword."""

    def __init__(self, file: st.File, shared: Shared, broken: set[str]) -> None:
        super().__init__(shared)
        self.file, self.broken = file, broken

    def check(self) -> None:
        self._sizes()
        if not self.file.statements:
            if not self.file.diagnostics:  # Errors mean that no statement could be parsed.
                message = "there is no statement in this file"
                self.error(message, Span(0, 0), "begin with 'model NAME'")
            return
        broken, parts = self.broken, self.parts
        at = parts["name"][0].span if parts["name"] else self._first_line()
        if not parts["name"] and "model" not in broken:
            self.error("the model has no name", at, "the first statement is 'model NAME'")
        elif parts["name"] and self.file.statements[0] is not parts["name"][0]:
            self.error("'model' must be the first statement", at)
        if broken & {"", "use"}:  # The missing statement may be in this line or in a part.
            return
        names = self.names
        if not (names.moving or names.states or broken & _MOVING):
            self.error("the model has no coordinates", at, "e.g. coord x [m]")
        has_energy = parts["kinetic"] or parts["lagrangian"] or parts["hamiltonian"]
        if parts["hamiltonian"]:
            self._hamiltonian_alone()
        if names.states and not names.moving and not broken & {"coord", "rotation"}:
            return self._states_alone()
        bodies = any(isinstance(s, st.Body) for s in self.file.statements)  # each adds an energy
        if not (has_energy or bodies or broken & _ENERGIES):
            self.error("the model has no kinetic energy", at, "add 'kinetic …' or 'lagrangian …'")

    def _hamiltonian_alone(self) -> None:
        for statement in self.file.statements:
            row = STATEMENTS.get(statement.keyword)
            if row and (row.fills in _NOT_BESIDE_H or isinstance(statement, st.Body)):
                message = f"'{statement.keyword}' beside 'hamiltonian', which has all of the energy"
                self.error(message, statement, "write it in q and p_q, or leave H out")

    def _states_alone(self) -> None:
        """Reports energies in a model that has states but no coordinates."""
        for statement in self.file.statements:
            if isinstance(statement, st.Single):
                self.error(
                    f"'{statement.keyword}' without any coordinate: states have no inertia",
                    Span(statement.span.start, statement.span.start + len(statement.keyword)),
                    "declare a coordinate: coord q [m]; or leave the energies out",
                )

    def _first_line(self) -> Span:
        places = [s.span for s in self.file.statements] + [b.span for b in self.file.broken]
        return min(places, key=lambda s: s.start, default=Span(0, 0))

    def _sizes(self) -> None:
        known = [s.left.name for s in self.file.statements if s.keyword == "size"]
        for name in self.given_sizes:
            if name not in known and not self.file.diagnostics:
                message = f"--size {name}: the model has no size '{name}'"
                help = f"its sizes are: {', '.join(known)}" if known else "it has no sizes"
                self.error(message, self._first_line(), help)

    def inertia(self) -> None:
        """Reports coordinates whose rate occurs in no energy. Checks only models with `kinetic`: an
        L may be of first degree. The mass matrix itself is checked later, in middle/derive."""
        energies = self.energies
        if not self.parts["kinetic"] or not all(f.known for f in energies):
            return
        with_rate = frozenset().union(*(f.rates for f in energies))
        for rotation in self.parts["rotations"]:
            if rotation.name not in with_rate:
                rate = f"omega({rotation.name}{'[i]' if rotation.range else ''})"
                self.error(
                    f"the rotation '{rotation.name}' has no inertia: no energy contains its rates",
                    rotation,
                    f"add a kinetic term, e.g. kinetic I/2*dot({rate}, {rate})",
                )
        joints = (s for s in self.file.statements if isinstance(s, st.Joint))
        of_joints = {name for joint in joints for name, _ in joint_names(joint)}
        for coordinate in self.parts["coordinates"]:
            if coordinate.name not in with_rate:
                help = f"add a kinetic term, or make it a parameter: param {coordinate.name} = …"
                if coordinate.name in of_joints:
                    help = "what hangs on a joint needs a mass; what does not move hangs by 'fixed'"
                self.error(
                    f"the coordinate '{coordinate.name}' has no inertia: no energy contains"
                    f" {coordinate.name}'",
                    coordinate,
                    help,
                )
