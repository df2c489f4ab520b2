"""Removes coordinates and attitudes from expressions whose values do not depend on them.

For example, the inertia of a wheel about its axis contains sin(s)^2 + cos(s)^2, the mass of a
satellite |Q|^4. Values modulo a prime distinguish such expressions from varying ones
(graph/residues.py). They are rewritten with the angle 0, or with the unit quaternion 1."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..equations import Attitude, Equations
from ..graph.count import operations
from ..graph.graph import BIT, ONE, ZERO, Graph, Kind, Node, Symbol
from ..graph.residues import Residues
from ..graph.substitute import substituted
from .attitudes import numbers, on_sphere

MOST = 24  # largest number of coordinates: each takes a sweep of all expressions


def without_coordinates(g: Graph, nodes: Sequence[Node], count: int) -> list[Node]:
    """Returns the expressions; each of the first `count` coordinates is removed from those whose
    values do not depend on it."""
    found, here = list(nodes), Residues(g)
    for i in range(count if count <= MOST else 0):
        symbol = g.symbol(Symbol(Kind.COORDINATE, i))
        there = Residues(g, BIT[Kind.COORDINATE], i)
        found = _without(g, found, {symbol: ZERO}, here, here, there)
    return found


def without_attitudes(g: Graph, nodes: Sequence[Node], attitudes: Sequence[Attitude]) -> list[Node]:
    """Returns the expressions without the attitudes that they do not depend on at |Q| = 1."""
    found, here = list(nodes), Residues(g)
    for at in attitudes:
        if not at.numbers:
            continue
        w, *vector = numbers(g, at)
        unit = dict(zip(found, substituted(g, found, on_sphere(g, (at,))), strict=True))
        plain = {w: ONE, **dict.fromkeys(vector, ZERO)}
        found = _without(g, found, plain, here, lambda n, u=unit: here(u[n]), None)
    return found


def _without(
    g: Graph,
    nodes: Sequence[Node],
    plain: dict[Node, Node],
    here: Residues,
    value: Callable[[Node], int | None],
    there: Residues | None,
) -> list[Node]:
    """Substitutes `plain` in a node if that keeps its `value` and saves operations; with `there`,
    only in nodes whose value there is the same."""
    new = {}
    for node in dict.fromkeys(nodes):
        known = value(node)
        if known is None or (there is not None and there(node) != known):
            continue
        (made,) = substituted(g, [node], plain)
        if here(made) == known and operations(g, [made]) < operations(g, [node]):
            new[node] = made
    return [new.get(node, node) for node in nodes]


def to_be_shown(e: Equations) -> Equations:
    """Returns equations for display, with M and f free of attitudes they do not depend on."""
    if not e.attitudes:
        return e
    n = len(e.force)
    nodes = [*sum(e.mass, ()), *e.force]
    made = without_attitudes(e.graph, nodes, e.attitudes)
    mass = tuple(tuple(made[i * n : i * n + n]) for i in range(n))
    return replace(e, mass=mass, force=tuple(made[n * n :]))
