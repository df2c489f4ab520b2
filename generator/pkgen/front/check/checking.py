"""State and helpers shared by the classes that check expressions."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ...source import Span
from ...tree import Expr
from .. import units
from ..units import NONE, UnitError
from . import values
from .indices import Indices
from .mismatch import Mismatch
from .names import Facts

Checked = tuple[Expr, Facts]


class Checking(Mismatch):
    """Base class of Operators, Calls and Quantities, which `Expressions` combines."""

    def __init__(self, *given, dimensionless: bool) -> None:
        super().__init__(*given)
        self.time_dimension = NONE if dimensionless else units.TIME
        self.energy_dimension = NONE if dimensionless else units.ENERGY
        self.power_dimension = NONE if dimensionless else units.POWER
        self.indices = Indices(*given)

    def constant(
        self, expr: Expr, facts: list[Facts], compute: Callable, *more: object
    ) -> Fraction | float | None:
        """Applies `compute` to the values of an expression's parts. Returns None if one of the
        values is unknown, or after an error."""
        if any(f.value is None for f in facts):
            return None
        try:
            return compute([f.value for f in facts], *more)
        except values.NoValue as error:
            self.error(str(error), expr)
            return None

    def unit(self, text: str, span: Span) -> units.Unit | None:
        """Parses a unit and reports errors; `span` is its position with the brackets."""
        try:
            return units.parse_unit(text)
        except UnitError as error:
            start = span.start + 1 + error.start
            help = error.help
            if self.indices.is_index(text):
                help = "an index touches the name before it, without a space: q[i]"
            self.error(error.message, Span(start, max(start + 1, span.start + 1 + error.end)), help)
            return None
