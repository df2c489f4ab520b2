"""Expressions without the coordinates and attitudes that they only seem to depend on.

The inertia of a wheel about its axis has sin(s)^2 + cos(s)^2 in it, the mass of a satellite |Q|^4.
Values modulo a prime tell such an expression from one that varies (graph/residues.py); it is
written with the angle 0, or without the rotation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..equations import Attitude, Equations
from ..graph.count import operations
from ..graph.graph import BIT, ONE, ZERO, Graph, Kind, Node, Symbol
from ..graph.residues import Residues
from ..graph.substitute import substituted
from .attitudes import numbers, on_sphere

MOST = 24  # coordinates: each takes a sweep of all expressions


def without_coordinates(g: Graph, nodes: Sequence[Node], count: int) -> list[Node]:
    """The same expressions, of which none depends on one of the first `count` coordinates where its
    value does not."""
    found, here = list(nodes), Residues(g)
    for i in range(count if count <= MOST else 0):
        symbol = g.symbol(Symbol(Kind.COORDINATE, i))
        there = Residues(g, BIT[Kind.COORDINATE], i)
        found = _without(g, found, {symbol: ZERO}, here, here, there)
    return found


def without_attitudes(g: Graph, nodes: Sequence[Node], attitudes: Sequence[Attitude]) -> list[Node]:
    """The same for attitudes, whose quaternions are of length 1."""
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
    """Expressions with the `plain` nodes put in, where their `value` stays the same; only those
    tried that have it `there` too."""
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
    """With M and f free of attitudes on which they do not depend."""
    if not e.attitudes:
        return e
    n = len(e.force)
    nodes = [*sum(e.mass, ()), *e.force]
    made = without_attitudes(e.graph, nodes, e.attitudes)
    mass = tuple(tuple(made[i * n : i * n + n]) for i in range(n))
    return replace(e, mass=mass, force=tuple(made[n * n :]))
