"""What every part of the check of expressions shares: the model's names and what is reported."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ...source import Source, Span
from ...tree import Expr
from .. import units
from ..units import NONE, UnitError
from . import values
from .indices import Indices
from .mismatch import Mismatch
from .names import Facts, Names, Report
from .scope import Scope

Checked = tuple[Expr, Facts]


class Checking:
    """`Expressions` has the table of what `check` and `factor` do."""

    def __init__(
        self,
        source: Source,
        report: Report,
        names: Names,
        sizes: dict[str, int],
        dimensionless: bool,
    ) -> None:
        self.source, self.report, self.names, self.sizes = source, report, names, sizes
        self.time_dimension = NONE if dimensionless else units.TIME
        self.energy_dimension = NONE if dimensionless else units.ENERGY
        self.power_dimension = NONE if dimensionless else units.POWER
        self.indices = Indices(source, report, names, sizes)
        self.mismatch = Mismatch(source, report, names)

    def check(self, expr: Expr, scope: Scope) -> Checked:
        raise NotImplementedError

    def factor(self, expr: Expr, scope: Scope) -> Checked:
        raise NotImplementedError

    def constant(self, expr: Expr, compute: Callable[[], Fraction | float]):
        try:
            return compute()
        except values.NoValue as error:
            self.report.error(str(error), expr.span)
            return None

    def unit(self, text: str, span: Span) -> units.Unit | None:
        """Reads a unit; `span` includes its brackets."""
        try:
            return units.parse_unit(text)
        except UnitError as error:
            start = span.start + 1 + error.start
            help = error.help
            if self.indices.is_index(text):
                help = "an index touches the name before it, without a space: q[i]"
            self.report.error(
                error.message, Span(start, max(start + 1, span.start + 1 + error.end)), help
            )
            return None

    @staticmethod
    def parsed(text: str) -> units.Unit | None:
        """A unit that was reported already if it is wrong."""
        try:
            return units.parse_unit(text)
        except UnitError:
            return None
