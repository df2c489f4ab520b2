"""Models with `hamiltonian H`, in the coordinates q and their momenta p_q.

If H is of second degree in the momenta, H = p.A.p/2 + b.p + H0, Legendre's transformation gives
L = (q' - b).A^-1.(q' - b)/2 - H0. For any other H, q and p are the coordinates of L = p.q' - H,
which is of first degree in the rates (first_degree.py).
Reference: V. Arnold, Mathematical Methods of Classical Mechanics, sections 14, 15 and 45.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ...equations import Row
from ...graph.differentiate import gradient, reachable
from ...graph.graph import BIT, ZERO, Kind, Node, Symbol
from ...graph.substitute import substituted
from ...graph.surfaces import argument_of
from ...indices import made_of
from ...model import Coordinate, Model
from ...tree import Add, Expr, Multiply, Name, Prime, Sum
from ..expand.expand import Expander
from ..expand.names import entered
from ..motion import RATES
from ..quantities import error, per_second, symbols
from .first_degree import solved

MOMENTA = BIT[Kind.ACCELERATION]  # While H is expanded, these symbols stand for the momenta.


def in_pairs(model: Model) -> Model:
    """Returns a model with L = p.q' - H in place of H, if H is not of second degree in the momenta;
    else the model itself."""
    if not model.hamiltonian:
        return model
    if not entered(model, lambda orders: _is_other(Expander(model, orders))):
        return model
    span = model.hamiltonian[0].span
    pairs = tuple(map(_pair, model.coordinates))
    terms = (*pairs, *model.hamiltonian)
    signs = (*(1 for _ in pairs), *(-1 for _ in model.hamiltonian))
    per = str if model.dimensionless else per_second
    momenta = (
        replace(c, name=made_of("p_{}", c.name), unit=u, rate_unit=per(u))
        for c in model.coordinates
        for u in [c.momentum_unit]
    )
    whole = Add(terms, signs, span)
    return replace(
        model, coordinates=(*model.coordinates, *momenta), lagrangian=(whole,), hamiltonian=()
    )


def _pair(c: Coordinate) -> Expr:
    """Returns p_q*q', or its sum over the members of a family."""
    span = c.span
    index = None if c.range is None else Name(c.range.variable, None, span)
    rate = Prime(Name(c.name, index, span), span)
    product = Multiply((Name(made_of("p_{}", c.name), index, span), rate), (1, 1), span)
    return product if c.range is None else Sum(product, (c.range,), span)


def _is_other(x: Expander) -> bool:
    x.define_all()
    g, whole = x.graph, hamiltonian_of(x)
    if any(g.depends[argument_of(g, node)] & MOMENTA for node in reachable(g, [whole])):
        return True  # abs(p) is of no degree, though its second derivative is 0
    momenta = gradient(g, whole, MOMENTA).values()
    second = (node for p in momenta for node in gradient(g, p, MOMENTA).values())
    return any(g.depends[node] & MOMENTA for node in second)


def hamiltonian_of(x: Expander) -> Node:
    """Returns H, with the symbols MOMENTA for the momenta. The definitions must be known."""
    g, total = x.graph, ZERO
    for k, (item, index) in enumerate(x.members):
        x.define(made_of("p_{}", item.name), index, symbols(g, Kind.ACCELERATION, k + 1)[k])
    for expr in x.model.hamiltonian:
        with x.statement(expr.span):
            total = g.add(total, x.scalar(expr))
        if g.depends[total] & RATES:
            message = "a Hamiltonian is a function of coordinates and momenta, without rates"
            raise error(x.model, message, expr.span, "the momentum of x is p_x")
    return total


def lagrangian_of(x: Expander, hamiltonian: Node) -> Node:
    """Returns L of an H of second degree in the momenta."""
    g, n = x.graph, x.count
    p, v = symbols(g, Kind.ACCELERATION, n), symbols(g, Kind.RATE, n)
    by = gradient(g, hamiltonian, MOMENTA)
    slopes = [by.get(symbol, ZERO) for symbol in p]
    second = [gradient(g, slope, MOMENTA) for slope in slopes]
    rows = [[row.get(symbol, ZERO) for symbol in p] for row in second]
    at_rest = dict.fromkeys(p, ZERO)
    *drift, rest = substituted(g, [*slopes, hamiltonian], at_rest)
    relative = [g.subtract(rate, b) for rate, b in zip(v, drift, strict=True)]
    found = solved(g, rows, [*relative])
    if found is None:
        message = "the second derivatives of H by the momenta are a singular matrix"
        help = "each momentum needs its square in H, as p_x^2/(2*m)"
        raise error(x.model, message, x.model.hamiltonian[0].span, help)
    half = g.number(Fraction(1, 2))
    return g.subtract(g.multiply(half, g.dot(relative, found)), rest)


def rates_at_start(x: Expander, place: Row, momenta: Row, states: Row) -> Row:
    """Returns the rates dH/dp at t = 0, from the starts of coordinates, momenta and states."""
    g, n = x.graph, x.count
    p, q = symbols(g, Kind.ACCELERATION, n), symbols(g, Kind.COORDINATE, n)
    by = gradient(g, hamiltonian_of(x), MOMENTA)
    there = dict(zip((*p, *q), (*momenta, *place), strict=True))
    there |= zip(symbols(g, Kind.STATE, len(states)), states, strict=True)
    there[g.symbol(Symbol(Kind.TIME))] = ZERO
    rates = substituted(g, [by.get(symbol, ZERO) for symbol in p], there)
    if any(g.depends[rate] & BIT[Kind.INPUT] for rate in rates):
        message = "the rates at the start depend on an input, which has no value before a run"
        help = "write the input into a part of H without momenta"
        raise error(x.model, message, x.model.hamiltonian[0].span, help)
    return tuple(rates)
