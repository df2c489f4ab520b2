"""The equations as y' = F(t, y), y = (coordinates, rates, first-order variables).

The order is that of the runtime's states. Of a rotation there are its body rates and its
quaternion: nothing depends on its coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..equations import Equations
from ..graph.graph import Graph, Kind, Node, Symbol
from ..graph.substitute import substituted


def variables(e: Equations) -> list[Symbol]:
    seen, turning = range(len(e.seen)), _turning(e)
    return [
        *(Symbol(Kind.COORDINATE, i) for i in seen),
        *(Symbol(Kind.RATE, i) for i in (*seen, *turning)),
        *(Symbol(Kind.STATE, i) for i in range(len(e.states))),
    ]


def slopes(g: Graph, e: Equations) -> list[Node]:
    """F, in `g`, a copy of the graph; of equations whose accelerations are written out."""
    n = range(len(e.seen))
    found = [g.symbol(Symbol(Kind.RATE, i)) for i in n]
    found += [e.acceleration[i] for i in (*n, *_turning(e))]
    return without_rates_of_states(g, e, [*found, *e.state_rates])


def without_rates_of_states(g: Graph, e: Equations, nodes: Iterable[Node]) -> list[Node]:
    """Symbols beyond the states stand for their rates (middle/derive/states.py)."""
    n = len(e.states)
    swap = {g.symbol(Symbol(Kind.STATE, n + i)): rate for i, rate in enumerate(e.state_rates)}
    return substituted(g, nodes, swap)


def _turning(e: Equations) -> list[int]:
    return [i for i in range(len(e.coordinates)) if i in e.turning]
