"""The effective potential V_eff: the energy with the momenta of cyclic coordinates, and with all
other rates 0.

In the words of reduce/routh.py, V_eff = -L0 + y.M_cc^-1 y/2 with y = p_c - b_c. Without cyclic
coordinates it is the energy at rest: V, and of a driven hoop the Jacobi integral at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from ...equations import Equations, Row
from ...graph.collect import fewest
from ...graph.graph import BIT, ZERO, Graph, Kind, Node
from ...graph.solve import Factors, SingularMass, elimination_order, factors
from ...graph.substitute import substituted
from ..drop_coordinates import StartParameters
from ..quantities import symbols

NAME = "V_eff"


class NotReduced(Exception):
    """The cyclic coordinates cannot be removed. The text is the reason."""


def effective_potential(e: Equations, cyclic: Sequence[int], momenta: Row) -> Node:
    """Returns V_eff. `momenta` are those of the coordinates `cyclic`. Raises NotReduced."""
    g, n = e.graph, len(e.coordinates)
    block = tuple(tuple(e.mass[i][j] for j in cyclic) for i in cyclic)
    if any(g.depends[entry] & BIT[Kind.RATE] for row in block for entry in row):
        raise NotReduced("L is not of second degree in the rates")
    # L does not depend on a cyclic coordinate, though its symbol may occur.
    gone = {symbols(g, Kind.COORDINATE, n)[i]: ZERO for i in cyclic}
    still = dict.fromkeys(symbols(g, Kind.RATE, n), ZERO) | gone
    level, *offsets = substituted(g, [e.lagrangian, *(e.momenta[i] for i in cyclic)], still)
    block = tuple(tuple(substituted(g, row, still)) for row in block)
    y = tuple(map(g.subtract, substituted(g, momenta, gone), offsets))
    _, stored = solved(g, block, y)
    return g.subtract(g.multiply(g.number(Fraction(1, 2)), stored), level)


def written(e: Equations, cyclic: Sequence[int]) -> tuple[Equations, Node]:
    """Returns V_eff with symbols for the momenta, and equations that have names for these."""
    parameters = StartParameters(e)
    momenta = tuple(parameters.add(e.momenta_names[i], ZERO) for i in cyclic)
    found = effective_potential(e, cyclic, momenta)
    return replace(e, parameters=tuple(parameters.slots)), found


def solved(g: Graph, block: tuple[Row, ...], y: Row) -> tuple[Row, Node]:
    """Returns the vector x = block^-1 y and the number y.x, where `block` is a block of M. The
    number is computed as a sum of squares divided by the pivots of the block, which takes few
    operations."""
    order, _ = elimination_order(g, block)
    try:
        found = factors(g, block, order)
    except SingularMass:
        found = None
    if found is None:
        raise NotReduced("their block of M is singular")
    # Pivots are simplified: with constants I1 and I3, I1 + (I3 - I1) cos^2 - I3 cos^2 becomes I1
    # sin^2.
    pivots = [fewest(g, [pivot])[0] for pivot in found.pivots]
    inverses = [g.power(pivot, -1) for pivot in pivots]
    found = Factors(order, found.lower, pivots, inverses)
    z = found.forward(g, y)
    squares = (
        g.multiply(g.power(entry, 2), inverse) for entry, inverse in zip(z, inverses, strict=True)
    )
    return found.backward(g, z), g.sum(squares)
