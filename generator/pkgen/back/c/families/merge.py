"""Merges the terms that are added to one row: from sum(V(q[i], q[i+1]), i = 0..N), for example, row
m gets terms of V at m - 1 and at m. If both are cheap, they become one term for each row. Then no
terms are stored between two loops, though each is computed twice."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ....graph.affine import ROW
from ....graph.collect import fewest
from ....graph.count import operations
from ....graph.differentiate import reachable
from ....graph.graph import Graph, Node, Op
from ....middle.families.indexed_ir import CELLS, Addend, Cell, Group
from ....middle.families.slots import M, Slots
from .readers import beyond

MOST = 20  # operations of all merged terms


def moves(cell: Cell) -> bool:
    """Returns whether the index of a cell is m plus a constant."""
    at = cell[1]
    return at is not None and at.factor(ROW) == 1 and at.without(ROW).is_constant


def merged(
    outputs: Sequence[Iterable[Addend]], groups: Sequence[Group], slots: Slots, wraps: dict
) -> list[list[Addend]] | None:
    """Returns the addends with one for each row of families, or None if this is not possible or not
    cheaper."""
    by_name = {g.name: g for g in groups}
    g, found, sums = slots.graph, [], 0
    for addends in outputs:
        rows: dict[str, list[Node]] = {}
        for x in addends:
            group = by_name.get(x.to[0][0])
            if len(x.over) != 2 or group is None or not group.is_family or not moves(x.to[0]):
                return None
            node = _at_row(x, group, slots, wraps)
            if node is None:
                return None
            rows.setdefault(group.name, []).append(node)
        sums += sum(len(nodes) > 1 for nodes in rows.values())
        found.append({name: g.sum(nodes) for name, nodes in rows.items()})
    nodes = [node for rows in found for node in rows.values()]
    if not sums or not _is_simple(g, nodes) or operations(g, fewest(g, nodes)) > MOST:
        return None
    return [
        [Addend((by_name[k].lo, by_name[k].hi), node, ((k, M),)) for k, node in rows.items()]
        for rows in found
    ]


def _at_row(x: Addend, g: Group, slots: Slots, wraps: dict) -> Node | None:
    """Returns the addend to row m of the family, or None if not all rows have it, or if a free end
    or an index in a ring makes rows differ."""
    shift = (x.to[0][1] - M).constant
    lo, hi = x.over[0] + shift, x.over[1] + shift
    node = slots.shifted(x.node, -shift)
    if g.periodic:
        around = hi - lo == g.hi - g.lo and _is_alike(node, g, slots)
        return node if around else None
    ends = (g.lo - lo, hi - g.hi)
    whole = all(end.is_constant and end.constant >= 0 for end in ends)
    return node if whole and beyond(g, wraps.get(g.name, 0)) == (0, 0) else None


def _is_alike(node: Node, g: Group, slots: Slots) -> bool:
    """Returns whether an expression depends on the index only by members of rings like g."""
    found = (s for s in slots.below(node) if s.kind == "index" or (s.at and s.at.factor(ROW)))
    return all(s.kind in CELLS and s.name == g.name and s.at.factor(ROW) == 1 for s in found)


def _is_simple(g: Graph, nodes: list[Node]) -> bool:
    """Returns whether there are only sums and products."""
    return all(
        g.op[n] is not Op.CALL and (g.op[n] is not Op.POWER or g.data[n] in (2, 3, 4))
        for n in reachable(g, nodes)
    )
