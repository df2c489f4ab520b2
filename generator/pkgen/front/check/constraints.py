"""Checks `constraint NAME: A = B` and `rolling NAME: A = B`.

An equation of vectors is three scalar equations. Each scalar equation has a multiplier lambda,
which a model uses under the name lambda_NAME. The generalized force along a coordinate q is
lambda d(A-B)/dq for a constraint, and lambda d(A-B)/dq' for a rolling. So the unit of lambda is
that of an energy (for a rolling, of a power) divided by the unit of A.
"""

from __future__ import annotations

from dataclasses import replace

from ... import model as m
from ...indices import multipliers
from ...source import Span
from ...tree import AXES, Add, Expr
from .. import statements as st
from .. import units
from ..table import STATEMENTS
from ..units import Dimension, si_text
from .names import UNKNOWN, Entry, Facts
from .shared import Checks, name_span
from .vectors import component, component_name


class Constraints(Checks):
    """Makes a `m.Constraint` of each statement, three for a vector equation. Declares NAME and its
    multipliers, which outputs and events may use."""

    def equation(self, statement: st.Equation) -> None:
        """Checks an equation; reports sides of different rank or unit, and quantities that are not
        allowed. After an error it only declares the names."""
        left = statement.left
        scope, members = self.left_scope(left, "constraint")
        before = self.report.count
        sides = (statement.a, statement.b)
        difference = Add(sides, (1, -1), statement.a.span.to(statement.b.span))
        parts = [self.checked(side, scope) for side in sides]
        self._alike(sides, [facts.vector for _, facts in parts])
        if self.report.count > before:
            parts = [(side, UNKNOWN) for side, _ in parts]
        where = f"'{statement.keyword}'"
        dimension = self.common(sides, [f for _, f in parts], where, numbers=True)
        value, facts = self.expressions.summed(difference, parts, dimension)
        if facts.known and self.report.count == before:
            self._moves(statement, facts, difference.span)
        self.use_inputs(facts)
        multiplier = self._multiplier(statement.keyword, dimension)
        multiplier.vector = facts.vector
        place = name_span(left)
        if self.names.declare(Entry(left.name, "constraint", facts, place, members)):
            for name in multipliers(left.name):
                self.names.declare(Entry(name, "multiplier", multiplier, place, members))
        if self.report.count > before or not facts.known:
            return
        holonomic, unit = statement.keyword == "constraint", si_text(multiplier.dimension)
        self.parts["constraints"] += [
            m.Constraint(name, left.index, left.range, holonomic, one, unit, "", statement.span)
            for name, one in self._rows(left.name, value, bool(facts.vector))
        ]

    def _alike(self, sides: tuple[Expr, Expr], vectors: list[bool | None]) -> None:
        if True in vectors and False in vectors:
            vector, number = sides if vectors[0] else reversed(sides)
            message = f"{self.text(vector)} is a vector; "
            message += f"the other side, {self.text(number)}, is a number"
            help = "write a vector on both sides, or take a component (.x, .y, .z) or norm(v)"
            self.error(message, number, help)

    @staticmethod
    def _rows(name: str, difference: Add, vector: bool) -> list[tuple[str, Expr]]:
        """Returns (name, A - B) for each scalar equation: one for numbers, three for vectors."""
        if not vector:
            return [(name, difference)]
        rows = (tuple(component(x, k) for x in difference.terms) for k in range(len(AXES)))
        parts = (replace(difference, terms=row) for row in rows)
        return [(component_name(name, k), part) for k, part in enumerate(parts)]

    def _moves(self, statement: st.Equation, facts: Facts, span: Span) -> None:
        keyword = statement.keyword
        if facts.states or facts.state_rates:
            message = f"a {keyword} cannot use the state '{min(facts.states | facts.state_rates)}'"
            help = "it is an equation between coordinates, rotations, parameters, inputs and t"
            self.error(message, span, help)
        elif keyword == "constraint" and facts.rates:
            message = "a constraint is an equation between positions; this one has rates in it"
            help = f"write 'rolling {statement.left.name}: …' for an equation between rates"
            self.error(message, span, help)
        elif keyword == "rolling" and not facts.rates:
            message = "a rolling is an equation between rates; there is none in it"
            help = f"write 'constraint {statement.left.name}: …' for one between positions"
            self.error(message, span, help)
        elif not facts.coordinates:
            message = f"nothing that has an equation of motion is in this {keyword}"
            self.error(message, span, "it holds or fails whatever the motion")

    def _multiplier(self, keyword: str, dimension: Dimension | None) -> Facts:
        power = STATEMENTS[keyword].needs == "power"
        work = self.power_dimension if power else self.energy_dimension
        everything = self.names.moving
        return Facts(
            None if dimension is None else units.over(work, dimension),
            united=True,
            known=dimension is not None,
            coordinates=everything,
            rates=everything,
        )
