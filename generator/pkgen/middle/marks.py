"""Marks: what decides where a short force is, u of exp(u) and tanh(u) say.

A pulse or a barrier whose width is a millionth of a step lies between all times at which a method
asks for forces; no error estimate can see it. But its argument u is smooth along the step, and
shows where the function lives: exp(u) is 0 to rounding below u = -36, 1/cosh(u) and 1 - tanh(u)^2
are outside of some |u| < 36 or 18. The runtime (src/marks.c) looks at u along each step, and makes
none in which u, within +-36, varies by much.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..equations import Quantity, Switch
from .differentiate import reachable
from .graph import VARIABLE, Graph, Node, Op, Symbol
from .wording import wording

# What an argument is multiplied by, for its function to be constant, 0 or huge beyond +-36.
_SCALES = {"exp": 1, "sinh": 1, "cosh": 1, "tanh": 2}


def marks_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Those of the equations that `outputs` are; of u and -u the first."""
    found: dict[Node, Switch] = {}
    for node in reachable(g, outputs, VARIABLE):
        if g.op[node] is Op.CALL and g.data[node] in _SCALES and g.depends[node] & VARIABLE:
            u = g.multiply(g.number(_SCALES[g.data[node]]), g.args[node][0])
            if g.negate(u) not in found:
                found.setdefault(u, Switch(Quantity(wording(g, node, name), "", ""), u))
    return tuple(found.values())
