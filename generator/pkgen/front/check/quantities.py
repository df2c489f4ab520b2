"""Decides to which expression a `[unit]` applies, and multiplies it by the unit's factor to SI.

A unit applies to the whole expression before it if this expression is a pure number or has the
dimension of the unit already (`1/2 [m]`, `l/2 [m]`). Otherwise the unit applies to the longest
sequence of numbers and constants before it (`x - 0.1 [m]`, `2 [N]*cos(w*t)`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from ...source import Span
from ...tree import Add, Call, Expr, Multiply, Name, Negate, Number, Power, Quantity, names
from .. import units
from ..units import NONE
from . import values
from .checking import Checked, Checking
from .names import Facts, Wrong
from .scope import Scope


class Quantities(Checking):
    def quantity(self, expr: Quantity, scope: Scope) -> Checked:
        unit = self.unit(expr.unit, expr.unit_span)
        if isinstance(expr.of, Add) and unit is not None:
            return self._sum(expr, unit, scope)
        of, facts = self.check(expr.of, scope)
        if unit is None:
            return of, replace(facts, dimension=None, value=None)
        return self._measured(expr, of, facts, unit)

    def terms(self, expr: Add) -> tuple[Expr, ...]:
        """Returns the terms of a sum. A unit after one term also applies to the terms directly
        before it that are plain numbers, as in `1 + 2 [m]`."""
        terms = list(expr.terms)
        for j in range(len(terms) - 1, 0, -1):
            found = terms[j]
            if isinstance(found, Quantity) and not found.whole and self._is_plain(terms[j - 1]):
                unit = found.unit, found.unit_span
                terms[j - 1] = Quantity(terms[j - 1], *unit, terms[j - 1].span, whole=False)
        return tuple(terms)

    def _sum(self, expr: Quantity, unit: units.Unit, scope: Scope) -> Checked:
        of = expr.of
        assert isinstance(of, Add)
        terms = self.terms(of)
        count = len(terms)
        while count and self._is_plain(terms[count - 1]):
            count -= 1
        parts = [self.check(term, scope) for term in terms]
        free = all(_is_pure(f, unit) for _, f in parts[:count])
        last = terms[-1]
        within = isinstance(last, Multiply) and self._is_plain(last.factors[-1])
        if count and not free and (count < len(terms) or within):
            for j in range(min(count, len(terms) - 1), len(terms)):
                one = Quantity(terms[j], expr.unit, expr.unit_span, terms[j].span)
                parts[j] = self._measured(one, *parts[j], unit)
            return self.summed(of, parts, self.common(terms, [f for _, f in parts]))
        whole = self.summed(of, parts, self.common(terms, [f for _, f in parts]))
        return self._measured(expr, *whole, unit)

    def _is_plain(self, expr: Expr) -> bool:
        """Whether an expression contains only numbers without a unit, and constants."""
        if isinstance(expr, Number):
            return True
        if isinstance(expr, Name):
            entry = self.names.table.get(expr.id)
            if entry is None:
                return expr.id == "pi"
            return entry.kind == "constant" and not entry.facts.united and expr.index is None
        if isinstance(expr, Negate):
            return self._is_plain(expr.of)
        if isinstance(expr, Power):
            return self._is_plain(expr.base) and self._is_plain(expr.exponent)
        inner = {Add: "terms", Multiply: "factors", Call: "arguments"}.get(type(expr))
        return inner is not None and all(map(self._is_plain, getattr(expr, inner)))

    def _measured(self, expr: Quantity, of: Expr, facts: Facts, unit: units.Unit) -> Checked:
        if _is_pure(facts, unit):
            value = facts.value
            if unit.pi and "pi" in names(expr.of):
                text = self.text(expr.of)
                said = f"{text} [{expr.unit}] has pi in degrees"
                self.warn(said, expr.unit_span, f"write {text} [rad], or degrees without pi")
            if not unit.is_si:
                factor = unit.factor if not unit.pi else float(unit.factor) * math.pi**unit.pi
                value = self.constant(
                    expr, [facts], lambda x: values.multiplied([*x, factor], (1, 1))
                )
            scaled = replace(facts, dimension=unit.dimension, value=value, bare=False, united=True)
            return _scaled(of, unit, expr.span), scaled
        if facts.dimension != unit.dimension:
            return self._factor(expr, of, facts, unit)
        if not unit.is_si:
            si = units.si_text(unit.dimension, unit.angle) or "1"
            message = f"{self.text(expr.of)} has a unit already; [{expr.unit}] is only checked"
            self.warn(message, expr.unit_span, f"values are in SI: [{si}]")
        return of, facts

    def _factor(self, expr: Quantity, of: Expr, facts: Facts, unit: units.Unit) -> Checked:
        """Applies the unit to the last factors of a product, which must be numbers."""
        product = expr.of
        factors = product.factors if isinstance(product, Multiply) else ()
        count = len(factors)
        while count and self._is_plain(factors[count - 1]):
            count -= 1
        if not 0 < count < len(factors):
            self.other_unit(expr, facts, unit.dimension)
            return of, replace(facts, dimension=None)
        if product.exponents[count] < 0:
            number = self.text(factors[count])
            raise Wrong(
                f"[{expr.unit}] after a division: is it the unit of {number}, or of the whole?",
                f"use brackets: …/({number} [{expr.unit}])",
                expr.unit_span,
            )
        dimension = units.times(facts.dimension, unit.dimension)
        scaled = replace(facts, dimension=dimension, value=None, bare=False, united=True)
        return _scaled(of, unit, expr.span), scaled


def _is_pure(facts: Facts, unit: units.Unit) -> bool:
    """Whether a unit applies to the whole expression before it, as in 0.3 [m] and 0.3*sin(theta)
    [m]. For an angle that is declared in radians the result is False: a [deg] after it must not
    convert it."""
    if facts.dimension is None:
        return True
    return facts.dimension == NONE and (unit.dimension != NONE or not facts.united)


def _scaled(of: Expr, unit: units.Unit, span: Span) -> Expr:
    """Returns the expression `of` multiplied by the unit's factor to SI."""
    if unit.is_si:
        return of
    if isinstance(of, Number) and not unit.pi:
        return Number(of.value * unit.factor, span)
    count = abs(unit.pi)
    factors = (Number(Fraction(unit.factor), span), of, *(Name("pi", None, span),) * count)
    return Multiply(factors, (1, 1, *(1 if unit.pi > 0 else -1,) * count), span)
