"""Marks: arguments that locate forces of short duration, such as u in exp(u) and tanh(u).

A pulse or a barrier of a millionth of a step may lie between all stages of a method; no error
estimate can see it. Its argument u, however, is smooth along the step, and tells where the function
varies: exp(u) is 0 up to rounding for u < -36, 1/cosh(u) for |u| > 36, and 1 - tanh(u)^2 for
|u| > 18. The runtime (src/core/short_force_limiter.c) evaluates u along each step, and limits the
step size so that u, within +-36, does not vary by much.

A divisor or a root of a + b(q, t) varies in a short range where |b| is not larger than the constant
a: there u = 1 + b/a. The function decays only by powers, so a ladder u, u/1000, ... makes step
sizes decrease gradually. For 1/r, where a = 0, no width is known.

A high power of a base of at most 1, such as cos(t)^1000, is bounded by exp(u), u = n (b^2 - 1)/2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

from ...equations import Quantity, Switch
from ...functions import FUNCTIONS
from ...graph.differentiate import reachable
from ...graph.graph import VARIABLE, ZERO, Graph, Node, Op, Symbol
from ...graph.wording import wording

LADDER = [Fraction(1, 1000**k) for k in range(9)]
_HIGH = 16  # exponents from here on make a power short


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
    constant, addends = ZERO, [base]  # a, and addends still to be visited
    while addends:
        addend = addends.pop()
        if g.op[addend] is Op.ADD:
            addends.extend(g.args[addend])
        elif not g.depends[addend] & VARIABLE:
            constant = g.add(constant, addend)
    if constant in (ZERO, base):
        return []
    u = g.divide(base, constant)
    return [g.multiply(g.number(x), u) for x in LADDER]


def marks_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Returns the marks of the equations `outputs`; of u and -u the first."""
    found: dict[Node, Switch] = {}
    for node in reachable(g, outputs, VARIABLE):
        if not g.depends[node] & VARIABLE:
            continue
        for u in _arguments(g, node):
            if g.negate(u) not in found:
                found.setdefault(u, Switch(Quantity(wording(g, node, name), "", ""), u))
    return tuple(found.values())
