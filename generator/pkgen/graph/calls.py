"""Tests whether nodes call functions with kinks or jumps."""

from __future__ import annotations

from collections.abc import Iterable

from ..functions import FUNCTIONS
from .graph import VARIABLE, Graph, Node, Op


def smooth(g: Graph, nodes: Iterable[Node]) -> bool:
    """Whether no call among the nodes has a kink or a jump."""
    return all(FUNCTIONS[g.data[node]].smooth for node in nodes if g.op[node] is Op.CALL)


def expandable(g: Graph, nodes: Iterable[Node], in_pieces: bool) -> bool:
    """Whether the recurrences of Taylor coefficients are known of all calls among the nodes.
    Functions with a kink count if a run ends its steps there (`in_pieces`)."""

    def known(node: Node) -> bool:
        row = FUNCTIONS[g.data[node]]
        if row.kinked and in_pieces:
            return not row.kinked.place
        still = not any(g.depends[a] & VARIABLE for a in g.args[node][1:])
        return still and row.series is not None

    return all(known(node) for node in nodes if g.op[node] is Op.CALL)


def jumps(g: Graph, node: Node) -> bool:
    """Whether a node is a call that jumps at the zero of its argument."""
    row = FUNCTIONS[g.data[node]] if g.op[node] is Op.CALL else None
    return row is not None and bool(row.kinked and row.jump)


def counts(g: Graph, node: Node) -> bool:
    """Whether a node is a function u at whose integers another function jumps (Kinked.place)."""
    return g.op[node] is Op.CALL and FUNCTIONS[g.data[node]].counted
