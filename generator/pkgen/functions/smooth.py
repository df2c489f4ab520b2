"""The table rows of the smooth functions."""

from __future__ import annotations

import math
from fractions import Fraction

from .interval import ANY, NOT_NEGATIVE, POSITIVE, UNIT, Range
from .row import ARC, DIVISOR, LOGARITHM, ROOT, Function, Kinked, at

_HALF = Fraction(1, 2)
_QUARTER = Range(-math.pi / 2, math.pi / 2)


def _one_and_square(g, a, sign: int = 1):
    """Returns 1 + a^2 if `sign` is 1, and 1 - a^2 if `sign` is -1."""
    square = g.power(a, 2)
    return g.add(g.number(1), square if sign > 0 else g.negate(square))


def _atan2(g, n, y, x):
    inverse = g.power(g.add(g.power(x, 2), g.power(y, 2)), -1)
    return g.multiply(x, inverse), g.negate(g.multiply(y, inverse))


def _pow(g, n, a, b):
    lowered = g.call("pow", a, g.subtract(b, g.number(1)))
    return g.multiply(b, lowered), g.multiply(n, g.call("log", a))


def where_positive(g, base, exponent):
    """Returns |base|^max(exponent, 0). The parameters in the exponent are known only at run time.
    At base = 0 the result vanishes if the exponent is positive; there the power base^-exponent is
    singular. A negative base makes base^-exponent NaN, which other checks report."""
    return g.call("pow", g.call("abs", base), g.call("max", exponent, g.number(0)))


def _beyond_one(what: str):
    return lambda x: f"the {what} of a number beyond 1" if abs(x) > 1 else ""


def _root(value: Fraction) -> Fraction | None:
    """Returns the exact square root of a rational number, or None if the root is not rational."""
    if value < 0:
        return None
    n, d = math.isqrt(value.numerator), math.isqrt(value.denominator)
    return Fraction(n, d) if n * n == value.numerator and d * d == value.denominator else None


_ANGLE, _TURN = "PK_F(atan2)(y, x)", "2 * PK_F(acos)(-1)"

