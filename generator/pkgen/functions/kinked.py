"""The table rows of the functions with a kink or a jump.

In C each such function has a version with the prefix `side_` and an argument `side`. A nonzero
`side` selects one smooth branch, whatever the sign of the argument: within a step the integrator
keeps each function on one branch (see middle/derive/switches.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from .interval import NOT_NEGATIVE, POSITIVE, UNIT, Range
from .row import Function, Kinked


def _less(g, a, b):
    """Returns a node whose value is 1 where a < b, else 0."""
    return g.subtract(g.number(1), g.call("step", g.subtract(a, b)))


def _not_less(g, a, b):
    return g.subtract(g.number(1), _less(g, a, b))


def _extreme(name: str, real: Callable, before: str, sign: int) -> Function:
    """Returns the row of min or max, whose value is a where a stands `before` b."""
    return Function(
        arguments=("a", "b"),
        units="same",
        body=f"a {before} b ? a : b {before}= a ? b : a + b",
        remark="a + b: one of them is not a number",
        kinked=Kinked(*("a", "b")[::-sign]),
        real=real,
        array=f"{name}imum",
        exact=real,
        derivative=lambda g, n, a, b: (_less(g, a, b), _not_less(g, a, b))[::-sign],
        interval=lambda x, y: Range(real(x.lo, y.lo), real(x.hi, y.hi)),
        ball=lambda b, x, y: b.pick(real, x, y),
        enclosed=lambda e, x, y: getattr(e, name)(x, y),
        opened=lambda p, a, b: p.larger(a, b, sign),
        branched=True,
        sympy=name.title(),
    )


KINKED: dict[str, Function] = {
    "abs": Function(
        units="same",
        c="fabs",
        kinked=Kinked("-x", "x"),
        real=abs,
        exact=abs,
        parity="even",
        derivative=lambda g, n, a: (g.call("sign", a),),
        interval=lambda x: POSITIVE if x.never_zero else NOT_NEGATIVE,
        ball=lambda b, x: b.slope(abs, x, 1),
        enclosed=lambda e, x: abs(x),
        opened=lambda p, a: p.multiplied(a, p.sign(a)),
        branched=True,
        like_argument=True,
        sympy="Abs",
    ),
    "min": _extreme("min", min, "<", -1),
    "max": _extreme("max", max, ">", 1),
    "step": Function(  # 0 for x < 0, 1 for x >= 0
        units="any",
        body="x >= 0 ? 1 : x < 0 ? 0 : x",
        kinked=Kinked("0", "1"),
        real=lambda x: float(x >= 0),
        array=lambda np, x: np.where(np.asarray(x) < 0, 0.0, 1.0),
        exact=lambda x: Fraction(x >= 0),
        derivative=lambda g, n, a: (g.number(0),),
        interval=lambda x: Range(0, 1),
        ball=lambda b, x: b.chosen(x, (0, 1, 1)),
        enclosed=lambda e, x: e.step(x),
        opened=lambda p, a: p.halved(p.added({(): 1}, p.sign(a))),
        jump="step jumps",
        sympy=lambda sp, x: sp.Heaviside(x, 1),
    ),
    "floor": Function(
        kinked=Kinked("", "", place="place", held="(side - 1) / 2"),
        real=lambda x: float(math.floor(x)),
        exact=lambda x: Fraction(math.floor(x)),
        derivative=lambda g, n, a: (g.number(0),),
        interval=lambda x: Range(x.lo - 1, x.hi),
        ball=lambda b, x: b.floor(x),
        jump="floor jumps",
    ),
    "piece": Function(  # floor, of the place in a table whose value is continuous at the knots
        internal=True,
        c="floor",
        kinked=Kinked("", "", place="place", held="(side - 1) / 2"),
        real=lambda x: float(math.floor(x)) if math.isfinite(x) else math.nan,
        array="floor",
        derivative=lambda g, n, a: (g.number(0),),
        interval=lambda x: Range(x.lo - 1, x.hi),
        ball=lambda b, x: b.floor(x),
    ),
    "sign": Function(  # the derivative of abs, with values -1, 0 and 1
        units="any",
        body="x > 0 ? 1 : x < 0 ? -1 : x",
        kinked=Kinked("-1", "1"),
        real=lambda x: float((x > 0) - (x < 0)),
        exact=lambda x: Fraction((x > 0) - (x < 0)),
        parity="odd",
        derivative=lambda g, n, a: (g.number(0),),
        interval=lambda x: UNIT,
        ball=lambda b, x: b.chosen(x, (-1, 0, 1)),
        enclosed=lambda e, x: e.sign(x),
        opened=lambda p, a: p.sign(a),
        jump="sign jumps",
    ),
}
