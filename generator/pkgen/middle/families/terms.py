"""Splits an energy into terms, each of which is a product, summed over up to two indices. Products
with one sum as a factor are expanded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

from ...graph.affine import Affine, variable
from ...graph.graph import ONE, ZERO, Node
from ...record import record
from ...tree import Add, Expr, Multiply, Name, Negate, Number, Range, Sum
from ..quantities import error
from .expand import FamilyExpander, around, has_sum, independent
from .indexed_ir import NotKept
from .indices import Loop

# A sum over a constant number of indices, which is at most this number, is written out term by
# term.
SHORT = 8


@record
class Factor:
    """A factor or divisor of a term. `loop` has the values of the loop variables in `expr`. Each
    factor has its own values: a `let` definition and the statement that uses it may have loop
    variables with the same name but different values."""

    expr: Expr
    exponent: int  # 1 or -1
    loop: Loop


@record
class Term:
    """A product, summed over none, one or two index ranges."""

    factors: tuple[Factor, ...]  # Divisors come last.
    ranges: tuple[tuple[str, Affine, Affine], ...]  # Each range is (variable, lo, hi).

    def at(self, x: FamilyExpander, *values: Affine) -> Node:
        """Returns the product as a node, with `values` for the variables of the ranges."""
        own = {name: at for (name, _, _), at in zip(self.ranges, values, strict=True)}
        product = ONE
        for factor in self.factors:
            value = x.scalar(factor.expr, {n: at.replaced(own) for n, at in factor.loop.items()})
            if factor.exponent < 0:
                if value == ZERO:
                    raise error(x.model, "division by zero", factor.expr.span)
                value = x.graph.power(value, -1)
            product = x.graph.multiply(product, value)
        body = [factor for factor in self.factors if factor.exponent > 0][-1]
        x.check_magnitude(product, body.expr.span)
        return product


@record
class _Within:
    """The context of an expression inside products and sums: the other factors, the values of loop
    variables, and the ranges of the sums."""

    factors: tuple[Factor, ...]
    loop: Loop
    ranges: tuple[tuple[str, Affine, Affine], ...] = ()

    def times(self, *factors: Factor) -> _Within:
        return replace(self, factors=(*self.factors, *factors))


def terms(x: FamilyExpander, expr: Expr, loop: Loop | None = None) -> list[Term]:
    """Returns the terms of an expression. `loop` has the values of the names in its indices."""
    return list(_terms(x, expr, _Within((), dict(loop or x.sizes))))


def _terms(x: FamilyExpander, expr: Expr, at: _Within) -> Iterator[Term]:
    if not has_sum(x, expr):
        yield _term(expr, at)
        return
    match expr:
        case Add(terms=parts, signs=signs):
            for part, sign in zip(parts, signs, strict=True):
                yield from _terms(x, part if sign > 0 else Negate(part, part.span), at)
        case Negate(of=of, span=span):
            minus = Negate(Number(Fraction(1), span), span)
            yield from _terms(x, of, at.times(Factor(minus, 1, at.loop)))
        case Multiply(factors=parts, exponents=exponents):
            summed = [i for i, part in enumerate(parts) if has_sum(x, part)]
            if len(summed) != 1 or exponents[summed[0]] != 1:
                yield _term(expr, at)
                return
            pairs = enumerate(zip(parts, exponents, strict=True))
            rest = [Factor(part, e, at.loop) for i, (part, e) in pairs if i != summed[0]]
            yield from _terms(x, parts[summed[0]], at.times(*rest))
        case Sum() if around(x, at.loop) and independent(x, expr, at.loop):
            yield _term(expr, at)
        case Sum(body=body, ranges=ranges):
            yield from _of_sum(x, body, at, ranges)
        case Name(id=name, index=None):
            yield from _terms(x, x.definitions[name][-1].value, at)
        case _:
            yield _term(expr, at)


def _term(expr: Expr, at: _Within) -> Term:
    """Returns the expression as a single term. Sums in it, such as inside a function, are computed
    before the equations (see totals.py)."""
    product = sorted([*at.factors, Factor(expr, 1, at.loop)], key=lambda f: -f.exponent)
    return Term(tuple(product), at.ranges)


def _of_sum(x: FamilyExpander, body: Expr, at: _Within, ranges: Sequence[Range]) -> Iterator[Term]:
    """Yields the terms of the sum of `body` over `ranges`. Short ranges of constant length are
    written out."""
    if not ranges:
        yield from _terms(x, body, at)
        return
    item, *left = ranges
    lo, hi = x.index(item.lo, at.loop), x.index(item.hi, at.loop)
    length = hi - lo
    if length.is_constant and length.constant < SHORT:
        for k in range(length.constant + 1):
            inner = replace(at, loop={**at.loop, item.variable: lo + k})
            yield from _of_sum(x, body, inner, left)
        return
    if len(at.ranges) == 2:
        raise NotKept("a sum over three indices")
    own = f"{item.variable}#{len(at.ranges)}"  # a name with # cannot occur in a model
    loop = {**at.loop, item.variable: variable(own)}
    inner = replace(at, loop=loop, ranges=(*at.ranges, (own, lo, hi)))
    yield from _of_sum(x, body, inner, left)
