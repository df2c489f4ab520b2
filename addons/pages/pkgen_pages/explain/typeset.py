"""Typesets SymPy expressions as MathML, in the form of a textbook.

A product has its numbers first, then parameters, variables and functions, each in the order of
declaration; the first term of a sum is not negative, if possible. SymPy's own MathML printer sorts
alphabetically and uses elements (mfenced) that browsers no longer render.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from . import mathml
from .mathml import fraction, operator, product, row

if TYPE_CHECKING:
    import sympy

_WORDS = {"Heaviside": "step", "log": "ln", "Abs": "abs", "asin": "arcsin", "acos": "arccos"}
_WORDS |= {"atan": "arctan", "Max": "max", "Min": "min"}
_POWERS = frozenset(("sin", "cos", "tan", "sinh", "cosh", "tanh"))
_ODD = frozenset(("sin", "tan", "sinh", "tanh", "asin", "atan"))
_EVEN = frozenset(("cos", "cosh", "Abs"))
_BARE = frozenset((*_POWERS, "asin", "acos", "atan", "log"))
FEW = (2, 4, 5, 8, 16, 32, 64)  # denominators that are shown as fractions, not as decimals
LARGE = 10**7
SHORT = 14  # most letters of an exponent of e; exp(...) is written for longer ones


class Typesetter:
    """Typesets expressions. `order` has the rank of each name, by which factors and terms are
    sorted; `constants` are the names of parameters."""

    def __init__(
        self,
        order: Mapping[str, int],
        constants: frozenset[str],
        name: Callable[[str], str] = mathml.name,
    ):
        self.order, self.constants, self.name = order, constants, name

    def __call__(self, expr: sympy.Expr) -> str:
        return row(*self.terms(expr))

    def terms(self, expr: sympy.Expr) -> list[str]:
        """Returns the terms of a sum, each preceded by its sign."""
        found = []
        for negative, term in self._in_order(expr.replace(_turns, self._turned)):
            sign = "-" if negative else "+"
            before = mathml.binary(sign) if found else mathml.leading(sign) if negative else ""
            found.append(before + self._term(term))
        return found

    def _in_order(self, expr: sympy.Expr) -> list[tuple[bool, sympy.Expr]]:
        """Returns the sorted terms as pairs: whether a term is negative, the term without its
        sign."""
        if not expr.is_Add:
            return [_signed(expr)]
        terms = [_signed(t) for t in sorted(expr.args, key=self._place)]
        first = next((t for t in terms if not t[0]), terms[0])
        terms.remove(first)
        return [first, *terms]

    def _turned(self, call: sympy.Expr) -> sympy.Expr:
        """Returns a call such as cos(phi - theta) as cos(theta - phi) if theta is declared before
        phi. The result is an undefined function that is named cos, since SymPy's own cos would
        restore the order of its argument."""
        import sympy as sp

        (inside,) = call.args
        first = min(sp.Add.make_args(inside), key=self._place)
        turned = first.could_extract_minus_sign()
        own = sp.Function(call.func.__name__)(-inside if turned else inside)
        return -own if turned and call.func.__name__ in _ODD else own

    def _place(self, term: sympy.Expr) -> tuple:
        """Returns the key by which the terms of a sum are sorted: first by variables, then by
        parameters. Terms without either are last."""
        powers, others, constants = [], [], []
        for factor in term.as_ordered_factors():
            base, exponent = factor.as_base_exp()
            times = int(exponent) if exponent.is_Integer and exponent > 0 else 1
            ranks = sorted(self.order[s.name] for s in base.free_symbols if s.name in self.order)
            into = powers if base.is_Symbol else others
            into = constants if self._is_constant(factor) else into
            into += ranks * times
        places = sorted(powers), sorted(others), sorted(constants)
        return (not term.free_symbols, *places, str(term))

    def _is_constant(self, expr: sympy.Expr) -> bool:
        return all(s.name in self.constants for s in expr.free_symbols)

    # -- products -----------------------------------------------------------------------------

    def _term(self, expr: sympy.Expr) -> str:
        if expr.is_Mul or (expr.is_Pow and _is_below(expr)):
            return self._product(expr)
        return self._factor(expr)

    def _product(self, expr: sympy.Expr) -> str:
        import sympy as sp

        coefficient, factors = expr.as_coeff_mul()
        above = [f for f in factors if not _is_below(f)]
        below = [1 / f for f in factors if _is_below(f)]
        decimal = _decimal(coefficient)
        numerator = [] if decimal else [sp.Integer(coefficient.p)]
        denominator = 1 if decimal else coefficient.q
        over = [self._factor(f) for f in self._by_kind(above)]
        under = [self._factor(f) for f in self._by_kind(below)]
        count = decimal or (str(numerator[0]) if numerator[0] != 1 or not over else "")
        if not under:
            front = mathml.number(count) if count else ""
            if denominator != 1:
                front = fraction(
                    mathml.number(count or "1"), mathml.number(str(denominator)), small=True
                )
            return product([*filter(None, [front]), *over])
        if denominator != 1:
            under.insert(0, mathml.number(str(denominator)))
        if count and (over or count != "1" or decimal):
            over.insert(0, mathml.number(count))
        if len(above) == len(over) == 1 and above[0].is_Add:
            over = [self(above[0])]
        if len(below) == len(under) == 1 and below[0].is_Add:
            under = [self(below[0])]
        return fraction(product(over) or mathml.number("1"), product(under))

    def _by_kind(self, factors: list[sympy.Expr]) -> list[sympy.Expr]:
        return sorted(factors, key=self._rank)

    def _rank(self, factor: sympy.Expr) -> tuple:
        base = factor.base if factor.is_Pow else factor
        constant = self._is_constant(factor)
        if base.is_Number or not base.free_symbols:
            kind = 0
        elif base.is_Symbol:
            kind = 2 if constant else 4
        elif base.is_Add:
            kind = 1 if constant else 5
        elif factor.is_Pow and not base.is_Function:
            kind = 3 if constant else 5
        else:
            kind = 3.5 if constant else 6
        ranks = sorted(self.order.get(s.name, 0) for s in factor.free_symbols)
        return (kind, ranks, str(factor))

    # -- factors ------------------------------------------------------------------------------

    def _factor(self, expr: sympy.Expr) -> str:
        """Returns an expression as a factor of a product, in brackets if needed."""
        if expr.is_Add:
            return mathml.fenced(self(expr))
        if expr.is_Mul or (expr.is_Number and expr < 0):
            inner = self(expr)
            return mathml.fenced(inner) if _signed(expr)[0] else inner
        return self._atom(expr)

    def _atom(self, expr: sympy.Expr) -> str:
        import sympy as sp

        if expr.is_Integer:
            return mathml.number(str(expr))
        if expr.is_Number:
            return self._rational(expr)
        if expr is sp.pi:
            return mathml.name("pi")
        if expr is sp.E:
            return mathml.name("e")
        if expr.is_Symbol:
            return self.name(expr.name)
        if expr.is_Pow:
            return self._power(expr.base, expr.exp)
        return self._function(expr)

    def _rational(self, value: sympy.Number) -> str:
        if not value.is_Rational:
            return mathml.number(f"{float(value):.15g}")
        decimal = _decimal(value)
        if decimal:
            return mathml.number(decimal)
        made = fraction(mathml.number(str(abs(value.p))), mathml.number(str(value.q)), small=True)
        return row(mathml.leading("-"), made) if value < 0 else made

    def _power(self, base: sympy.Expr, exponent: sympy.Expr) -> str:
        import sympy as sp

        if exponent is sp.S.Half:
            return f"<msqrt>{self(base)}</msqrt>"
        shown = self._exponent(exponent)
        if base.is_Function and exponent.is_Integer:
            return self._function(base, shown)
        if base.is_Symbol or (base.is_Integer and base > 0) or base in (sp.E, sp.pi):
            return mathml.sup(self._atom(base), shown)
        return mathml.sup(mathml.fenced(self(base)), shown)

    def _exponent(self, exponent: sympy.Expr) -> str:
        if exponent.is_Rational and not exponent.is_Integer:
            sign = mathml.leading("-") if exponent < 0 else ""
            return row(sign + f"<mn>{abs(exponent.p)}/{exponent.q}</mn>")
        return self(exponent)

    def _function(self, call: sympy.Expr, power: str = "") -> str:
        own = call.func.__name__
        arguments = call.args[:1] if own == "Heaviside" else call.args
        return function(own, [self(a) for a in arguments], _bare(call), power)


def function(name: str, arguments: list[str], bare: bool, power: str = "") -> str:
    """Returns a function call; `bare` means that its argument needs no brackets. An exponent
    `power` follows the name of sine and similar functions; for other functions it follows the
    call."""
    if power and name not in _POWERS:
        made = function(name, arguments, bare)
        whole = name in ("abs", "Abs", "norm")
        return mathml.sup(made if whole else mathml.fenced(made), power)
    first = arguments[0]
    match name:
        case "exp" if mathml.width(first) <= SHORT:
            return mathml.sup(mathml.name("e"), first)
        case "abs" | "Abs" | "norm":
            return mathml.bars(first)
        case "sqrt":
            return f"<msqrt>{first}</msqrt>"
    word = f"<mi>{_WORDS.get(name, name)}</mi>"
    word = mathml.sup(word, power) if power else word
    if bare and name in _BARE:
        return mathml.applied(word, first, bracketed=False)
    return mathml.applied(word, operator(",").join(arguments), bracketed=True)


def _turns(x: sympy.Expr) -> bool:
    own = type(x).__name__
    known = own in _ODD or own in _EVEN
    return known and x.args[0].is_Add and type(x).__module__ is not None


def _signed(term: sympy.Expr) -> tuple[bool, sympy.Expr]:
    """Returns whether a term begins with a minus sign, and the term without that sign. A factor
    whose terms are all negative is negated, which changes the sign of the term."""
    negative, factors = False, []
    for factor in term.as_ordered_factors() if term.is_Mul else [term]:
        base, exponent = factor.as_base_exp()
        odd = exponent.is_Integer and exponent % 2 == 1
        if factor.is_Number and factor < 0:
            negative, factor = not negative, -factor
        elif odd and base.is_Add and all(t.could_extract_minus_sign() for t in base.args):
            negative, factor = not negative, (-base) ** exponent
        factors.append(factor)
    return negative, term.func(*factors) if term.is_Mul else factors[0]


def _bare(call: sympy.Expr) -> bool:
    (first, *others) = call.args
    return not others and (first.is_Symbol or (first.is_Integer and first >= 0))


def _is_below(factor: sympy.Expr) -> bool:
    return factor.is_Pow and factor.exp.could_extract_minus_sign() and not factor.base.is_Number


def _decimal(value: sympy.Rational) -> str:
    """Returns a number as a decimal like "9.81". Returns "" if a decimal is not the best form: for
    integers, for simple fractions like 1/2, and for fractions like 1/7 without a finite decimal
    expansion. Very large integers and denominators are always decimals."""
    p, q = abs(value.p), value.q
    few = q in FEW or (q == 1 and p < LARGE)
    if few or (q < LARGE and not _ends(q)):
        return ""
    return f"{float(value):.15g}"


def _ends(q: int) -> bool:
    """Returns whether 1/q has a finite decimal expansion: the integer q has no prime factors other
    than 2 and 5."""
    for prime in (2, 5):
        while q % prime == 0:
            q //= prime
    return q == 1
