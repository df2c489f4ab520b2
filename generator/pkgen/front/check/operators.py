"""Primes, components, signs, sums, products and powers: the part of `check/expr.py` that has
operators.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ... import limits
from ...tree import AXES, COMPONENTS, Add, Component, Expr, Multiply, Name, Negate, Power, Prime
from .. import units
from ..units import NONE, Dimension
from . import values
from .checking import Checked, Checking
from .names import NO_INPUTS, UNKNOWN, Facts, joined
from .scope import Scope
from .vectors import component, turned, turns_of


class Operators:
    """`x` checks the operands."""

    def __init__(self, x: Checking) -> None:
        self.x, self.time_dimension = x, x.time_dimension
        self.report, self.indices, self.mismatch = x.report, x.indices, x.mismatch

    def prime(self, expr: Prime, scope: Scope) -> Checked:
        of, facts = self.x.check(expr.of, scope)
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
        if facts.accelerations:
            self.report.error(
                f"{text} is the rate of an acceleration: outputs use accelerations", expr.span
            )
            return expr, UNKNOWN
        solved = scope.place.accelerations
        if facts.state_rates and not facts.rates and not solved:
            self.report.error(
                f"{text}: the rate of '{min(facts.state_rates)}' has no symbol for its own rate",
                expr.span,
                "give what stands after 'rate' a name by 'let', and take that one's rate",
            )
            return expr, UNKNOWN
        if facts.rates and not solved:
            what = "an acceleration" if isinstance(expr.of, Prime) else "the rate of a rate"
            self.report.error(
                f"{text} is {what}: expressions use coordinates and their rates",
                expr.span,
                "pkgen derives the accelerations itself; write the energies in q and q'"
                " (observe, conserve, event, record and expect may use accelerations)",
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
            state_rates=facts.states,
            inputs=inputs or NO_INPUTS,
            accelerations=bool(facts.rates or facts.state_rates),
        )
        return Prime(of, expr.span), derived

    def component(self, expr: Component, scope: Scope) -> Checked:
        of, facts = self.x.factor(expr.of, scope)
        if facts.turns:
            return self._of_rotation(expr, facts)
        if facts.vector is False:
            self.report.error(
                f"{self.mismatch.text(expr.of)} is a number: it has no components", expr.span
            )
            return expr, UNKNOWN
        if expr.axis >= len(AXES) and facts.known:
            self.report.error(
                f"{self.mismatch.text(expr.of)} is a vector: it has .x, .y and .z", expr.span
            )
            return expr, UNKNOWN
        return component(of, expr.axis), replace(facts, vector=False, value=None)

    def _of_rotation(self, expr: Component, facts: Facts) -> Checked:
        """R.w, R.x, R.y, R.z: the quaternion of a rotation that is declared."""
        name = facts.turns[0].name if len(facts.turns) == 1 else ""
        if not name:
            self.report.error(
                f"{self.mismatch.text(expr.of)} is a rotation, which turns a vector",
                expr.of.span,
                "of a declared one R there is the quaternion R.w, R.x, R.y, R.z",
            )
            return expr, UNKNOWN
        new = Name(f"{name}.{COMPONENTS[expr.axis]}", None, expr.span)
        return new, replace(facts, vector=False, turns=(), united=True)

    def negate(self, expr: Negate, scope: Scope) -> Checked:
        return self.negated(expr, *self.x.check(expr.of, scope))

    def negated(self, expr: Negate, of: Expr, facts: Facts) -> Checked:
        value = None if facts.value is None else -facts.value
        return Negate(of, expr.span), replace(facts, value=value)

    def add(self, expr: Add, scope: Scope) -> Checked:
        parts = [self.x.check(term, scope) for term in expr.terms]
        dimension = self.mismatch.common(expr.terms, [f for _, f in parts])
        return self.summed(expr, parts, dimension)

    def summed(self, expr: Add, parts: list[Checked], dimension: Dimension | None) -> Checked:
        facts = [f for _, f in parts]
        vector = self._same_rank(expr, facts)
        result = joined(dimension, vector, facts)
        if all(f.value is not None for f in facts):
            result.value = self.x.constant(
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

    def multiply(self, expr: Multiply, scope: Scope) -> Checked:
        parts = [self.x.factor(factor, scope) for factor in expr.factors]
        facts = [f for _, f in parts]
        product: Expr | None = Multiply(tuple(e for e, _ in parts), expr.exponents, expr.span)
        if any(f.turns for f in facts):
            try:
                product = turned(expr, [e for e, _ in parts], facts, self.report)
            except ValueError:
                return expr, UNKNOWN
            if product is None:
                return expr, replace(joined(NONE, True, facts), turns=turns_of(facts))
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
            result.value = self.x.constant(
                expr, lambda: values.multiplied([f.value for f in facts], expr.exponents)
            )
        return product, result

    def _product_rank(self, expr: Multiply, facts: list[Facts]) -> bool | None:
        vectors = [i for i, f in enumerate(facts) if f.vector and not f.turns]
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

    def power(self, expr: Power, scope: Scope) -> Checked:
        base, facts = self.x.check(expr.base, scope)
        exponent, up = self.x.check(expr.exponent, scope)
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
            result.value = self.x.constant(expr, lambda: values.raised(facts.value, up.value))
        if up.value is None and up.known and up.bare:
            self.indices.exponent(expr.exponent, scope)
        return new, result
