"""An energy as a list of terms, each a sum of one body: what is linear in sums is taken apart."""

from __future__ import annotations

from fractions import Fraction

from ...graph.affine import Affine, variable
from ...graph.graph import ONE, ZERO, Node
from ...record import record
from ...tree import Add, Expr, Multiply, Name, Negate, Number, Range, Sum
from ..quantities import error
from .expand import Loop, LoopExpander, has_sum
from .loops import Unrolled

SHORT = 8  # a range of constant length up to this is written out


@record
class Factor:
    """An expression that multiplies or divides, and what its loop variables stand for: a `let`
    may sum over a variable that has another meaning where it is used."""

    expr: Expr
    exponent: int  # 1 or -1
    loop: Loop


@record
class Term:
    """The sum of a product over the ranges, none, one or two of them."""

    factors: tuple[Factor, ...]  # those that divide last
    ranges: tuple[tuple[str, Affine, Affine], ...]  # variable, lo, hi (of its own and sizes)

    def at(self, x: LoopExpander, *values: Affine) -> Node:
        """The product with the variables of the ranges at the indices given."""
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


def terms(x: LoopExpander, expr: Expr, sign: int = 1) -> list[Term]:
    found: list[Term] = []
    _collect(x, expr if sign > 0 else Negate(expr, expr.span), [], dict(x.sizes), (), found)
    return found


def _collect(
    x: LoopExpander,
    expr: Expr,
    factors: list[Factor],
    loop: Loop,
    ranges: tuple[tuple[str, Affine, Affine], ...],
    found: list[Term],
) -> None:
    """Adds the terms of factors * expr within the ranges."""
    if not has_sum(x, expr):
        product = sorted([*factors, Factor(expr, 1, loop)], key=lambda f: -f.exponent)
        found.append(Term(tuple(product), ranges))
        return
    match expr:
        case Add(terms=parts, signs=signs):
            for part, sign in zip(parts, signs, strict=True):
                signed = part if sign > 0 else Negate(part, part.span)
                _collect(x, signed, factors, loop, ranges, found)
        case Negate(of=of, span=span):
            minus = Negate(Number(Fraction(1), span), span)
            _collect(x, of, [*factors, Factor(minus, 1, loop)], loop, ranges, found)
        case Multiply(factors=parts, exponents=exponents):
            summed = [i for i, part in enumerate(parts) if has_sum(x, part)]
            if len(summed) != 1 or exponents[summed[0]] != 1:
                raise Unrolled("a sum is multiplied by a sum or divides")
            rest = [
                Factor(part, e, loop)
                for i, (part, e) in enumerate(zip(parts, exponents, strict=True))
                if i != summed[0]
            ]
            _collect(x, parts[summed[0]], [*factors, *rest], loop, ranges, found)
        case Sum(body=body, ranges=inner):
            _within(x, body, factors, loop, ranges, list(inner), found)
        case Name(id=name, index=None):
            _collect(x, x.definitions[name][-1].value, factors, loop, ranges, found)
        case _:
            raise Unrolled("a sum stands inside a function, a power or a vector")


def _within(
    x: LoopExpander,
    body: Expr,
    factors: list[Factor],
    loop: Loop,
    ranges: tuple[tuple[str, Affine, Affine], ...],
    left: list[Range],
    found: list[Term],
) -> None:
    """The terms of a sum, one range after the other; short ranges are written out."""
    if not left:
        _collect(x, body, factors, loop, ranges, found)
        return
    item = left[0]
    lo, hi = x.index(item.lo, loop), x.index(item.hi, loop)
    length = hi - lo
    if length.is_constant and length.constant < SHORT:
        for k in range(length.constant + 1):
            at = {**loop, item.variable: lo + k}
            _within(x, body, factors, at, ranges, left[1:], found)
        return
    if len(ranges) == 2:
        raise Unrolled("a sum over three indices")
    own = f"{item.variable}#{len(ranges)}"  # apart from a name of a size
    at = {**loop, item.variable: variable(own)}
    _within(x, body, factors, at, (*ranges, (own, lo, hi)), left[1:], found)
