"""Routh's reduction: replaces cyclic coordinates by their constant momenta.

Let L = v.M v/2 + b.v + L0, and let its coordinates be cyclic ones (index c) and other ones (index
r). The momenta p_c = M_cc v_c + M_cr v_r + b_c are constant. The other coordinates move according
to the Lagrangian

    R = L - p_c.v_c = v_r.M_rr v_r/2 + b_r.v_r + L0 - y.M_cc^-1 y/2,   y = p_c - b_c - M_cr v_r

and the cyclic rates are v_c = M_cc^-1 y. If a cyclic coordinate is requested as an output, it
becomes a state with this time derivative, which no equation uses. The momenta become parameters.
Their defaults are computed from the initial values, which become parameters too, so that they can
still be set at run time.
References: E. J. Routh, Stability of a Given State of Motion, Macmillan 1877; L. D. Landau,
E. M. Lifshitz, Mechanics, 3rd edition, section 41.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from ...equations import Equations
from ...graph.differentiate import symbols_in
from ...graph.graph import BIT, ZERO, Kind, Node, Symbol
from ...graph.substitute import substituted
from ..derive.effective import NotReduced, solved
from ..drop_coordinates import Start, StartParameters, smaller
from ..quantities import symbols

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE]


def routh(
    equations: Equations, cyclic: Sequence[int], angles: Sequence[int], recorded: Sequence[int]
) -> tuple[Equations, dict[Start, str]]:
    """Returns the equations without the coordinates `cyclic`, and the names of the parameters that
    replace initial values. The motion has to be derived again. Coordinates that are in `angles` too
    become states, which no equation uses; the rates of those in `recorded` become outputs.

    The coordinates must be cyclic, and L of second degree in the rates. Raises NotReduced if the
    coordinates cannot be removed.
    """
    g = equations.graph
    n = len(equations.coordinates)
    rest = [i for i in range(n) if i not in cyclic]
    rates = symbols(g, Kind.RATE, n)
    parameters, momentum = _momenta(equations, cyclic)
    still = dict.fromkeys(rates, ZERO)
    offset = substituted(g, equations.momenta, still)
    (level,) = substituted(g, [equations.lagrangian], still)

    def moving(i: int) -> Node:
        return g.sum(g.multiply(equations.mass[i][j], rates[j]) for j in rest)

    y = [g.subtract(g.subtract(momentum[i], offset[i]), moving(i)) for i in cyclic]
    block = tuple(tuple(equations.mass[i][j] for j in cyclic) for i in cyclic)
    turning, stored = solved(g, block, tuple(y))
    kinetic = g.sum(g.multiply(rates[i], moving(i)) for i in rest)
    lagrangian = g.sum(
        [
            g.multiply(g.number(Fraction(1, 2)), g.subtract(kinetic, stored)),
            *(g.multiply(offset[i], rates[i]) for i in rest),
            level,
        ]
    )
    # The symbol of a cyclic coordinate may occur in L, though L does not depend on it. It is
    # replaced by 0.
    swap = {symbol: ZERO for i, symbol in enumerate(symbols(g, Kind.COORDINATE, n)) if i in cyclic}
    swap |= {rates[i]: rate for i, rate in zip(cyclic, turning, strict=True)}
    swap |= {equations.momenta[i]: momentum[i] for i in cyclic}
    turned = dict(zip(cyclic, turning, strict=True))
    whole = replace(
        equations,
        lagrangian=lagrangian,
        kinetic=None,
        potential=None,
        observed_names=(*equations.observed_names, *(equations.rates[i] for i in recorded)),
        observed=(*equations.observed, *(turned[i] for i in recorded)),
        states=(*equations.states, *(equations.coordinates[i] for i in angles)),
        state_rates=(*equations.state_rates, *(turned[i] for i in angles)),
        state_start=(
            *equations.state_start,
            *(parameters.of(Symbol(Kind.COORDINATE, i)) for i in angles),
        ),
    )
    found = smaller(whole, rest, swap)
    start = {
        field: tuple(
            parameters.node.get(Symbol(kind, i), getattr(equations, field)[i]) for i in rest
        )
        for field, kind in (("start_q", Kind.COORDINATE), ("start_v", Kind.RATE))
    }
    found = replace(found, parameters=tuple(parameters.slots), **start)
    return found, parameters.starts


def _momenta(
    equations: Equations, cyclic: Sequence[int]
) -> tuple[StartParameters, dict[int, Node]]:
    """Returns two results: the parameters, and the constant momentum of each cyclic coordinate as a
    new parameter. The parameters include these momenta, and the initial values on which they
    depend."""
    g = equations.graph
    nodes = [equations.momenta[i] for i in cyclic]
    for i, node in zip(cyclic, nodes, strict=True):
        if g.depends[node] & BIT[Kind.INPUT]:
            raise NotReduced(f"{equations.momenta_names[i].name} contains an input")
        if g.depends[node] & BIT[Kind.STATE]:
            raise NotReduced(f"{equations.momenta_names[i].name} contains a state")
    parameters = StartParameters(equations)
    swap = {g.symbol(s): parameters.of(s) for s in symbols_in(g, nodes, STATE)}
    swap[g.symbol(Symbol(Kind.TIME))] = ZERO  # the momenta are those at the start of a run, t = 0
    at_start = substituted(g, nodes, swap)
    says = "constant momentum, follows the starts"
    return parameters, {
        i: parameters.add(replace(equations.momenta_names[i], description=says), node)
        for i, node in zip(cyclic, at_start, strict=True)
    }
