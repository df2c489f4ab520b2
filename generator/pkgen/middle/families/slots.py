"""The table of symbols of a graph in models with loops. A Slot (indexed_ir.py) is the meaning of a
symbol, such as q[m+1]. Has functions that replace symbols in expressions or shift their indices."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable

from ...graph.affine import COUNTERS, LOOPS, OTHER, ROW, Affine, variable
from ...graph.differentiate import reachable
from ...graph.graph import ZERO, Graph, Kind, Node, Op, Symbol
from ...graph.substitute import substituted
from .indexed_ir import Slot

M, J = variable(ROW), variable(OTHER)

# A Slot is a number that the body of a loop reads, such as q[i]. Maps its kind to the kind of its
# symbol in the graph. Code that depends on symbols of kind PARAMETER alone is moved before all
# loops.
_KINDS = {
    "q": Kind.COORDINATE,
    "s": Kind.STATE,
    **dict.fromkeys(("v", "d"), Kind.RATE),
    **dict.fromkeys(("param", "size"), Kind.PARAMETER),
    **dict.fromkeys(
        ("input", "index", "sum", "w", "a", "p", "place", "lambda", "let", "acc", "side"),
        Kind.INPUT,
    ),
    **dict.fromkeys(("hung_p", "hung_f"), Kind.INPUT),
}


def _domain(slot: Slot) -> str:
    """Returns the kind (Kind) of the graph's symbol that stands for a Slot."""
    if slot.kind == "param" and slot.at is not None and any(slot.at.factor(v) for v in LOOPS):
        # the parameter depends on a loop variable, and is computed inside the loop
        return Kind.INPUT
    return _KINDS[slot.kind]


class Slots:
    """The symbols of one graph and their meanings (Slot). `node` adds new ones."""

    def __init__(self, g: Graph, slots: Iterable[Slot] = ()):
        self.graph = g
        self._places: dict[Slot, int] = {slot: k for k, slot in enumerate(slots)}
        self.all = list(self._places)

    def node(self, kind: str, name: str, at: Affine | None = None) -> Node:
        """Returns the symbol with this kind, name and index, as a node."""
        slot = Slot(kind, name, at)
        if slot not in self._places:
            self._places[slot] = len(self.all)
            self.all.append(slot)
        return self.graph.symbol(Symbol(_domain(slot), self._places[slot]))

    def number(self, at: Affine) -> Node:
        """Returns a node with the value of an index expression."""
        g = self.graph
        total = g.number(at.constant)
        for name, factor in at.terms:
            kind = "index" if name in (*LOOPS, *COUNTERS) else "size"
            total = g.add(total, g.multiply(g.number(factor), self.node(kind, name)))
        return total

    def of(self, node: Node) -> Slot | None:
        """Returns the Slot for which a symbol stands; None if the node is no such symbol."""
        data = self.graph.data[node]
        if isinstance(data, Symbol) and data.kind not in (Kind.PI, Kind.TIME):
            return self.all[data.index]
        return None

    def below(self, *nodes: Node) -> list[Slot]:
        """Returns the meanings of the symbols in the given nodes, in the order of the symbols' node
        numbers."""
        g = self.graph
        found = (self.of(n) for n in reachable(g, nodes) if g.op[n] is Op.SYMBOL)
        return [slot for slot in found if slot is not None]

    def swapped(self, node: Node, swap: Callable[[Slot], Node | None]) -> Node:
        """Returns the node after substitutions of symbols. `swap` maps the meaning of a symbol to
        the node that replaces the symbol, or to None if the symbol is kept."""
        values = {}
        for slot in self.below(node):
            value = swap(slot)
            if value is not None:
                values[self.node(slot.kind, slot.name, slot.at)] = value
        return substituted(self.graph, [node], values)[0] if values else node

    def shifted(self, node: Node, shift: int) -> Node:
        """Returns the expression with m replaced by m + shift."""
        g = self.graph

        def swap(slot: Slot) -> Node | None:
            if slot.kind == "index" and slot.name == ROW:
                return g.add(self.node(slot.kind, slot.name), g.number(shift))
            factor = 0 if slot.at is None else slot.at.factor(ROW)
            return self.node(slot.kind, slot.name, slot.at + shift * factor) if factor else None

        return self.swapped(node, swap)

    def inside(self, node: Node, carried: Container[str]) -> Node:
        """Returns the node in the form that is valid for an index m far from the ends of families
        (in the interior). There it contains no members with prescribed values. Symbols of kind "d"
        therefore become symbols of kind "v", and symbols of kind "w" become 0. Symbols of
        recurrences are kept; `carried` has their names."""

        def swap(slot: Slot) -> Node | None:
            if slot.name in carried:
                return None
            if slot.kind == "d":
                return self.node("v", slot.name, slot.at)
            return ZERO if slot.kind == "w" else None

        return self.swapped(node, swap)
