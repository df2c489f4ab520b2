"""What the equations of families kept as loops divide by, or take a root or a logarithm of, where
that may vanish: a guard is one expression (see guards.py), so the members of a family have none,
and no step sees a singularity of theirs. That has to be said.
"""

from __future__ import annotations

from .affine import OTHER, ROW
from .graph import BIT, Graph, Kind, Node, Symbol
from .guards import dangerous, zeros
from .loops import LoopEquations
from .loops_expand import LoopExpander, unlike_loops
from .loops_facts import vector_nodes
from .ranges import INF, Range, Ranges
from .wording import wording

MOVES = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.TIME]
_PRIMES = {"v": "'", "d": "'"}


def unwatched_of(x: LoopExpander, e: LoopEquations) -> tuple[str, ...]:
    """The expressions that may vanish, in the order in which the equations have them."""
    g = x.graph
    ranges = Ranges(g, [])
    ranges.known.update(_known(x, e))
    entries = [part.node for row in e.mass.entries.values() for part in row.parts]
    found = [
        node
        for base, _ in dangerous(g, ranges, [*vector_nodes(e.force), *entries])
        for node, _ in zeros(g, ranges, base)
    ]
    for (name, other, distance), row in e.mass.entries.items():
        if e.mass.is_diagonal and name == other and distance == 0 and len(row.parts) == 1:
            found += [node for node, _ in zeros(g, ranges, row.parts[0].node)]
    shown = {unlike_loops(size.name): size.name for size in e.model.sizes} | {ROW: "i", OTHER: "j"}

    def name(symbol: Symbol) -> str:
        if symbol.kind is Kind.TIME:
            return "t"
        slot = x.slots[symbol.index]
        at = "" if slot.at is None else f"[{slot.at.text(shown).replace(' ', '')}]"
        return slot.name + at + _PRIMES.get(slot.kind, "")

    return tuple(dict.fromkeys(wording(g, n, name) for n in found if g.depends[n] & MOVES))


def _known(x: LoopExpander, e: LoopEquations) -> dict[Node, Range]:
    """The ranges of parameters, those of a family's members too, and of sizes and indices."""
    g, found = x.graph, {}
    bounds = dict(zip(x.parameters, e.bounds, strict=True))
    for slot in list(x.slots):
        if slot.kind == "param":
            given, own = x.parameters[slot.name].declared.bounds, bounds[slot.name]
            lo, hi = _number(g, own.lo, -INF), _number(g, own.hi, INF)
            found[x.slot("param", slot.name, slot.at)] = Range(lo, hi, given.lo_open, given.hi_open)
        elif slot.kind == "size":
            found[x.slot("size", slot.name, slot.at)] = Range(1)
    return found


def _number(g: Graph, node: Node | None, otherwise: float) -> float:
    value = None if node is None else g.value(node)
    return otherwise if value is None else float(value)
