"""Reports mismatches of units, with hints."""

from __future__ import annotations

from collections import Counter

from ...tree import Add, Expr, Name, Quantity, within
from .. import units
from ..units import NONE, Dimension, described, si_text
from .names import Entry, Facts, Reporting

_LONGEST = 40
_NUMBERS = ("parameter", "constant")
_FACTORS = (*_NUMBERS, "coordinate", "state", "definition")
_HEIGHTS = ("y", "z", "h", "x")


class Mismatch(Reporting):
    def text(self, expr: Expr) -> str:
        """Returns the expression as written, shortened if it is long."""
        text = " ".join(self.source.text[expr.span.start : expr.span.end].split())
        return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"

    def against(
        self, expr: Expr, facts: Facts, needed: Dimension, needs: str, numbers: bool
    ) -> None:
        """Reports an expression, or a term of a sum, that lacks the `needed` dimension. `numbers`
        means that the value cannot depend on the motion, so that hints suggest no coordinates or
        rates."""
        message = f"unit mismatch: {self.text(expr)} is {described(facts.dimension)}, {needs}"
        self.error(message, expr, self._hint(expr, facts, needed, needs, numbers))

    def common(
        self,
        parts: tuple[Expr, ...],
        facts: list[Facts],
        where: str = "a sum",
        numbers: bool = False,
    ) -> Dimension | None:
        """Returns the dimension that most of the parts of an expression have, and reports the parts
        that have a different dimension."""
        dims = [f.dimension for f in facts if f.dimension is not None]
        if not dims:
            return None
        first = dims[0]
        if all(d == first for d in dims):
            return first
        shared = Counter(dims).most_common(1)[0][0]
        reference = next(p for p, f in zip(parts, facts, strict=True) if f.dimension == shared)
        for part, fact in zip(parts, facts, strict=True):
            if fact.dimension not in (None, shared):
                self.error(
                    f"unit mismatch in {where}: {self.text(part)} is {described(fact.dimension)},"
                    f" {self.text(reference)} is {described(shared)}",
                    part,
                    self._hint(part, fact, shared, "", numbers, within=True),
                )
        return shared

    def not_pure(self, function: str, expr: Expr, facts: Facts) -> None:
        self.error(
            f"unit mismatch: {function} needs a pure number,"
            f" {self.text(expr)} is {described(facts.dimension)}",
            expr,
            self._hint(expr, facts, NONE, "", False),
        )

    def other_unit(self, expr: Quantity, facts: Facts, declared: Dimension) -> None:
        self.error(
            f"unit mismatch: {self.text(expr.of)} is {described(facts.dimension)},"
            f" [{expr.unit}] says {described(declared)}",
            expr,
            self._hint(expr.of, facts, declared, "", False),
        )

    def _hint(
        self,
        expr: Expr,
        facts: Facts,
        needed: Dimension,
        needs: str,
        numbers: bool,
        within: bool = False,
    ) -> str:
        """Returns a hint on how to get the `needed` dimension. `within` means that the expression
        is part of another one, so that with a unit it must be written in parentheses."""
        if self.report.full:
            return ""
        text = self.text(expr)
        if isinstance(expr, Quantity) or (facts.bare and needed == NONE):
            return ""
        if facts.bare:
            given = f"{text} [{si_text(needed)}]"
            how = f", in brackets: ({given})" if within else f": {given}"
            return f"give it a unit{how}"
        factor = units.over(needed, facts.dimension)
        under = units.over(NONE, factor)
        shown = f"({text})" if isinstance(expr, Add) else text
        for ratio, verb, sign in ((factor, "multiply", "*"), (under, "divide", "/")):
            name = self._fitting(ratio, expr, needs, numbers)
            if name is not None:
                what = units.KINDS.get(ratio, f"something in [{si_text(ratio)}]")
                if ratio == units.LENGTH and "potential" in needs and verb == "multiply":
                    what = "a height"
                return f"{verb} by {what}, e.g. {shown}{sign}{name}"
        for entry in filter(None, map(self.names.table.get, _names(expr))):
            if entry.kind == "parameter" and not entry.facts.united:
                help = f"'{entry.name}' is declared without a unit"
                return f"{help}; a pure number unless it says [unit]"
        kind = units.KINDS.get(factor)
        if numbers and facts.dimension == NONE:
            return f"give it its unit: (1 [{si_text(factor)}])*{shown}"
        return f"{kind} [{si_text(factor)}] is missing as a factor" if kind else ""

    def _fitting(self, ratio: Dimension, expr: Expr, needs: str, numbers: bool) -> str | None:
        """Returns a name of dimension `ratio` that may be missing in `expr` as a factor. A name
        with the same digit at its end as a name in `expr` is preferred, such as m2 for x2."""
        if ratio == NONE:
            return None
        own = _names(expr)
        digits = {name.rstrip("0123456789") != name and name[-1] for name in own} - {False}
        fitting = [
            e
            for e in self.names.table.values()
            if e.kind in (_NUMBERS if numbers else _FACTORS)
            and e.facts.dimension == ratio
            and e.facts.vector is False
            and e.facts.known
            and e.members is None
            and not (isinstance(expr, Name) and expr.id == e.name)
        ]
        potential = "potential" in needs

        def liking(entry: Entry) -> tuple:
            moving = bool(entry.facts.coordinates) and not entry.facts.rates
            height = entry.name[0] in _HEIGHTS and moving
            order = _HEIGHTS.index(entry.name[0]) if height else len(_HEIGHTS)
            near = any(entry.name.endswith(d) for d in digits)
            # A factor missing in a potential may be a height, which is a coordinate. Any other
            # missing factor is probably a parameter.
            return (moving != potential, not near, order if potential else 0)

        best = min(fitting, key=liking, default=None)
        if best is not None:
            return best.name
        rates = () if numbers else own
        return next((f"{n}'" for n in rates if self._rate_dimension(n) == ratio), None)

    def _rate_dimension(self, name: str) -> Dimension | None:
        entry = self.names.table.get(name)
        if entry is None or entry.kind != "coordinate" or entry.facts.dimension is None:
            return None
        return units.over(entry.facts.dimension, units.TIME)


def _names(expr: Expr) -> list[str]:
    """Returns the names in an expression, in the order of the text."""
    places = {part.span.start: part.id for part in within(expr) if isinstance(part, Name)}
    return [places[start] for start in sorted(places)]
