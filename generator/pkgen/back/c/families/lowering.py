"""Turns FamilyEquations into blocks of C statements, such as bodies of terms and assignments.

A block is straight-line code. It first loads its inputs into local constants: in terms, for a
member m or a pair m and j, by pointers to successive members (Window). Expressions of parameters
and sizes alone are hoisted into `prepare`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from ....graph.affine import COUNTERS, OTHER, ROW, Affine
from ....graph.graph import Kind, Node, Symbol
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Slot
from ...targets import LOAD, Target
from ..expressions import Code, variable
from ..hoist import Hoisting, rewritten
from ..names import LOCAL_RESERVED, Names, local_wish
from ..program import Statement
from ..rewrite import rewrite
from .blocks import FIXED, TERMS, Block, Window
from .places import Places
from .readers import SUFFIXES, Readers

# Local names in the templates; names from the model must differ from them.
_OURS = (
    *("m", "j", "l", "r", "o", "lo", "hi", "base", "sum", "first", "last", "steps", "h", "g"),
    *("row", "from"),
    *("far", "total", "own", "once", *(f"at_{name[1:]}" for name in COUNTERS)),
    *("x", "cells", "pushes", "slopes", "changes", "front", "bulk", "beside", "beside_pushes"),
    *("pivot", "diagonal", "absent", "corner", "kept"),
)


class Lowering(Hoisting):
    """Hoists constants out of all blocks and computes the blocks' statements."""

    def __init__(
        self,
        equations: FamilyEquations,
        places: Places,
        libm: bool,
        blocks: list[Block],
        sides: Mapping[Node, tuple[Symbol, int]],
        readers: Readers,
    ):
        super().__init__(equations.graph, equations.model.name, libm)
        for call, (side, sign) in sides.items():
            self.work.side(call, side, sign)
        blocks = [*{id(block): block for block in blocks}.values()]
        self.equations, self.places, self.blocks = equations, places, blocks
        self.readers, self.tables = readers, places.tables
        self.inputs = [q.name for q in equations.inputs]
        self._locals = Names(LOCAL_RESERVED, _OURS, self.prefix)
        self._names: dict[Slot, str] = {}
        self._pointers: dict[Slot, str] = {}  # of windows
        targets = []
        for block in blocks:
            new = rewrite(self.work, block.nodes, gather=block.where != FIXED)
            targets.append(rewritten(block.targets, new))
        roots = [
            node
            for block, found in zip(blocks, targets, strict=True)
            if block.where != FIXED
            for target in found
            for node in target.nodes
        ]
        self.prepare = self.hoist(roots, self._free()).statements
        for block, found in zip(blocks, targets, strict=True):
            block.statements = self._written(found, block)

    def _free(self) -> Names:
        return Names(
            LOCAL_RESERVED, (*_OURS, *self._names.values(), *self._pointers.values()), self.prefix
        )

    def symbol(self, symbol: Symbol) -> Code:
        slot = self.equations.slots[symbol.index]
        if slot.kind == "size":
            size = self.places.size_texts[slot.name]
            return Code(f"(pk_real){size}", (size,))
        if symbol.kind is Kind.PARAMETER:
            return self._access(slot)
        return variable(self._local(slot))

    def _access(self, slot: Slot) -> Code:
        """Returns the C expression that reads a slot's value. The names in the Code include the
        variables of the index."""
        places = self.places
        index = () if slot.at is None else places.names_in(slot.at)
        if slot.kind == "param":
            return Code(places.member(slot.name, slot.at), ("p", *index))
        if slot.kind == "index":
            name = places.size_texts.get(slot.name, slot.name)
            return Code(f"(pk_real){name}", (name,))
        if slot.kind == "sum":
            array = self.prefix + "sums"
            return Code(f"{array}(p)[{slot.name}]", (array, "p"))
        if slot.kind == "input":
            return variable(f"u[{slot.name}]")
        if slot.kind == "place":
            return variable(slot.name)
        if slot.kind == "side":
            return self._side(slot)
        array, place = places.stored(slot)
        text = f"{array}[{places.index(place)}]"
        return Code(text, (array.removesuffix("(p)"), "p", *index, *places.names_in(place)))

    def _side(self, slot: Slot) -> Code:
        """Returns the C expression that reads the side (sign) of a switch at an index."""
        at, reader = slot.at or Affine(), f"{self.prefix}side"
        names = (reader, "p", *self.places.names_in(at))
        return Code(f"{reader}(p, {slot.name}, {self.places.index(at)})", names)

    def _local(self, slot: Slot) -> str:
        if slot not in self._names:
            if slot.kind == "input":
                wish = local_wish(self.inputs[int(slot.name)])
            elif slot.kind == "sum":
                wish = f"sum_{slot.name}"
            elif slot.kind == "side":
                wish = f"side_{slot.name}{_place(slot.at)}"
            elif slot.kind == "index":
                wish = f"real_{self.places.size_texts.get(slot.name, slot.name)}"
            elif slot.kind == "place":
                wish = re.sub(r"\W+", "_", slot.name.replace("-", "m")).strip("_")
            else:
                suffix = SUFFIXES.get(slot.kind, "") + "_dot" * slot.name.count("'")
                name = slot.name.replace("'", "")
                wish = self.places.ids.get(name, name) + _place(slot.at) + suffix
            self._names[slot] = self._locals.take(wish)
        return self._names[slot]

    def _pointer(self, slot: Slot) -> str:
        """Returns the name of the C pointer to the members around a slot."""
        key = replace(slot, at=slot.at - slot.at.constant)
        if key not in self._pointers:
            self._pointers[key] = self._locals.take(f"{self._local(key).rstrip('_')}_row")
        return self._pointers[key]

    def _written(self, targets: list[Target], block: Block) -> list[Statement]:
        # The inputs (slots) of the block get names before its other local variables do.
        slots = []
        for node in self.work.reachable([n for t in targets for n in t.nodes]):
            symbol = self.work.data[node]
            if isinstance(symbol, Symbol) and symbol.kind not in (Kind.PI, Kind.TIME):
                slots.append(self.equations.slots[symbol.index])
                self._local(slots[-1])
                if block.where == TERMS and slots[-1].at is not None:
                    self._pointer(slots[-1])
        schedule = self.scheduled(targets, self._free(), block.where == FIXED)
        used = {name for s in schedule.statements for value in s.values for name in value.names}
        read = [s for s in slots if self._local(s) in used and s.kind != "size"]
        if block.where == TERMS:
            return [*self._reads(read, block), *schedule.statements]
        loads = [Statement.of(LOAD, self._local(slot), self._access(slot)) for slot in read]
        return [*loads, *schedule.statements]

    def _reads(self, slots: list[Slot], block: Block) -> list[Statement]:
        """Returns the loads of a term for one index. Adds to the block the windows that these read,
        and the loads that are the same for all indices."""
        running = OTHER if block.pairs else ROW
        windows: dict[Slot, Window] = {}
        found: list[tuple[Slot, Code | None]] = []
        for slot in slots:
            step = 0 if slot.at is None else slot.at.factor(running)
            if slot.kind in _DIRECT:
                found.append((slot, self._access(slot)))
            elif step == 1 and not block.sequence:
                shift = slot.at.constant
                key = replace(slot, at=slot.at - shift)
                if key not in windows:
                    windows[key] = Window(key, self._pointer(slot), shift, shift)
                windows[key].low = min(windows[key].low, shift)
                windows[key].high = max(windows[key].high, shift)
                found.append((slot, None))
            elif step == 0:
                code = self.readers.member(slot, block.over)
                block.once.append(Statement.of(LOAD, self._local(slot), code))
            else:
                found.append((slot, self.readers.member(slot, block.over)))
        block.windows = [*windows.values()]
        loads = []
        for slot, code in found:
            if code is None:
                window = windows[replace(slot, at=slot.at - slot.at.constant)]
                code = Code(window.text(slot.at.constant), (window.pointer, "k"))
            loads.append(Statement.of(LOAD, self._local(slot), code))
        return loads


# Kinds of symbols that terms do not read from arrays of members.
_DIRECT = ("param", "size", "index", "input", "sum", "place")


def _place(at: Affine | None) -> str:
    """Returns an index as part of a C name: m + 1 as p1, m - 2 as m2, j as _j, 3 as _at_3."""
    if at is None:
        return ""
    for name, mark in ((ROW, ""), (OTHER, "j")):
        if at.factor(name) == 1 and at.without(name).is_constant:
            shift = at.constant
            return (
                ("_" if mark or shift else "")
                + mark
                + ("" if not shift else f"{'p' if shift > 0 else 'm'}{abs(shift)}")
            )
    return "_at_" + re.sub(r"\W+", "_", at.text())
