"""Checks derivatives (primes), components, signs, sums, products and powers."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ... import limits
from ...tree import AXES, COMPONENTS, Add, Component, Expr, Multiply, Name, Negate, Power, Prime
from .. import units
from ..units import NONE, Dimension
from . import values
from .checking import Checked, Checking
from .names import NO_INPUTS, Facts, Wrong, joined
from .scope import Scope
from .vectors import component, turned, turns_of


class Operators(Checking):
    def prime(self, expr: Prime, scope: Scope) -> Checked:
        of, facts = self.check(expr.of, scope)
        text = self.text(expr)
        if not scope.place.derivatives:
            help = f"it may use {scope.place.may_use}"
            raise Wrong(f"{scope.place.what} cannot use a derivative", help)
        if facts.bare and facts.known:
            raise Wrong(f"{text}: {self.text(expr.of)} is a number and has no rate")
        if facts.accelerations:
            raise Wrong(f"{text} is the rate of an acceleration: outputs use accelerations")
        solved = scope.place.accelerations
        if facts.state_rates and not facts.rates and not solved:
            raise Wrong(
                f"{text}: the rate of '{min(facts.state_rates)}' has no symbol for its own rate",
                "give what stands after 'rate' a name by 'let', and take that one's rate",
            )
        if facts.rates and not solved:
            what = "an acceleration" if isinstance(expr.of, Prime) else "the rate of a rate"
            raise Wrong(
                f"{text} is {what}: expressions use coordinates and their rates",
                "pkgen derives the accelerations itself; write the energies in q and q'"
                " (observe, conserve, event, record and expect may use accelerations)",
            )
        inputs = {name: order + 1 for name, order in facts.inputs.items()}
        if any(order > 2 for order in inputs.values()):
            raise Wrong(f"{text}: inputs have two derivatives")
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
        of, facts = self.factor(expr.of, scope)
        if facts.turns:
            return self._of_rotation(expr, facts)
        if facts.vector is False:
            raise Wrong(f"{self.text(expr.of)} is a number: it has no components")
        if expr.axis >= len(AXES) and facts.known:
            raise Wrong(f"{self.text(expr.of)} is a vector: it has .x, .y and .z")
        return component(of, expr.axis), replace(facts, vector=False, value=None)

    def _of_rotation(self, expr: Component, facts: Facts) -> Checked:
        """Checks R.w, R.x, R.y, R.z, the components of a declared rotation's quaternion."""
        turn, *more = facts.turns
        if more or not turn.name:
            message = f"{self.text(expr.of)} is a rotation, which turns a vector"
            help = "of a declared one R there is the quaternion R.w, R.x, R.y, R.z"
            raise Wrong(message, help, expr.of)
        new = Name(f"{turn.name}.{COMPONENTS[expr.axis]}", turn.index, expr.span)
        return new, replace(facts, vector=False, turns=(), united=True)

    def negate(self, expr: Negate, scope: Scope) -> Checked:
        return self.negated(expr, *self.check(expr.of, scope))

    def negated(self, expr: Negate, of: Expr, facts: Facts) -> Checked:
        value = None if facts.value is None else -facts.value
        return Negate(of, expr.span), replace(facts, value=value)

    def add(self, expr: Add, scope: Scope) -> Checked:
        terms = self.terms(expr)
        parts = [self.check(term, scope) for term in terms]
        dimension = self.common(terms, [f for _, f in parts])
        return self.summed(expr, parts, dimension)

    def summed(self, expr: Add, parts: list[Checked], dimension: Dimension | None) -> Checked:
        facts = [f for _, f in parts]
        result = joined(dimension, self._same_rank(expr, facts), facts)
        result.value = self.constant(expr, facts, values.added, expr.signs)
        return Add(tuple(e for e, _ in parts), expr.signs, expr.span), result

    def _same_rank(self, expr: Add, facts: list[Facts]) -> bool | None:
        ranks = [f.vector for f in facts if f.vector is not None]
        first = ranks[0] if ranks else None
        if not {True, False} <= set(ranks):
            return first
        odd = next(t for t, f in zip(expr.terms, facts, strict=True) if f.vector is (not first))
        this, others = ("a number", "a vector") if first else ("a vector", "a number")
        message = f"{self.text(odd)} is {this} and cannot be added to {others}"
        self.error(message, odd)
        return None

    def multiply(self, expr: Multiply, scope: Scope) -> Checked:
        parts = [self.factor(factor, scope) for factor in expr.factors]
        facts = [f for _, f in parts]
        product: Expr | None = Multiply(tuple(e for e, _ in parts), expr.exponents, expr.span)
        if any(f.turns for f in facts):
            product = turned(expr, [e for e, _ in parts], facts)
            if product is None:
                return expr, replace(joined(NONE, True, facts), turns=turns_of(facts))
        dimension: Dimension | None = NONE
        for part, exponent in zip(facts, expr.exponents, strict=True):
            if part.dimension is None or dimension is None:
                dimension = None
            elif part.dimension is not NONE:
                combine = units.times if exponent > 0 else units.over
                dimension = combine(dimension, part.dimension)
        result = joined(dimension, self._product_rank(expr, facts), facts)
        for factor, part, exponent in zip(expr.factors, facts, expr.exponents, strict=True):
            if exponent < 0 and part.value == 0:
                raise Wrong("division by zero", at=factor)
        result.value = self.constant(expr, facts, values.multiplied, expr.exponents)
        return product, result

    def _product_rank(self, expr: Multiply, facts: list[Facts]) -> bool:
        vectors = [i for i, f in enumerate(facts) if f.vector and not f.turns]
        under = next((expr.factors[i] for i in vectors if expr.exponents[i] < 0), None)
        if under is not None:
            raise Wrong(f"division by the vector {self.text(under)}", at=under)
        if len(vectors) > 1:
            a, b = (self.text(expr.factors[i]) for i in vectors[:2])
            message = f"{a} and {b} are vectors; '*' cannot multiply them"
            help = f"write dot({a}, {b}) or cross({a}, {b})"
            raise Wrong(message, help, expr.factors[vectors[1]])
        if any(f.vector is None for f in facts):
            raise Wrong
        return bool(vectors)

    def power(self, expr: Power, scope: Scope) -> Checked:
        base, facts = self.check(expr.base, scope)
        exponent, up = self.check(expr.exponent, scope)
        of, to = self.text(expr.base), self.text(expr.exponent)
        if facts.vector:
            help = f"write dot({of}, {of})"
            raise Wrong(f"{of} is a vector and has no power", help, expr.base)
        if up.vector or up.dimension not in (None, NONE):
            what = "a vector" if up.vector else units.described(up.dimension)
            message = f"an exponent is a pure number, {to} is {what}"
            raise Wrong(message, at=expr.exponent)
        result = joined(facts.dimension, False, [facts, up])
        if up.value is not None and abs(up.value) > limits.EXPONENT:
            raise Wrong(f"an exponent beyond {limits.EXPONENT}", at=expr.exponent)
        if facts.dimension not in (None, NONE):
            if isinstance(up.value, Fraction):
                result.dimension = units.power(facts.dimension, up.value)
            elif up.known:
                self.error(
                    f"unit mismatch: {of} is {units.described(facts.dimension)};"
                    f" with the exponent {to} it must be a pure number",
                    expr.base,
                    f"divide by a constant of the same unit: (x/x0)^{to}",
                )
                result.dimension = None
        result.value = self.constant(expr, [facts, up], lambda both: values.raised(*both))
        if up.value is None and up.known and up.bare:
            self.indices.exponent(expr.exponent, scope)
        return Power(base, exponent, expr.span), result
