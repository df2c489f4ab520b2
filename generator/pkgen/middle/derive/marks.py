"""Finds forces of short duration. A mark is the argument u of a function such as exp(u) or tanh(u),
and shows where the function varies.

A pulse a millionth of a step long may lie between the stages of an integrator, where no error
estimate detects it. Its argument u, however, varies smoothly over the step: exp(u) is 0 up to
rounding for u < -36, 1/cosh(u) for |u| > 36, and 1 - tanh(u)^2 for |u| > 18. The runtime
(src/core/short_force_limiter.c) evaluates u along each step. It limits the step size so that u
changes little in a step as long as |u| < 36.

Inverses and roots of a sum a + b(q, t), where a is the constant part, vary over a short range where
|b| is at most |a|. Their mark is u = 1 + b/a. Since these functions decay only like powers, they
have the further marks u/1000, u/1000^2, ..., by which the step size decreases gradually. For 1/r,
where a = 0, no width is known.

A high power b^n with |b| <= 1, such as cos(t)^1000, is bounded by exp(u) with u = n (b^2 - 1)/2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

from ...equations import Quantity, Switch
from ...functions import FUNCTIONS
from ...graph.differentiate import reachable
from ...graph.graph import VARIABLE, ZERO, Graph, Node, Op, Symbol
from ...graph.wording import wordings
from ..points.squares import summands

LADDER = [Fraction(1, 1000**k) for k in range(9)]
_HIGH = 16  # the least exponent for which a power gets a mark


def _arguments(g: Graph, node: Node) -> list[Node]:
    op, data = g.op[node], g.data[node]
    if op is Op.CALL and FUNCTIONS[data].short:
        return [g.multiply(g.number(FUNCTIONS[data].short), g.args[node][0])]
    if op is Op.POWER and data >= _HIGH:
        square = g.multiply(g.args[node][0], g.args[node][0])
        return [g.multiply(g.number(Fraction(data) / 2), g.add(square, g.number(-1)))]
    divides = op is Op.POWER and (data < 0 or Fraction(data).denominator != 1)
    if not (divides or (op is Op.CALL and data == "sqrt")):
        return []
    base = g.args[node][0]
    # the constant part a of the sum a + b
    constant = g.sum(x for x in summands(g, base) if not g.depends[x] & VARIABLE)
    if constant in (ZERO, base):
        return []
    u = g.divide(base, constant)
    return [g.multiply(g.number(x), u) for x in LADDER]


def marks_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Returns the marks of the expressions `outputs`. If both u and -u occur, only the first is
    returned."""
    found: dict[Node, Node] = {}  # by each mark the function's node
    for node in reachable(g, outputs, VARIABLE):
        if not g.depends[node] & VARIABLE:
            continue
        for u in _arguments(g, node):
            if g.negate(u) not in found:
                found.setdefault(u, node)
    texts = wordings(g, found.values(), name)
    return tuple(Switch(Quantity(x, "", ""), u) for x, u in zip(texts, found, strict=True))
