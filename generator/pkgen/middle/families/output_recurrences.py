"""Recurrences that only outputs use: indexed `let` definitions from their own lower members.

The equations of motion do not contain them, so that any expressions are allowed. Their values are
computed in a loop over the index and stored before outputs are computed; so are their time
derivatives if an output uses them.
"""

from __future__ import annotations

from ...graph.affine import ROW, Affine
from ...graph.graph import ZERO, Node
from ..expand.names import Value
from .equations import Along
from .expand import FamilyExpander
from .indexed_ir import Addend, Group, NotKept, Slot, Sum, nodes_of
from .rows import Assembler
from .slots import M


class Alongside:
    """Collects the `let` definitions that only outputs use, while these are converted to nodes."""

    def __init__(self, x: FamilyExpander, assembler: Assembler):
        self.x, self.assembler = x, assembler
        # The expressions by name. The name of a time derivative ends with '.
        self.parts: dict[str, Sum] = {}
        self.groups: dict[str, Group] = {}
        self._components: dict[str, tuple[str, ...]] = {}

    def member(self, name: str, index: Affine) -> Value:
        if name not in self._components:
            self._enter(name)
        keys = self._components[name]
        group = self.groups[keys[0]]
        self.x.members.append((group.lo, group.hi, index))
        nodes = tuple(self.x.slots.node("let", key, index) for key in keys)
        return nodes if len(nodes) > 1 else nodes[0]

    def rate(self, slot: Slot) -> Node:
        key = f"{slot.name}'"
        if key not in self.groups:
            self.groups[key] = self.groups[slot.name]
            by = self.x.derivative
            parts = (Addend(p.over, by(p.node), ((key, M),)) for p in self.parts[slot.name])
            self.parts[key] = tuple(part for part in parts if part.node != ZERO)
        return self.x.slots.node("let", key, slot.at)

    def _enter(self, name: str) -> None:
        x = self.x
        self._components[name], groups = x.groups_of(name)
        self.groups |= {g.name: g for g in groups}
        found: list[list[Addend]] = [[] for _ in groups]
        met, x.members = x.members, []
        for lo, hi, item in x.pieces(name):
            value = x.value(item.value, x.loop_of(item))
            nodes = value if isinstance(value, tuple) else (value,)
            self.assembler.limits += x.limits_over(lo, hi)
            for group, node, parts in zip(groups, nodes, found, strict=True):
                for slot in x.slots.below(node):
                    if slot.at is not None and slot.at.factor(ROW):
                        self.assembler.member(slot, lo, hi)
                parts.append(Addend((lo, hi), node, ((group.name, M),)))
        x.members = met
        for group, parts in zip(groups, found, strict=True):
            self.parts[group.name] = tuple(parts)

    # -- order of computation -----------------------------------------------------------------

    def passes(self) -> tuple[tuple[Along, ...], ...]:
        """Returns tuples of definitions, in the order in which they can be computed. Definitions
        that depend on each other are in the same tuple. Its definitions are computed together, one
        after the other for each index."""
        left, found = dict.fromkeys(self.parts), []
        below = {key: self._below(key) for key in left}
        while left:
            first = next(iter(left))
            together = [k for k in left if k in below[first] and first in below[k]] or [first]
            for key in together:
                left.pop(key)
            found.append(tuple(self._in_order(together)))
        return tuple(found)

    def _direct(self, key: str, own: bool = False) -> set[str]:
        """Returns the names of the definitions that occur in the definition with the name `key`.
        With `own`, definitions that occur only with other indices than m are left out."""
        slots = self.x.slots.below(*nodes_of(self.parts[key]))
        lets = [slot for slot in slots if slot.kind == "let"]
        return {s.name for s in lets if not own or s.at == Affine(0, ((ROW, 1),))}

    def _below(self, key: str) -> set[str]:
        found, waiting = set(), [key]
        while waiting:
            new = self._direct(waiting.pop()) - found
            found |= new
            waiting += new
        return found

    def _in_order(self, keys: list[str]) -> list[Along]:
        left, found = dict.fromkeys(keys), []
        while left:
            ready = [k for k in left if not self._direct(k, own=True) & left.keys() - {k}]
            if not ready:
                raise NotKept(f"the members of '{keys[0]}' define each other")
            for key in ready:
                left.pop(key)
                found.append(Along(key, self.groups[key], self.parts[key]))
        return found
