"""Expressions: every name known, every unit consistent, every `[unit]` folded in.

`Expressions.check` hands back the expression in SI and its Facts. An error leaves facts that
fit anything, so that one mistake is reported once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from . import check_values as values
from . import limits, units
from .check_indices import Indices
from .check_mismatch import Mismatch
from .check_names import (
    BUILT_IN,
    CALLABLE,
    KIND_TEXT,
    NO_INPUTS,
    SPECIAL,
    UNKNOWN,
    Entry,
    Facts,
    Names,
    Report,
    joined,
)
from .check_scope import Place, Scope
from .functions import FUNCTIONS, VECTOR_FUNCTIONS
from .source import Source, Span
from .tree import (
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
        self._visit: dict[type, Callable[[Expr, Scope], Checked]] = {
            Number: self._number,
            Name: self._name,
            Prime: self._prime,
            Component: self._component,
            Negate: self._negate,
            Add: self._add,
            Multiply: self._multiply,
            Power: self._power,
            Call: self._call,
            Sum: self._sum,
            Vector: self._vector,
            Quantity: self._quantity,
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
        if of is not None:
            momentum = units.over(
                units.times(self.energy_dimension, self.time_dimension), of.facts.dimension
            )
            facts = replace(facts, dimension=momentum)
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
            result.value = self._constant(
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
            result.value = self._constant(
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
            result.value = self._constant(expr, lambda: values.raised(facts.value, up.value))
        if up.value is None and up.known and up.bare:
            self.indices.exponent(expr.exponent, scope)
        return new, result

    def _constant(self, expr: Expr, compute: Callable[[], Fraction | float]):
        try:
            return compute()
        except values.NoValue as error:
            self.report.error(str(error), expr.span)
            return None

    # functions, sums, vectors, units

    def _call(self, expr: Call, scope: Scope) -> Checked:
        function = expr.function
        parts = [self.check(argument, scope) for argument in expr.arguments]
        facts = [f for _, f in parts]
        if function not in CALLABLE:
            self._not_callable(expr)
            return expr, UNKNOWN
        arity = VECTOR_FUNCTIONS.get(function) or FUNCTIONS[function].arity
        if len(parts) != arity:
            count = "one argument" if arity == 1 else f"{arity} arguments"
            self.report.error(f"{function} takes {count}, not {len(parts)}", expr.span)
            return expr, UNKNOWN
        new = Call(function, tuple(e for e, _ in parts), expr.span)
        if function in VECTOR_FUNCTIONS:
            return new, self._vector_call(expr, facts)
        return new, self._scalar_call(expr, facts)

    def _not_callable(self, expr: Call) -> None:
        if expr.function in SPECIAL - {"sum"}:
            self.report.error(f"{expr.function}(…) has no meaning here", expr.span)
        elif expr.function in self.names.table and self.names.table[expr.function].kind == (
            "poisoned"
        ):
            return
        else:
            start = expr.span.start
            word = self.source.text[start : expr.span.end].partition("(")[0].rstrip()
            self.names.unknown(expr.function, Span(start, start + len(word)), called=True)

    def _vector_call(self, expr: Call, facts: list[Facts]) -> Facts:
        for argument, part in zip(expr.arguments, facts, strict=True):
            if part.vector is False:
                help = "the magnitude of a number is abs(x)" if expr.function == "norm" else ""
                self.report.error(
                    f"{expr.function} needs a vector, {self.mismatch.text(argument)} is a number",
                    argument.span,
                    help,
                )
                return UNKNOWN
        dims = [f.dimension for f in facts]
        result = joined(None, expr.function == "cross", facts)
        if expr.function == "norm":
            result.dimension = dims[0]
        elif None not in dims:
            result.dimension = units.times(*dims)
        return result

    def _scalar_call(self, expr: Call, facts: list[Facts]) -> Facts:
        function = FUNCTIONS[expr.function]
        for argument, part in zip(expr.arguments, facts, strict=True):
            if part.vector:
                help = "the magnitude of a vector is norm(v)" if expr.function == "abs" else ""
                self.report.error(
                    f"{expr.function} needs a number, {self.mismatch.text(argument)} is a vector",
                    argument.span,
                    help,
                )
                return UNKNOWN
        dimension: Dimension | None = NONE
        if function.units == "none":
            for argument, part in zip(expr.arguments, facts, strict=True):
                if part.dimension not in (None, NONE):
                    self.mismatch.argument(expr.function, argument, part)
        else:
            shared = self.mismatch.common(expr.arguments, facts, expr.function)
            if function.units == "same":
                dimension = shared
            elif function.units == "root" and shared is not None:
                dimension = units.power(shared, Fraction(1, 2))
        result = joined(dimension, False, facts)
        if not function.smooth and result.moves and not result.rough:
            result.rough = expr.function
        if all(f.value is not None for f in facts):
            result.value = self._constant(
                expr, lambda: values.called(expr.function, [f.value for f in facts])
            )
        return result

    def _sum(self, expr: Sum, scope: Scope) -> Checked:
        inner = self.indices.enter(expr.ranges, scope)
        if inner is None:
            return expr, UNKNOWN
        body, facts = self.check(expr.body, inner)
        return Sum(body, expr.ranges, expr.span), replace(facts, value=None)

    def _vector(self, expr: Vector, scope: Scope) -> Checked:
        parts = [self.check(item, scope) for item in expr.items]
        facts = [f for _, f in parts]
        if len(parts) != 3:
            self.report.error(
                f"a vector has three components, this has {len(parts)}",
                expr.span,
                "in a plane write [x, y, 0]",
            )
            return expr, UNKNOWN
        for item, part in zip(expr.items, facts, strict=True):
            if part.vector:
                self.report.error("a component of a vector is a number", item.span)
                return expr, UNKNOWN
        dimension = self.mismatch.common(expr.items, facts, "a vector")
        return Vector(tuple(e for e, _ in parts), expr.span), joined(dimension, True, facts)

    def _quantity(self, expr: Quantity, scope: Scope) -> Checked:
        of, facts = self.check(expr.of, scope)
        unit = self.unit(expr.unit, expr.unit_span)
        if unit is None:
            return of, replace(facts, dimension=None, value=None)
        if facts.dimension is None or (facts.dimension == NONE and not facts.united):
            value = facts.value
            if value is not None and not unit.is_si:
                factor = unit.factor if not unit.pi else float(unit.factor) * math.pi**unit.pi
                value = self._constant(expr, lambda: values.multiplied([value, factor], (1, 1)))
            scaled = replace(facts, dimension=unit.dimension, value=value, bare=False, united=True)
            return _scaled(of, unit, expr.span), scaled
        if facts.dimension != unit.dimension:
            self.mismatch.unit(expr, facts, unit.dimension)
            return of, replace(facts, dimension=unit.dimension)
        if not unit.is_si:
            si = units.si_text(unit.dimension, unit.angle) or "1"
            self.report.warn(
                f"{self.mismatch.text(expr.of)} has a unit already; [{expr.unit}] is only checked",
                expr.unit_span,
                f"values are in SI: [{si}]",
            )
        return of, facts

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


def _scaled(of: Expr, unit: units.Unit, span: Span) -> Expr:
    """`of` times the unit's factor."""
    if unit.is_si:
        return of
    if isinstance(of, Number) and not unit.pi:
        return Number(of.value * unit.factor, span)
    factors: list[Expr] = [Number(unit.factor, span), of]
    exponents = [1, 1]
    for _ in range(abs(unit.pi)):
        factors.append(Name("pi", None, span))
        exponents.append(1 if unit.pi > 0 else -1)
    return Multiply(tuple(factors), tuple(exponents), span)
