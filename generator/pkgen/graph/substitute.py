"""Simultaneous substitution of nodes in expressions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .differentiate import reachable
from .graph import Graph, Node, Op


def substituted(g: Graph, nodes: Iterable[Node], swap: Mapping[Node, Node]) -> list[Node]:
    """Returns the nodes after replacing each key of `swap` by its value. Nothing is replaced in the
    values, so that q_1 and q_2 can be exchanged."""
    nodes = list(nodes)
    new = dict(swap)
    for node in reachable(g, nodes):
        if node in new:
            continue
        args = [new[a] for a in g.args[node]]
        same = all(a == b for a, b in zip(args, g.args[node], strict=True))
        new[node] = node if same else rebuilt(g, node, args)
    return [new[node] for node in nodes]


def rebuilt(g: Graph, node: Node, args: list[Node]) -> Node:
    """Returns a node with the operation of `node` and the arguments `args`."""
    op = g.op[node]
    if op is Op.ADD:
        return g.add(*args)
    if op is Op.MULTIPLY:
        return g.multiply(*args)
    if op is Op.POWER:
        return g.power(args[0], g.data[node])
    return g.call(g.data[node], *args)
