"""Tests whether the equations of motion are linear in the coordinates q and the rates v: v' = A q +
B v + c, with constant A, B and c."""

from __future__ import annotations

from ...equations import Equations
from ...graph.differentiate import reachable
from ...graph.graph import BIT, VARIABLE, Graph, Kind, Node, Op
from ...graph.normal import Normal

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE]


def affine(equations: Equations, normal: Normal) -> bool:
    """Returns whether the forces f in M a = f and the time derivatives of states are affine in
    coordinates, rates and states, with constant coefficients. Tests each expression as written and
    in normal form. The mass matrix M has to be constant."""
    g = equations.graph
    return all(
        (not g.depends[x] & VARIABLE & ~STATE and in_rates(g, [x], of=STATE) <= CONSTANT)
        or _expanded(g, normal, x)
        for x in (*equations.force, *equations.state_rates)
    )


def is_affine(g: Graph, nodes: list[Node], symbols: dict[Node, bool]) -> bool:
    """Returns whether the nodes, as written, are affine in the state, with constant coefficients.

    `symbols` maps each symbol that varies to True if it belongs to the state, else to False.
    """
    affine = dict(symbols)  # maps each node that varies to whether it is affine in the state
    for node in reachable(g, nodes):
        op = g.op[node]
        varying = [affine[a] for a in g.args[node] if a in affine]
        if varying:
            linear = op is Op.ADD or (op is Op.MULTIPLY and len(varying) == 1)
            affine[node] = linear and all(varying)
    return all(affine.get(node, True) for node in nodes)


NONE, CONSTANT, VARYING, MORE = range(4)


def of_rates(equations: Equations) -> int:
    """Returns how the forces f and the accelerations a in M a = f depend on the rates: a value that
    in_rates() returns. The mass matrix M has to be constant."""
    if equations.states or equations.constraints is not None:
        return MORE
    return in_rates(equations.graph, [*equations.force, *(equations.acceleration or ())])


def linear(equations: Equations) -> bool:
    """Returns whether the forces f in M a = f and the time derivatives of states, as written, have
    the form A q + B v + c(t), with coordinates q, rates v and constant matrices A and B."""
    moving = [*equations.force, *equations.state_rates]
    return in_rates(equations.graph, moving, of=STATE) <= CONSTANT


def in_rates(
    g: Graph,
    nodes: list[Node],
    constant: frozenset[Node] = frozenset(),
    of: int = BIT[Kind.RATE],
) -> int:
    """Returns how the nodes, as written, depend on the rates v. The result is NONE if they do not
    depend on v, CONSTANT if they have the form C v + d with a constant matrix C, VARYING if they
    have this form and C depends on q, t or inputs, and MORE otherwise. The symbols `constant` are
    treated as constants. `of` is a mask of kinds of symbols; symbols of these kinds take the place
    of v."""
    found: dict[Node, int] = {}
    varying: set[Node] = set()
    for node in reachable(g, nodes, VARIABLE):
        parts = [found[a] for a in g.args[node] if a in found]
        if g.op[node] is Op.SYMBOL:
            if g.depends[node] & of:
                found[node] = CONSTANT
            elif node not in constant:
                varying.add(node)
        elif not parts:
            varying |= {node} if varying & {*g.args[node]} else set()
        elif g.op[node] is Op.ADD:
            found[node] = max(parts)
        elif g.op[node] is Op.MULTIPLY and len(parts) == 1:
            found[node] = max(parts[0], VARYING) if varying & {*g.args[node]} else parts[0]
        else:
            found[node] = MORE
    return max((found.get(node, NONE) for node in nodes), default=NONE)


def _expanded(g: Graph, normal: Normal, node: Node) -> bool:
    polynomial = normal(node)
    if polynomial is None:
        return False
    for monomial in polynomial:
        varying = [(base, e) for base, e in monomial if g.depends[base] & VARIABLE]
        symbols = all(g.op[b] is Op.SYMBOL and g.depends[b] & STATE for b, _ in varying)
        if not symbols or sum(e for _, e in varying) > 1 or any(e < 0 for _, e in varying):
            return False
    return True
