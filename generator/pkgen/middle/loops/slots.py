"""Slots in expressions: which there are, and others in their place."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...graph.affine import ROW
from ...graph.differentiate import reachable
from ...graph.graph import Graph, Kind, Node, Op
from .expand import LoopExpander
from .loops import Slot


def slots_of(x: LoopExpander, nodes: list[Node]) -> list[Slot]:
    """The slots that some nodes need, in the order in which they were met first."""
    found = (x.slot_of(n) for n in reachable(x.graph, nodes) if x.graph.op[n] is Op.SYMBOL)
    return [slot for slot in found if slot is not None]


def substitute(g: Graph, node: Node, values: dict[Node, Node]) -> Node:
    """The node with symbols replaced."""
    known = dict(values)
    for n in reachable(g, [node]):
        if n in known:
            continue
        args = [known[a] for a in g.args[n]]
        op = g.op[n]
        if tuple(args) == g.args[n]:
            known[n] = n
        elif op is Op.ADD:
            known[n] = g.add(*args)
        elif op is Op.MULTIPLY:
            known[n] = g.multiply(*args)
        elif op is Op.POWER:
            known[n] = g.power(args[0], g.data[n])
        else:
            known[n] = g.call(g.data[n], *args)
    return known[node]


def shifted(
    g: Graph, node: Node, shift: int, slots: Sequence[Slot], symbol: Callable[[Slot], Node]
) -> Node:
    """The same expression in the row m + shift."""
    values = {}
    for n in reachable(g, [node]):
        data = g.data[n]
        if g.op[n] is not Op.SYMBOL or data.kind in (Kind.PI, Kind.TIME):
            continue
        slot = slots[data.index]
        if slot.kind == "index" and slot.name == ROW:
            values[n] = g.add(n, g.number(shift))
        elif slot.at is not None and slot.at.factor(ROW):
            at = slot.at + shift * slot.at.factor(ROW)
            values[n] = symbol(Slot(slot.kind, slot.name, at))
    return substitute(g, node, values)
