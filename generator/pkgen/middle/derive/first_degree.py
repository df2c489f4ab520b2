"""Models whose L is of first degree in the rates: L = A(q, t).q' - H(q, t).

Lagrange's equations are then W q' = -dH/dq - dA/dt with W_ij = dA_i/dq_j - dA_j/dq_i, without
accelerations. The coordinates become states, and q' is solved for where W is regular. Examples are
point vortices, guiding centres, and the equations of Lotka and Volterra.
Reference: R. Jackiw, (Constrained) quantization without tears, arXiv:hep-th/9306075.
"""

from __future__ import annotations

import random
from dataclasses import replace

from ...equations import Row
from ...graph.differentiate import gradient, symbols_in
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ...graph.substitute import substituted
from ...indices import made_of
from ...model import Model, State
from ..expand.expand import Expander
from ..expand.names import entered
from ..motion import RATES, Energies
from ..quantities import error, rate_of_state

SAMPLES = 3
SMALL = 1e-9  # a pivot below this size at all samples counts as 0
_BESIDE = ("kinetic", "constraints", "dissipation", "forces", "loads")  # need inertia


def as_states(model: Model) -> Model:
    """Returns the model with its coordinates as states if L is of first degree in all rates, else
    the model itself."""
    if not (model.lagrangian and model.coordinates) or model.rotations or model.kinetic:
        return model
    if not entered(model, lambda orders: _is_of_first_degree(Expander(model, orders))):
        return model
    for field in _BESIDE:
        for item in getattr(model, field):
            message = "L is of first degree in the rates, so its coordinates have no inertia"
            raise error(model, message, item.span, "leave this out, or write it into L")
    for start in model.starts:
        if start.order:
            message = (
                f"{start.name}' follows from the coordinates: L is of first degree in the rates"
            )
            raise error(model, message, start.span, f"start {start.name} = … is enough")
    made = [
        State(c.name, c.range, c.unit, c.rate_unit, c.description, c.span)
        for c in model.coordinates
    ]
    return replace(model, coordinates=(), states=(*made, *model.states))


def _is_of_first_degree(x: Expander) -> bool:
    x.define_all()
    momenta = gradient(x.graph, x.total(x.model.lagrangian), RATES)
    return bool(momenta) and not any(x.graph.depends[p] & RATES for p in momenta.values())


def rates_of_first_degree(x: Expander, lagrangian: Node) -> tuple[dict[int, Node], Energies]:
    """Returns the rates of the states that were coordinates, by their indices, and the energies
    with -H in place of L. Defines the momenta A."""
    g, model, count = x.graph, x.model, x.state_count
    given = {rate.name for rate in model.rates}
    own = [
        (family, index, family.flat(index))
        for family in x.states.values()
        if family.name not in given
        for index in family.members
    ]
    q = [g.symbol(Symbol(Kind.STATE, k)) for _, _, k in own]
    v = [rate_of_state(g, k, count) for _, _, k in own]
    at_rest = dict.fromkeys(v, ZERO)
    by = gradient(g, lagrangian, BIT[Kind.STATE])
    rows, right = [], []
    with x.statement(model.span):
        for (family, index, _), coordinate, rate in zip(own, q, v, strict=True):
            momentum = by.get(rate, ZERO)
            x.define(made_of("p_{}", family.name), index, momentum)
            residual = g.subtract(x.derivative(momentum), by.get(coordinate, ZERO))
            slopes = gradient(g, residual, BIT[Kind.STATE])
            rows.append([slopes.get(other, ZERO) for other in v])
            right.append(g.negate(substituted(g, [residual], at_rest)[0]))
    found = solved(g, rows, right)
    if found is None:
        message = "L is of first degree in the rates, and its symplectic form is singular"
        help = "the equations do not determine the rates: each coordinate needs a conjugate one"
        raise error(model, message, model.lagrangian[0].span, help)
    (rest,) = substituted(g, [lagrangian], at_rest)
    rates = {k: rate for (_, _, k), rate in zip(own, found, strict=True)}
    return rates, Energies(rest, None, None, ZERO, whole=lagrangian)


def solved(g: Graph, rows: list[list[Node]], right: list[Node]) -> Row | None:
    """Returns the solution of a linear system by elimination, with the largest pivots at random
    states; None if the matrix is singular there."""
    n, draw = len(rows), random.Random(4801)
    order = []
    for k in range(n):
        sizes = [_size(g, row[k], draw) for row in rows]
        best = max((i for i in range(n) if i not in order), key=lambda i: sizes[i])
        if not sizes[best] > SMALL:
            return None
        order.append(best)
        inverse = g.power(rows[best][k], -1)
        for i in (i for i in range(n) if i not in order and rows[i][k] != ZERO):
            factor = g.multiply(rows[i][k], inverse)
            rows[i] = [
                g.subtract(a, g.multiply(factor, b)) if j > k else ZERO
                for j, (a, b) in enumerate(zip(rows[i], rows[best], strict=True))
            ]
            right[i] = g.subtract(right[i], g.multiply(factor, right[best]))
    found: dict[int, Node] = {}
    for k in reversed(range(n)):
        row = rows[order[k]]
        known = g.sum(g.multiply(row[j], found[j]) for j in found)
        found[k] = g.divide(g.subtract(right[order[k]], known), row[k])
    return tuple(found[k] for k in range(n))


def _size(g: Graph, node: Node, draw: random.Random) -> float:
    """Returns the largest magnitude of an entry at a few random states."""
    symbols = symbols_in(g, [node])
    states = ({s: draw.uniform(0.5, 1.5) for s in symbols} for _ in range(SAMPLES))
    return max(abs(evaluate(g, [node], state)[0]) for state in states)
