"""The equations of motion as a first-order system y' = F(t, y).

The vector y has the coordinates, the rates and the first-order variables, in the order of the
runtime. A rotation contributes only its body rates and its quaternion, no coordinates.
"""

from __future__ import annotations

from ..equations import Equations
from ..graph.graph import Graph, Kind, Node, Symbol


def variables(e: Equations) -> list[Symbol]:
    seen, turning = range(len(e.seen)), _turning(e)
    return [
        *(Symbol(Kind.COORDINATE, i) for i in seen),
        *(Symbol(Kind.RATE, i) for i in (*seen, *turning)),
        *(Symbol(Kind.STATE, i) for i in range(len(e.states))),
    ]


def slopes(g: Graph, e: Equations) -> list[Node]:
    """Returns the right-hand side F of y' = F(t, y). `g` is the equations' graph or a copy of it.
    `e.acceleration`, the expressions of the accelerations, must not be None."""
    n = range(len(e.seen))
    found = [g.symbol(Symbol(Kind.RATE, i)) for i in n]
    found += [e.acceleration[i] for i in (*n, *_turning(e))]
    return [*found, *e.state_rates]


def _turning(e: Equations) -> list[int]:
    return [i for i in range(len(e.coordinates)) if i in e.turning]
