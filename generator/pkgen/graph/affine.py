"""Affine index expressions: an integer plus integer multiples of names, which are sizes of families
and loop variables. Their values are known only at run time. For example, the index i+1 of `q[i+1]`
in `sum(q[i+1], i = 0..N)` ranges from 1 to N+1, for every N.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..indices import NotAnInteger
from ..record import record
from ..tree import Add, Expr, Multiply, Name, Negate, Number

ROW = "m"  # The loop variable over the rows of the equations of motion.
OTHER = "j"  # The loop variable over the second member in a sum over pairs.
LOOPS = (ROW, OTHER)
# The loop variables of sums in initial values and parameters.
COUNTERS = tuple(f"#{k}" for k in range(8))


@record
class Affine:
    """The expression constant + sum of factor * name; `terms` holds pairs (name, nonzero factor),
    sorted by name."""

    constant: int = 0
    terms: tuple[tuple[str, int], ...] = ()

    def __add__(self, other: Affine | int) -> Affine:
        if isinstance(other, int):
            return Affine(self.constant + other, self.terms)
        factors = dict(self.terms)
        for name, factor in other.terms:
            factors[name] = factors.get(name, 0) + factor
        kept = tuple(sorted((n, f) for n, f in factors.items() if f))
        return Affine(self.constant + other.constant, kept)

    def __neg__(self) -> Affine:
        return Affine(-self.constant, tuple((n, -f) for n, f in self.terms))

    def __sub__(self, other: Affine | int) -> Affine:
        return self + -other

    def times(self, factor: int) -> Affine:
        if factor == 0:
            return Affine()
        return Affine(self.constant * factor, tuple((n, f * factor) for n, f in self.terms))

    @property
    def is_constant(self) -> bool:
        return not self.terms

    def factor(self, name: str) -> int:
        return dict(self.terms).get(name, 0)

    def without(self, name: str) -> Affine:
        return Affine(self.constant, tuple((n, f) for n, f in self.terms if n != name))

    def replaced(self, values: Mapping[str, Affine]) -> Affine:
        """Returns the expression with names replaced by `values`; other names stay."""
        total = Affine(self.constant)
        for name, factor in self.terms:
            total = total + values.get(name, variable(name)).times(factor)
        return total

    def value(self, values: Mapping[str, int]) -> int:
        return self.constant + sum(f * values[n] for n, f in self.terms)

    def text(self, names: Mapping[str, str] | None = None) -> str:
        """Returns the expression as C text, such as `N + 1` or `2 * N`."""
        parts: list[str] = []
        for name, factor in sorted(self.terms, key=lambda x: (x[1] < 0, x[0] not in LOOPS)):
            shown = names[name] if names and name in names else name
            shown = shown if abs(factor) == 1 else f"{abs(factor)} * {shown}"
            sign = "-" if factor < 0 else "+"
            parts.append(f" {sign} {shown}" if parts else ("-" if factor < 0 else "") + shown)
        if self.constant or not parts:
            sign, size = ("-" if self.constant < 0 else "+"), abs(self.constant)
            parts.append(f" {sign} {size}" if parts else str(self.constant))
        return "".join(parts)


def variable(name: str) -> Affine:
    return Affine(0, ((name, 1),))


def affine(expr: Expr, values: Mapping[str, Affine]) -> Affine:
    """Converts an index expression; `values` holds the sizes and loop variables. Raises
    NotAnInteger where the expression is not affine."""
    match expr:
        case Number(value=value) if value.denominator == 1:
            return Affine(int(value))
        case Name(id=name, index=None) if name in values:
            return values[name]
        case Negate(of=of):
            return -affine(of, values)
        case Add(terms=terms, signs=signs):
            total = Affine()
            for term, sign in zip(terms, signs, strict=True):
                total = total + affine(term, values).times(sign)
            return total
        case Multiply(factors=factors, exponents=exponents) if all(e == 1 for e in exponents):
            product = Affine(1)
            for factor in factors:
                value = affine(factor, values)
                if not (product.is_constant or value.is_constant):
                    raise NotAnInteger("a product of sizes", expr.span)
                if value.is_constant:
                    product = product.times(value.constant)
                else:
                    product = value.times(product.constant)
            return product
    raise NotAnInteger("an index may use integers, sizes, loop variables, + - *", expr.span)


def extremes(index: Affine, at: dict[str, tuple[Affine, Affine]]) -> tuple[Affine, Affine]:
    """Returns the least and the greatest value of an index; `at` maps loop variables to ranges."""
    first = last = index
    for name, (lo, hi) in at.items():  # inner loops first: bounds have outer variables
        for low in (True, False):
            end = first if low else last
            factor = end.factor(name)
            if factor:
                at_end = (lo if (factor > 0) == low else hi).times(factor)
                end = end.without(name) + at_end
            first, last = (end, last) if low else (first, end)
    return first, last
