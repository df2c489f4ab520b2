"""Tests whether the equations of motion are v' = A q + B v + c with constant coefficients."""

from __future__ import annotations

from ...equations import Equations
from ...graph.differentiate import reachable
from ...graph.graph import BIT, VARIABLE, Graph, Kind, Node, Op
from ...graph.normal import Normal

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE]


def affine(equations: Equations, normal: Normal) -> bool:
    """Returns whether f and the rates of states, as written or in normal form, are affine in q, v
    and states with constant coefficients. M has to be constant."""
    g = equations.graph
    moving = [*equations.force, *equations.state_rates]
    varying = {
        node: bool(g.depends[node] & STATE)
        for node in reachable(g, moving, VARIABLE)
        if g.op[node] is Op.SYMBOL
    }
    return all(is_affine(g, [node], varying) or _expanded(g, normal, node) for node in moving)


def is_affine(g: Graph, nodes: list[Node], symbols: dict[Node, bool]) -> bool:
    """Returns whether nodes, as written, are sums of constants and constants times state symbols.

    `symbols` has the symbols that vary: True if a symbol belongs to the state.
    """
    affine = dict(symbols)  # for each node that varies: whether it is affine
    for node in reachable(g, nodes):
        op = g.op[node]
        varying = [affine[a] for a in g.args[node] if a in affine]
        if varying:
            linear = op is Op.ADD or (op is Op.MULTIPLY and len(varying) == 1)
            affine[node] = linear and all(varying)
    return all(affine.get(node, True) for node in nodes)


NONE, CONSTANT, VARYING, MORE = range(4)


def of_rates(equations: Equations) -> int:
    """Returns how the forces of a system with constant M depend on the rates; see in_rates."""
    if equations.states or equations.constraints is not None:
        return MORE
    return in_rates(equations.graph, [*equations.force, *(equations.acceleration or ())])


def linear(equations: Equations) -> bool:
    """Returns whether, as written, M v' = A q + B v + c(t) with constant M, A and B."""
    moving = [*equations.force, *equations.state_rates]
    return in_rates(equations.graph, moving, of=STATE) <= CONSTANT


def in_rates(
    g: Graph,
    nodes: list[Node],
    constant: frozenset[Node] = frozenset(),
    of: int = BIT[Kind.RATE],
) -> int:
    """Returns how nodes, as written, depend on the rates: NONE; CONSTANT: affine, as C v with a
    constant C; VARYING: C depends on q, t or inputs; MORE: otherwise. `constant` are inputs that do
    not vary, such as the index of a loop. `of` is a mask of the kinds that replace rates."""
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
