"""Functions, sums, vectors and units: the part of `check/expr.py` that has brackets."""

from __future__ import annotations

import math
from dataclasses import replace
from difflib import get_close_matches
from fractions import Fraction

from ...functions import FUNCTIONS, VECTOR_FUNCTIONS, WRITTEN_OUT
from ...source import Span
from ...tree import Call, Expr, Multiply, Name, Number, Quantity, Sum, Vector
from .. import units
from ..units import NONE, Dimension
from . import values
from .checking import Checked, Checking
from .names import ROTATIONS, SPECIAL, UNKNOWN, Facts, callable_names, joined
from .rotations import RotationCalls
from .scope import PLACES, Scope


class Calls:
    """`x` checks the expressions within."""

    def __init__(self, x: Checking) -> None:
        self.x = x
        self.report, self.names = x.report, x.names
        self.indices, self.mismatch = x.indices, x.mismatch
        self.rotations = RotationCalls(x)

    def call(self, expr: Call, scope: Scope) -> Checked:
        function = expr.function
        if function in ("drift", "time") and scope.place is PLACES["expect"]:
            return self._of_run(expr)
        if function in ROTATIONS:  # whose arguments may be rotations
            return self.rotations.call(
                expr, [self.x.factor(argument, scope) for argument in expr.arguments]
            )
        if len(expr.arguments) == WRITTEN_OUT.get(function):
            return self.call(_written_out(expr), scope)
        parts = [self.x.check(argument, scope) for argument in expr.arguments]
        facts = [f for _, f in parts]
        if function not in callable_names():
            self._not_callable(expr)
            return expr, UNKNOWN
        arity = (VECTOR_FUNCTIONS | WRITTEN_OUT).get(function) or FUNCTIONS[function].arity
        if len(parts) != arity:
            count = "one argument" if arity == 1 else f"{arity} arguments"
            self.report.error(f"{function} takes {count}, not {len(parts)}", expr.span)
            return expr, UNKNOWN
        new = Call(function, tuple(e for e, _ in parts), expr.span)
        if function in VECTOR_FUNCTIONS:
            return new, self._vector_call(expr, facts)
        return new, self._scalar_call(expr, facts)

    def _of_run(self, expr: Call) -> Checked:
        """drift(X), time(EVENT): of a whole run, which an expectation compares."""
        if len(expr.arguments) != 1:
            self.report.error(f"{expr.function} takes one argument", expr.span)
            return expr, UNKNOWN
        (argument,) = expr.arguments
        if expr.function == "time":
            return expr, self._time_of(argument)
        new, facts = self.x.check(argument, Scope(PLACES["record"]))
        if facts.vector:
            self.report.error("the drift of a vector: take a component (.x, .y, .z)", argument.span)
        elif facts.known and not facts.moves:
            self.report.error(
                f"{self.mismatch.text(argument)} does not move: it has no drift", argument.span
            )
        elif facts.known:
            return replace(expr, arguments=(new,)), Facts(NONE)
        return expr, UNKNOWN

    def _time_of(self, argument: Expr) -> Facts:
        name = argument.id if isinstance(argument, Name) else ""
        entry = self.names.table.get(name)
        events = [n for n, e in self.names.table.items() if e.kind == "event"]
        if entry is not None and entry.kind == "event":
            return Facts(self.x.time_dimension)
        if entry is None or entry.kind != "poisoned":
            near = get_close_matches(name, events, 1, 0.6)
            help = f"the events are: {', '.join(events)}" if events else "declare it by 'event'"
            self.report.error(
                "time(…) takes an event: when it first happens",
                argument.span,
                f"did you mean '{near[0]}'?" if near else help,
            )
        return UNKNOWN

    def _not_callable(self, expr: Call) -> None:
        if expr.function in SPECIAL - {"sum"}:
            self.report.error(f"{expr.function}(…) has no meaning here", expr.span)
        elif expr.function in self.names.table and self.names.table[expr.function].kind == (
            "poisoned"
        ):
            return
        else:
            start = expr.span.start
            word = self.x.source.text[start : expr.span.end].partition("(")[0].rstrip()
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
            result.value = self.x.constant(
                expr, lambda: values.called(expr.function, [f.value for f in facts])
            )
        return result

    def sum(self, expr: Sum, scope: Scope) -> Checked:
        inner = self.indices.enter(expr.ranges, scope)
        if inner is None:
            return expr, UNKNOWN
        body, facts = self.x.check(expr.body, inner)
        return Sum(body, expr.ranges, expr.span), replace(facts, value=None)

    def vector(self, expr: Vector, scope: Scope) -> Checked:
        parts = [self.x.check(item, scope) for item in expr.items]
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

    def quantity(self, expr: Quantity, scope: Scope) -> Checked:
        of, facts = self.x.check(expr.of, scope)
        unit = self.x.unit(expr.unit, expr.unit_span)
        if unit is None:
            return of, replace(facts, dimension=None, value=None)
        # A pure number becomes a quantity, 0.3*sin(theta) [m] as much as 0.3 [m]; but an angle
        # that is declared in radians is not turned into degrees by saying so.
        pure = facts.dimension == NONE and (unit.dimension != NONE or not facts.united)
        if facts.dimension is None or pure:
            value = facts.value
            if value is not None and not unit.is_si:
                factor = unit.factor if not unit.pi else float(unit.factor) * math.pi**unit.pi
                value = self.x.constant(expr, lambda: values.multiplied([value, factor], (1, 1)))
            scaled = replace(facts, dimension=unit.dimension, value=value, bare=False, united=True)
            return _scaled(of, unit, expr.span), scaled
        if facts.dimension != unit.dimension:
            self.mismatch.unit(expr, facts, unit.dimension)
            return of, replace(facts, dimension=None)
        if not unit.is_si:
            si = units.si_text(unit.dimension, unit.angle) or "1"
            self.report.warn(
                f"{self.mismatch.text(expr.of)} has a unit already; [{expr.unit}] is only checked",
                expr.unit_span,
                f"values are in SI: [{si}]",
            )
        return of, facts


def _written_out(expr: Call) -> Call:
    x, *ends = expr.arguments
    if not ends:
        return replace(expr, function="log")
    return Call("min", (Call("max", (x, ends[0]), expr.span), ends[1]), expr.span)


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
