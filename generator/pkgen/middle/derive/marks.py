"""Marks: what decides where a short force is, u of exp(u) and tanh(u) say.

A pulse or a barrier whose width is a millionth of a step lies between all times at which a method
asks for forces; no error estimate can see it. But its argument u is smooth along the step, and
shows where the function lives: exp(u) is 0 to rounding below u = -36, 1/cosh(u) and 1 - tanh(u)^2
are outside of some |u| < 36 or 18. The runtime (src/core/marks.c) looks at u along each step, and
makes none in which u, within +-36, varies by much.

What is divided by a + b(q, t), or is a root of it, is short where b is no larger than the constant
a: there u = 1 + b/a. That fades by powers alone, so steps come nearer by a ladder, u/1000 and so
on. Of 1/r, where a = 0, no width is known.

A high power of what is at most 1, as cos(t)^1000, is no larger than exp(u), u = n (b^2 - 1)/2.
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
_HIGH = 16  # a power that high is shorter than what it is of


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
    constant, addends = ZERO, [base]  # a, and what is not looked at yet
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
    """Those of the equations that `outputs` are; of u and -u the first."""
    found: dict[Node, Switch] = {}
    for node in reachable(g, outputs, VARIABLE):
        if not g.depends[node] & VARIABLE:
            continue
        for u in _arguments(g, node):
            if g.negate(u) not in found:
                found.setdefault(u, Switch(Quantity(wording(g, node, name), "", ""), u))
    return tuple(found.values())