SMOOTH: dict[str, Function] = {
    "sin": Function(
        real=math.sin,
        exact=at(0, 0),
        parity="odd",
        derivative=lambda g, n, a: (g.call("cos", a),),
        interval=lambda x: UNIT,
        ball=lambda b, x: b.turning(b.mp.sin, x),
        enclosed=lambda e, x: e.sin(x),
        opened=lambda p, a: p.sin(a),
        series=lambda s, x, a: s.pair("sin", "cos", "-", x, a)[0],
    ),
    "cos": Function(
        real=math.cos,
        exact=at(0, 1),
        parity="even",
        derivative=lambda g, n, a: (g.negate(g.call("sin", a)),),
        interval=lambda x: UNIT,
        ball=lambda b, x: b.turning(b.mp.cos, x),
        enclosed=lambda e, x: e.cos(x),
        opened=lambda p, a: p.cos(a),
        series=lambda s, x, a: s.pair("sin", "cos", "-", x, a)[1],
    ),
    "tan": Function(
        real=math.tan,
        exact=at(0, 0),
        parity="odd",
        derivative=lambda g, n, a: (_one_and_square(g, n),),
        ball=lambda b, x: b.quotient(b.turning(b.mp.sin, x), b.turning(b.mp.cos, x)),
        enclosed=lambda e, x: e.sin(x) / e.cos(x),
        opened=lambda p, a: p.quotient(p.sin(a), p.cos(a)),
        singular=lambda g, a: (g.call("cos", a), DIVISOR),
        series=lambda s, x, a: s.tangent("tan", "+", x, a),
    ),
    "asin": Function(
        real=math.asin,
        array="arcsin",
        exact=at(0, 0),
        undefined=_beyond_one("arc sine"),
        parity="odd",
        derivative=lambda g, n, a: (g.power(_one_and_square(g, a, -1), -_HALF),),
        interval=lambda x: _QUARTER,
        ball=lambda b, x: b.arc(b.mp.asin, x),
        enclosed=lambda e, x: e.asin(x),
        branched=True,
        ends=(-1, 1),
        singular=lambda g, a: (_one_and_square(g, a, -1), ARC),
        like_argument=True,
    ),
    "acos": Function(
        real=math.acos,
        array="arccos",
        exact=at(1, 0),
        undefined=_beyond_one("arc cosine"),
        derivative=lambda g, n, a: (g.negate(g.power(_one_and_square(g, a, -1), -_HALF)),),
        interval=lambda x: Range(0, math.pi),
        ball=lambda b, x: b.arc(b.mp.acos, x),
        enclosed=lambda e, x: e.acos(x),
        branched=True,
        ends=(-1, 1),
        singular=lambda g, a: (_one_and_square(g, a, -1), ARC),
    ),
    "atan": Function(
        real=math.atan,
        array="arctan",
        exact=at(0, 0),
        parity="odd",
        derivative=lambda g, n, a: (g.power(_one_and_square(g, a), -1),),
        interval=lambda x: _QUARTER,
        ball=lambda b, x: b.slope(b.mp.atan, x, 1),
        enclosed=lambda e, x: e.atan(x),
        branched=True,
        like_argument=True,
        series=lambda s, x, a: s.atan(x, a),
    ),
    "atan2": Function(
        arguments=("y", "x"),
        units="any",
        real=math.atan2,
        array="arctan2",
        derivative=_atan2,
        ball=lambda b, y, x: b.atan2(y, x),
        enclosed=lambda e, y, x: e.atan2(y, x),
        jump="atan2 jumps by 2 pi",
        cut=Kinked(
            f"({_ANGLE} > 1 ? {_ANGLE} - {_TURN} : {_ANGLE})",
            f"({_ANGLE} < -1 ? {_ANGLE} + {_TURN} : {_ANGLE})",
        ),
    ),
    "sinh": Function(
        real=math.sinh,
        exact=at(0, 0),
        parity="odd",
        derivative=lambda g, n, a: (g.call("cosh", a),),
        interval=lambda x: POSITIVE if x.positive else ANY,
        ball=lambda b, x: b.growing(b.mp.sinh, b.mp.cosh, x),
        enclosed=lambda e, x: (e.exp(x) - e.exp(-x)) / 2,
        opened=lambda p, a: p.hyperbolic(a, -1),
        like_argument=True,
        short=1,
        series=lambda s, x, a: s.pair("sinh", "cosh", "", x, a)[0],
    ),
    "cosh": Function(
        real=math.cosh,
        exact=at(0, 1),
        parity="even",
        derivative=lambda g, n, a: (g.call("sinh", a),),
        interval=lambda x: Range(1),
        ball=lambda b, x: b.growing(b.mp.cosh, b.mp.cosh, x),
        enclosed=lambda e, x: (e.exp(x) + e.exp(-x)) / 2,
        opened=lambda p, a: p.hyperbolic(a, 1),
        short=1,
        series=lambda s, x, a: s.pair("sinh", "cosh", "", x, a)[1],
    ),
    "tanh": Function(
        real=math.tanh,
        exact=at(0, 0),
        parity="odd",
        derivative=lambda g, n, a: (_one_and_square(g, n, -1),),
        interval=lambda x: UNIT,
        ball=lambda b, x: b.slope(b.mp.tanh, x, 1),
        enclosed=lambda e, x: 1 - 2 / (e.exp(2 * x) + 1),
        opened=lambda p, a: p.quotient(p.hyperbolic(a, -1), p.hyperbolic(a, 1)),
        like_argument=True,
        short=2,
        series=lambda s, x, a: s.tangent("tanh", "-", x, a),
    ),
    "exp": Function(
        real=math.exp,
        exact=at(0, 1),
        derivative=lambda g, n, a: (n,),
        interval=lambda x: POSITIVE,
        ball=lambda b, x: b.exp(x),
        enclosed=lambda e, x: e.exp(x),
        opened=lambda p, a: p.exp(a),
        short=1,
        series=lambda s, x, a: s.exp(x, a),
    ),
    "log": Function(
        real=math.log,
        exact=at(1, 0),
        undefined=lambda x: "the logarithm of a number that is not positive" if x <= 0 else "",
        derivative=lambda g, n, a: (g.power(a, -1),),
        ball=lambda b, x: b.log(x),
        enclosed=lambda e, x: e.log(x),
        ends=(0,),
        singular=lambda g, a: (a, LOGARITHM),
        series=lambda s, x, a: s.log(x, a),
    ),
    # The derivative 1/(2 sqrt(x)) is taken as 0 at x = 0, since reciprocal(0) is 0.
    "sqrt": Function(
        units="root",
        real=math.sqrt,
        exact=_root,
        undefined=lambda x: "the square root of a negative number" if x < 0 else "",
        derivative=lambda g, n, a: (g.multiply(g.number(_HALF), g.call("reciprocal", n)),),
        interval=lambda x: POSITIVE if x.positive else NOT_NEGATIVE,
        ball=lambda b, x: b.sqrt(x),
        enclosed=lambda e, x: e.sqrt(x),
        branched=True,
        ends=(0,),
        singular=lambda g, a: (a, ROOT),
        like_argument=True,
        series=lambda s, x, a: s.sqrt(x, a),
    ),
    # pow(x, y) is x^y with an exponent that is not a constant number.
    "pow": Function(
        arguments=("x", "y"),
        internal=True,
        real=math.pow,
        array="power",
        derivative=_pow,
        interval=lambda x, y: POSITIVE if x.positive else ANY,
        ball=lambda b, x, y: b.pow(x, y),
        enclosed=lambda e, x, y: e.exp(y * e.log(x)),
        opened=lambda p, a, b: p.pow(a, b),
        ends=(0,),
        singular=lambda g, a, b: (where_positive(g, a, g.negate(b)), DIVISOR),
        sympy="Pow",
        series=lambda s, x, a, exponent: s.pow(x, a, exponent),
    ),
    # reciprocal(x) is 1/x, but 0 at x = 0: then the derivatives of sqrt, norm and abs are 0 at 0.
    "reciprocal": Function(
        units="any",
        internal=True,
        body="x == 0 ? 0 : 1 / x",
        note="0 at 0: with it the derivatives of sqrt, norm and abs vanish there.",
        real=lambda x: 1 / x if x else 0.0,
        array=lambda np, x: np.where(x == 0, 0.0, 1 / np.where(x == 0, 1.0, x)),
        exact=lambda x: 1 / x if x else Fraction(0),
        parity="odd",
        derivative=lambda g, n, a: (g.negate(g.power(n, 2)),),
        interval=lambda x: POSITIVE if x.positive else NOT_NEGATIVE if x.not_negative else ANY,
        ball=lambda b, x: x if x == (0, 0) else b.inverse(x),
        enclosed=lambda e, x: 1 / x,
        opened=lambda p, a: p.inverse(a),
        singular=lambda g, a: (a, DIVISOR),
        sympy=lambda sp, x: 1 / x,
        series=lambda s, x, a: s.reciprocal(x, a),
    ),
    "place": Function(  # The function u of floor(x); see Kinked.place.
        internal=True,
        body="x",
        real=lambda x: x,
        derivative=lambda g, n, a: (g.number(1),),
        interval=lambda x: x,
        ball=lambda b, x: x,
        counted=True,
    ),
    "select": Function(  # if(c, a, b): a where c is 1, b where c is 0
        arguments=("c", "a", "b"),
        internal=True,
        body="c > 0 ? a : c <= 0 ? b : c",
        real=lambda c, a, b: a if c > 0 else b if c <= 0 else c,
        array=lambda np, c, a, b: np.where(c > 0, a, np.where(c <= 0, b, c)),
        exact=lambda c, a, b: a if c else b,
        derivative=lambda g, n, c, a, b: (
            g.number(0),
            g.call("select", c, g.number(1), g.number(0)),
            g.call("select", c, g.number(0), g.number(1)),
        ),
        interval=lambda c, a, b: Range(min(a.lo, b.lo), max(a.hi, b.hi)),
        ball=lambda e, c, a, b: a if c.mid > c.rad else b if c == (0, 0) else None,
        opened=lambda p, c, a, b: p.added(b, p.multiplied(c, p.added(a, p.negated(b)))),
        enclosed=lambda e, c, a, b: c * a + (1 - c) * b,
        branched=True,
        sympy=lambda sp, c, a, b: sp.Function("if")(c, a, b),
    ),
}
