"""Removes coordinates and attitudes from expressions whose values do not depend on them.

For example, the inertia of a wheel about its axis contains sin(s)^2 + cos(s)^2, and the mass matrix
of a satellite with the attitude quaternion Q contains |Q|^4. Values modulo a prime show that such
an expression is constant (graph/residues.py). It is rewritten with s = 0, or with Q = 1."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from ..equations import Attitude, Equations
from ..graph.count import operations
from ..graph.graph import BIT, ONE, ZERO, Graph, Kind, Node, Symbol
from ..graph.residues import Residues
from ..graph.substitute import substituted
from .attitudes import numbers, on_sphere
from .motion import Motion

MOST = 24  # the largest number of coordinates: each takes a sweep over all expressions


def without_coordinates(g: Graph, nodes: Sequence[Node], count: int) -> list[Node]:
    """Returns the expressions. In expressions whose values do not depend on it, each of the first
    `count` coordinates is replaced by 0."""
    found, here = list(nodes), Residues(g)
    for i in range(count if count <= MOST else 0):
        symbol = g.symbol(Symbol(Kind.COORDINATE, i))
        there = Residues(g, BIT[Kind.COORDINATE], i)
        found = _without(g, found, {symbol: ZERO}, here, here, there)
    return found


def without_attitudes(g: Graph, nodes: Sequence[Node], attitudes: Sequence[Attitude]) -> list[Node]:
    """Returns the expressions. Each attitude is removed from the expressions whose values do not
    depend on it if its quaternion has length 1."""
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
    """Makes the substitutions `plain` in those nodes that have fewer operations afterwards and keep
    their values modulo a prime. `value` gives the value of a node before the substitutions, `here`
    the value after them. If `there` is given, nodes are skipped whose values by `there` and `value`
    differ."""
    new = {}
    for node in dict.fromkeys(nodes):
        known = value(node)
        if known is None or (there is not None and there(node) != known):
            continue
        (made,) = substituted(g, [node], plain)
        if here(made) == known and operations(g, [made]) < operations(g, [node]):
            new[node] = made
    return [new.get(node, node) for node in nodes]


Moving = TypeVar("Moving", Motion, Equations)


def rewritten(e: Moving, rewrite: Callable[[list[Node]], list[Node]]) -> Moving:
    """Returns the motion with the entries of M and f rewritten."""
    n = len(e.force)
    made = rewrite([*sum(e.mass, ()), *e.force])
    mass = tuple(tuple(made[i * n : i * n + n]) for i in range(n))
    return replace(e, mass=mass, force=tuple(made[n * n :]))


def to_be_shown(e: Equations) -> Equations:
    """Returns equations for display. In M and f, attitudes are removed from entries that do not
    depend on them."""
    return rewritten(e, lambda nodes: without_attitudes(e.graph, nodes, e.attitudes))
