"""Expressions: every name known, every unit consistent, every `[unit]` folded in.

`Expressions.check` hands back the expression in SI and its Facts. An error leaves facts that
fit anything, so that one mistake is reported once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from .. import limits
from ..source import Source, Span
from ..tree import (
    Add,
    Call,
    Component,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Quantity,
    Sum,
    Vector,
)
from . import check_values as values
from . import units
from .check_calls import Calls
from .check_indices import Indices
from .check_mismatch import Mismatch
from .check_names import (
    BUILT_IN,
    KIND_TEXT,
    NO_INPUTS,
    UNKNOWN,
    Entry,
    Facts,
    Names,
    Report,
    joined,
)
from .check_scope import Place, Scope
from .units import NONE, Dimension, UnitError

Checked = tuple[Expr, Facts]


@dataclass(frozen=True)
class Target:
    """What a place needs: a dimension (None takes any), in words, and whether a number without
    a unit may stand for one in SI."""

    dimension: Dimension | None
    needs: str
    bare: bool = False


class Expressions:
    def __init__(
        self,
        source: Source,
        report: Report,
        names: Names,
        sizes: dict[str, int],
        dimensionless: bool,
        lagrangian: bool,
    ) -> None:
        self.source, self.report, self.names, self.sizes = source, report, names, sizes
        self.time_dimension = NONE if dimensionless else units.TIME
        self.energy_dimension = NONE if dimensionless else units.ENERGY
        self.power_dimension = NONE if dimensionless else units.POWER
        self.lagrangian = lagrangian
        self.indices = Indices(source, report, names, sizes)
        self.mismatch = Mismatch(source, report, names)
        calls = Calls(self)
        self._visit: dict[type, Callable[[Expr, Scope], Checked]] = {
            Number: self._number,
            Name: self._name,
            Prime: self._prime,
            Component: self._component,
            Negate: self._negate,
            Add: self._add,
            Multiply: self._multiply,
            Power: self._power,
            Call: calls.call,
            Sum: calls.sum,
            Vector: calls.vector,
            Quantity: calls.quantity,
        }

    # entry points

    def check(self, expr: Expr, scope: Scope) -> Checked:
        return self._visit[type(expr)](expr, scope)

    def wanted(self, expr: Expr, scope: Scope, target: Target) -> Checked:
        """Checks an expression whose dimension is given; each term of a sum by itself."""
        if isinstance(expr, Add) and not target.bare:
            parts = [self.wanted(term, scope, target) for term in expr.terms]
            return self._summed(expr, parts, target.dimension)
        if isinstance(expr, Negate):
            of, facts = self.wanted(expr.of, scope, target)
            return self._negated(expr, of, facts)
        if isinstance(expr, Add):
            parts = [self.check(term, scope) for term in expr.terms]
            if not all(f.bare and f.dimension in (None, NONE) for _, f in parts):
                for part, (_, facts) in zip(expr.terms, parts, strict=True):
                    self._against(part, facts, replace(target, bare=False))
            return self._summed(expr, parts, target.dimension)
        new, facts = self.check(expr, scope)
        self._against(expr, facts, target)
        return new, facts

    def _against(self, expr: Expr, facts: Facts, target: Target) -> None:
        if facts.vector:
            self.report.error(
                f"{self.mismatch.text(expr)} is a vector, {target.needs}",
                expr.span,
                "take a component (.x, .y, .z), dot(a, b) or norm(a)",
            )
        elif target.dimension is None or facts.dimension in (None, target.dimension):
            return
        elif not (target.bare and facts.bare and facts.dimension == NONE):
            self.mismatch.against(expr, facts, target.dimension, target.needs, target.bare)

    # leaves

    def _number(self, expr: Number, scope: Scope) -> Checked:
        return expr, Facts(None if expr.value == 0 else NONE, False, expr.value, bare=True)

    def _name(self, expr: Name, scope: Scope) -> Checked:
        entry = self._entry(expr, scope)
        if entry is None:
            if expr.index is not None:
                self.indices.valid(expr.index, scope)
            return expr, UNKNOWN
        entry.used = True
        if entry.kind == "poisoned":
            return expr, UNKNOWN
        if entry.kind not in scope.place.kinds:
            self._forbidden(expr, entry, scope.place)
            return expr, UNKNOWN
        if not self.indices.member(expr, entry, scope):
            return expr, UNKNOWN
        return expr, entry.facts

    def _entry(self, expr: Name, scope: Scope) -> Entry | None:
        name = expr.id
        if name in scope.variables:
            return Entry(name, "loop variable", Facts(NONE, bare=True), expr.span)
        entry = self.names.table.get(name)
        if entry is not None:
            return entry
        if name == "pi":
            return Entry(name, "constant", Facts(NONE, False, math.pi, bare=True), expr.span)
        if name == "t":
            return Entry(name, "time", Facts(self.time_dimension, time=True), expr.span)
        if name == "inf":
            self._once(name, "'inf' stands only in bounds, e.g. in (0, inf)", expr.span)
            return None
        if name in BUILT_IN or (name.startswith("p_") and name[2:] in self.names.coordinates):
            return self._built_in(name, expr)
        self.names.unknown(name, expr.span)
        return None

    def _built_in(self, name: str, expr: Name) -> Entry | None:
        if name in ("T", "V") and self.lagrangian:
            self._once(
                name,
                f"'{name}' is not known in a model with 'lagrangian'",
                expr.span,
                "L and energy are; or write 'kinetic' and 'potential'",
            )
            return None
        everything = self.names.coordinates
        facts = Facts(self.energy_dimension, united=True, coordinates=everything, rates=everything)
        of = self.names.table.get(name[2:]) if name.startswith("p_") else None
        if of is not None and of.facts.dimension is None:
            facts = replace(facts, dimension=None, known=False)
        elif of is not None:
            action = units.times(self.energy_dimension, self.time_dimension)
            facts = replace(facts, dimension=units.over(action, of.facts.dimension))
        return Entry(name, "built-in", facts, expr.span, of.members if of else None)

    def _once(self, name: str, message: str, span: Span, help: str = "") -> None:
        if name not in self.names.reported:
            self.names.reported.add(name)
            self.report.error(message, span, help)

    def _forbidden(self, expr: Name, entry: Entry, place: Place) -> None:
        if entry.kind == "output":
            help = f"define {expr.id} with 'let' to use it elsewhere"
        elif entry.kind == "built-in":
            help = "it can be used in 'observe' and 'conserve'"
        else:
            help = f"{place.what} may use {place.may_use}"
        self.report.error(
            f"'{expr.id}' is {KIND_TEXT[entry.kind]}: {place.what} cannot use it", expr.span, help
        )

    # operators

    def _prime(self, expr: Prime, scope: Scope) -> Checked:
        of, facts = self.check(expr.of, scope)
        text = self.mismatch.text(expr)
        if not scope.place.derivatives:
            self.report.error(
                f"{scope.place.what} cannot use a derivative",
                expr.span,
                f"it may use {scope.place.may_use}",
            )
            return expr, UNKNOWN
        if facts.bare and facts.known:
            self.report.error(
                f"{text}: {self.mismatch.text(expr.of)} is a number and has no rate", expr.span
            )
            return expr, UNKNOWN
        if facts.rates:
            what = "an acceleration" if isinstance(expr.of, Prime) else "the rate of a rate"
            self.report.error(
                f"{text} is {what}: expressions use coordinates and their rates",
                expr.span,
                "pkgen derives the accelerations itself; write the energies in q and q'",
            )
            return expr, UNKNOWN
        inputs = {name: order + 1 for name, order in facts.inputs.items()}
        if any(order > 2 for order in inputs.values()):
            self.report.error(f"{text}: inputs have two derivatives", expr.span)
            return expr, UNKNOWN
        dim = None if facts.dimension is None else units.over(facts.dimension, self.time_dimension)
        derived = replace(
            facts,
            dimension=dim,
            value=None,
            rates=facts.coordinates,
            inputs=inputs or NO_INPUTS,
        )
        return Prime(of, expr.span), derived

    def _component(self, expr: Component, scope: Scope) -> Checked:
        of, facts = self.check(expr.of, scope)
        if facts.vector is False:
            self.report.error(
                f"{self.mismatch.text(expr.of)} is a number: it has no components", expr.span
            )
            return expr, UNKNOWN
        return Component(of, expr.axis, expr.span), replace(facts, vector=False, value=None)

    def _negate(self, expr: Negate, scope: Scope) -> Checked:
        return self._negated(expr, *self.check(expr.of, scope))

    def _negated(self, expr: Negate, of: Expr, facts: Facts) -> Checked:
        value = None if facts.value is None else -facts.value
        return Negate(of, expr.span), replace(facts, value=value)

    def _add(self, expr: Add, scope: Scope) -> Checked:
        parts = [self.check(term, scope) for term in expr.terms]
        dimension = self.mismatch.common(expr.terms, [f for _, f in parts])
        return self._summed(expr, parts, dimension)

    def _summed(self, expr: Add, parts: list[Checked], dimension: Dimension | None) -> Checked:
        facts = [f for _, f in parts]
        vector = self._same_rank(expr, facts)
        result = joined(dimension, vector, facts)
        if all(f.value is not None for f in facts):
            result.value = self.constant(
                expr, lambda: values.added([f.value for f in facts], expr.signs)
            )
        return Add(tuple(e for e, _ in parts), expr.signs, expr.span), result

    def _same_rank(self, expr: Add, facts: list[Facts]) -> bool | None:
        ranks = [f.vector for f in facts if f.vector is not None]
        if True in ranks and False in ranks:
            odd = next(
                t for t, f in zip(expr.terms, facts, strict=True) if f.vector is (not ranks[0])
            )
            first = "a vector" if ranks[0] else "a number"
            self.report.error(
                f"{self.mismatch.text(odd)} is {'a number' if ranks[0] else 'a vector'}"
                f" and cannot be added to {first}",
                odd.span,
            )
            return None
        return ranks[0] if ranks else None

    def _multiply(self, expr: Multiply, scope: Scope) -> Checked:
        parts = [self.check(factor, scope) for factor in expr.factors]
        facts = [f for _, f in parts]
        dimension: Dimension | None = NONE
        for part, exponent in zip(facts, expr.exponents, strict=True):
            if part.dimension is None or dimension is None:
                dimension = None
            elif part.dimension is not NONE:
                combine = units.times if exponent > 0 else units.over
                dimension = combine(dimension, part.dimension)
        vector = self._product_rank(expr, facts)
        if vector is None:
            return expr, UNKNOWN
        result = joined(dimension, vector, facts)
        for factor, part, exponent in zip(expr.factors, facts, expr.exponents, strict=True):
            if exponent < 0 and part.value == 0:
                self.report.error("division by zero", factor.span)
                return expr, UNKNOWN
        if all(f.value is not None for f in facts):
            result.value = self.constant(
                expr, lambda: values.multiplied([f.value for f in facts], expr.exponents)
            )
        return Multiply(tuple(e for e, _ in parts), expr.exponents, expr.span), result

    def _product_rank(self, expr: Multiply, facts: list[Facts]) -> bool | None:
        vectors = [i for i, f in enumerate(facts) if f.vector]
        under = next((i for i in vectors if expr.exponents[i] < 0), None)
        if under is not None:
            factor = expr.factors[under]
            self.report.error(f"division by the vector {self.mismatch.text(factor)}", factor.span)
            return None
        if len(vectors) > 1:
            a, b = (self.mismatch.text(expr.factors[i]) for i in vectors[:2])
            self.report.error(
                f"{a} and {b} are vectors; '*' cannot multiply them",
                expr.factors[vectors[1]].span,
                f"write dot({a}, {b}) or cross({a}, {b})",
            )
            return None
        if any(f.vector is None for f in facts):
            return None
        return bool(vectors)

    def _power(self, expr: Power, scope: Scope) -> Checked:
        base, facts = self.check(expr.base, scope)
        exponent, up = self.check(expr.exponent, scope)
        text = self.mismatch.text
        new = Power(base, exponent, expr.span)
        if facts.vector:
            b = text(expr.base)
            self.report.error(
                f"{b} is a vector and has no power", expr.base.span, f"write dot({b}, {b})"
            )
            return expr, UNKNOWN
        if up.vector or up.dimension not in (None, NONE):
            what = "a vector" if up.vector else units.described(up.dimension)
            self.report.error(
                f"an exponent is a pure number, {text(expr.exponent)} is {what}",
                expr.exponent.span,
            )
            return expr, UNKNOWN
        result = joined(facts.dimension, False, [facts, up])
        exact = up.value if isinstance(up.value, Fraction) else None
        if up.value is not None and abs(up.value) > limits.EXPONENT:
            self.report.error(f"an exponent beyond {limits.EXPONENT}", expr.exponent.span)
            return expr, UNKNOWN
        if facts.dimension not in (None, NONE):
            if exact is not None:
                result.dimension = units.power(facts.dimension, exact)
            elif up.known:
                self.report.error(
                    f"unit mismatch: {text(expr.base)} is {units.described(facts.dimension)};"
                    f" with the exponent {text(expr.exponent)} it must be a pure number",
                    expr.base.span,
                    f"divide by a constant of the same unit: (x/x0)^{text(expr.exponent)}",
                )
                result.dimension = None
        if facts.value is not None and up.value is not None:
            result.value = self.constant(expr, lambda: values.raised(facts.value, up.value))
        if up.value is None and up.known and up.bare:
            self.indices.exponent(expr.exponent, scope)
        return new, result

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
