"""Turns LoopEquations into blocks of C statements, such as bodies of terms and assignments.

A block is straight-line code. It first loads its inputs into local constants: in terms, for a
member m or a pair m and j, from the arrays s that members.h sets. Expressions of parameters and
sizes alone are hoisted into `prepare`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from ...graph.affine import OTHER, ROW, Affine
from ...graph.graph import Kind, Node, Symbol
from ...middle.loops.indexed_ir import Group, Slot
from ...middle.loops.indices import COUNTERS, unlike_loops
from ...middle.loops.loops import LoopEquations
from ..targets import LOAD, TRIG, Target
from .expressions import Code, variable
from .hoist import Hoisting, rewritten
from .names import FIELD_RESERVED, LOCAL_RESERVED, Names, local_wish
from .program import Statement, operations_in
from .rewrite import rewrite

# Local names in the templates; names from the model must differ from them.
_OURS = (
    *("m", "j", "l", "r", "s", "o", "lo", "hi", "base", "sum", "first", "last", "steps", "h", "g"),
    *("far", "total", "own", "once", *(f"at_{name[1:]}" for name in COUNTERS)),
    *("x", "cells", "pushes", "slopes", "changes", "front", "bulk", "beside", "beside_pushes"),
    *("pivot", "diagonal", "absent", "corner", "kept"),
)
INNER, TERMS, FIXED = "inner", "terms", "fixed"
SUFFIXES = {"v": "_dot", "w": "_ddot", "d": "_own", "a": "_acc", "acc": "_acc", "p": "_momentum"}
M, J = Affine(0, ((ROW, 1),)), Affine(0, ((OTHER, 1),))


@dataclass
class Block:
    """Straight-line code: the expressions to store (`targets`) and the C statements, which Lowering
    adds. `where` is INNER, TERMS or FIXED: how the block reads members of families. In TERMS,
    `reads` has the numbers of the arrays s that Lowering assigns."""

    targets: list[Target]
    where: str
    statements: list[Statement] = field(default_factory=list)
    reads: dict[Slot, int] = field(default_factory=dict)
    pairs: bool = False

    @staticmethod
    def of(kind: str, place: str, nodes: Iterable[Node], where: str) -> Block:
        """Returns a block that stores each node. The C variables are `place`, a format such as
        "r[{}]", filled with the number of the node."""
        targets = [Target(kind, place.format(k), (node,)) for k, node in enumerate(nodes)]
        return Block(targets, where)

    @property
    def operations(self) -> Counter[str]:
        return operations_in(self.statements)

    @property
    def trig(self) -> bool:
        return any(s.kind == TRIG for s in self.statements)

    @property
    def words(self) -> set[str]:
        """Returns the names of all variables and functions in the block."""
        return {name for s in self.statements for name in s.names}

    @property
    def nodes(self) -> list[Node]:
        return [node for target in self.targets for node in target.nodes]

    @property
    def value(self) -> str:
        """Returns the text of a block that consists of one expression."""
        [statement] = self.statements
        return statement.text


class Places:
    """The C names and array indices of a model's quantities: sizes, members of families, ranges."""

    def __init__(self, e: LoopEquations):
        self.equations = e
        fields = Names(FIELD_RESERVED, (), e.model.name + "_")
        self.sizes = {s.name: fields.take(s.name) for s in e.model.sizes}
        self.fields = {g.name: fields.take(g.name) for g in e.parameters}
        self.size_texts = {
            unlike_loops(name): f"p->{c_name}" for name, c_name in self.sizes.items()
        } | {name: f"at_{name[1:]}" for name in COUNTERS}
        for k in range(len(e.switches)):  # each switch's first and last index
            self.size_texts |= {f"least{k}'": f"p->side_lo_[{k}]", f"most{k}'": f"p->side_hi_[{k}]"}
        names = Names(frozenset())
        own = (*e.coordinates, *e.carried_groups)
        self.ids = {g.name: names.take(g.name) for g in own}  # name -> its part in C names
        # The name of the constraint row that expresses each recurrence.
        self.made = {g.name: names.take(f"of_{g.name}") for g in e.carried_groups}
        self.first: dict[str, Affine] = {}  # name -> array index of the first member
        total = Affine()
        for group in (*e.coordinates, *e.carried_groups):
            self.first[group.name] = total
            total = total + group.count
        self.whole = total  # length of the array q, which includes recurrence values
        total = Affine()
        self.lets: dict[str, tuple[Affine, Affine]] = {}  # name -> (offset, least index)
        for item in (item for found in e.along for item in found):
            self.lets[item.name] = total, item.group.lo
            total = total + item.group.count
        self.n_lets = total
        total = Affine()
        self.observed: list[Affine] = []  # Offset of each output, then the total length.
        for item in e.outputs:
            self.observed.append(total)
            total = total + item.count
        self.observed.append(total)
        total = Affine()
        for rows in e.bound:  # offsets in lambda
            self.first[rows.group.name] = total
            total = total + rows.group.count

    def index(self, at: Affine) -> str:
        """Returns an index expression as C."""
        return at.text(self.size_texts)

    def let(self, name: str, at: Affine) -> Affine:
        """Returns the place of member `at` of a recurrent `let`, which its previous member defines,
        in the array that stores the values of all recurrent `let`s."""
        first, lo = self.lets[name]
        return first + at - lo

    def names_in(self, at: Affine) -> tuple[str, ...]:
        return tuple(self.size_texts.get(name, name) for name, _ in at.terms)

    def flat(self, name: str, at: Affine | None) -> Affine:
        """Returns the index in the arrays q, v, ...: of the member `at` of a family, or of a scalar
        coordinate if `at` is None."""
        return self.first[name] if at is None else self.first[name] + at - self._lo(name)

    def _lo(self, name: str) -> Affine:
        e = self.equations
        rows = (bound.group for bound in e.bound)
        groups = (*e.coordinates, *e.parameters, *e.carried_groups, *rows)
        return next(g.lo for g in groups if g.name == name)

    def carried(self, kind: str, name: str, at: Affine) -> tuple[str, Affine]:
        """Returns the array and the index at which C stores a recurrence value, its rate or its
        acceleration. The array q has further sections behind the values and the rates: for the
        kinds "w", "d", "hung_p", "hung_f" (see Slot), in this order."""
        place, own = self.flat(name, at), self.equations.count
        behind = {"w": self.whole.times(2), "d": self.whole.times(3) - own}
        behind["hung_p"] = self.whole.times(4) - own.times(2)
        behind["hung_f"] = self.whole.times(5) - own.times(3)
        return ("q", place - own + behind[kind]) if kind in behind else (kind, place)

    def member(self, name: str, at: Affine | None) -> str:
        """Returns the C expression of a parameter, or of the member `at` of a family of
        parameters."""
        place = "" if at is None else f"[{self.index(at - self._lo(name))}]"
        return f"p->{self.fields[name]}{place}"

    def group(self, g: Group) -> dict[str, str | bool]:
        """Returns the template variables of a declaration: a coordinate, a parameter, or a family
        of these."""
        declared, family = g.declared, g.is_family
        unseen = "a body rate, in v" if g.is_turn else "a state, in v" if g.is_state else ""
        first = self.first.get(g.name, Affine())
        unit = f"[{declared.unit}]" if declared.unit else ""
        says = [x for x in (declared.description, unit) if x]
        return {
            "name": self.ids.get(g.name, g.name),
            "shown": g.shown,
            "is_family": family,
            "first": self.index(first),
            "lo": self.index(g.lo) if family else "0",
            "hi": self.index(g.hi) if family else "0",
            "count": self.index(g.count),
            "cell": self.index(first + M - g.lo if family else first),
            "says": ", ".join(x for x in (" ".join(says), unseen) if x),
            "lo_text": g.lo.text() if family else "",
            "hi_text": g.hi.text() if family else "",
            "first_text": first.text(),
        }


class Lowering(Hoisting):
    """Hoists constants out of all blocks and computes the blocks' statements."""

    def __init__(
        self,
        equations: LoopEquations,
        places: Places,
        libm: bool,
        blocks: list[Block],
        sides: Mapping[Node, tuple[Symbol, int]],
    ):
        super().__init__(equations.graph, equations.model.name, libm)
        for call, (side, sign) in sides.items():
            self.work.side(call, side, sign)
        self.states = {g.name for g in equations.states}
        self.equations, self.places, self.blocks = equations, places, blocks
        self.inputs = [q.name for q in equations.inputs]
        self._locals = Names(LOCAL_RESERVED, _OURS, self.prefix)
        self._names: dict[Slot, str] = {}
        self.carried = {g.name for g in equations.carried_groups}
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
        return Names(LOCAL_RESERVED, (*_OURS, *self._names.values()), self.prefix)

    def symbol(self, symbol: Symbol) -> Code:
        slot = self.equations.slots[symbol.index]
        if slot.kind == "size":
            size = self.places.size_texts[slot.name]
            return Code(f"(pk_real){size}", (size,))
        if symbol.kind is Kind.PARAMETER:
            return self._access(slot)
        return variable(self._local(slot))

    def _access(self, slot: Slot, block: Block | None = None) -> Code:
        """Returns the C expression that reads a slot's value. The names in the Code include the
        variables of the index."""
        places = self.places
        if block is not None and block.where == TERMS and slot.kind not in _DIRECT:
            number = block.reads.setdefault(slot, len(block.reads))
            return Code(f"s[{number}][{_stride(slot.at, block.pairs)}]", ("s", "k"))
        index = () if slot.at is None else places.names_in(slot.at)
        if slot.kind == "param":
            return Code(places.member(slot.name, slot.at), ("p", *index))
        if slot.kind == "index":
            name = places.size_texts.get(slot.name, slot.name)
            return Code(f"(pk_real){name}", (name,))
        if slot.kind == "sum":
            array = self.prefix + "sums"
            return Code(f"{array}(p)[{slot.name}]", (array, "p"))
        if slot.kind == "let":
            array, place = self.prefix + "lets", places.let(slot.name, slot.at)
            return Code(f"{array}(p)[{places.index(place)}]", (array, "p", *places.names_in(place)))
        if slot.kind == "input":
            return variable(f"u[{slot.name}]")
        if slot.kind == "place":
            return variable(slot.name)
        if slot.kind == "side":
            return self._side(slot)
        if slot.name in self.carried:
            array, place = places.carried(slot.kind, slot.name, slot.at)
            return Code(f"{array}[{places.index(place)}]", (array, *places.names_in(place)))
        if slot.kind in ("lambda", "p"):
            place = places.flat(slot.name, slot.at)
            array = self.prefix + ("momentum" if slot.kind == "p" else "lambda")
            return Code(f"{array}(p)[{places.index(place)}]", (array, "p", *places.names_in(place)))
        array, needs = ("q" if slot.kind == "q" else "v",) * 2
        if slot.kind in ("a", "acc"):
            memory = "rated" if slot.name in self.states else "accelerated"
            array, needs = f"{self.prefix}{memory}(p)", self.prefix + memory
        first = places.names_in(places.first[slot.name])
        text = f"{array}[{places.index(places.flat(slot.name, slot.at))}]"
        return Code(text, (needs, "p", *first, *index))

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

    def _written(self, targets: list[Target], block: Block) -> list[Statement]:
        # The inputs (slots) of the block get names before its other local variables do.
        slots = []
        for node in self.work.reachable([n for t in targets for n in t.nodes]):
            symbol = self.work.data[node]
            if isinstance(symbol, Symbol) and symbol.kind not in (Kind.PI, Kind.TIME):
                slots.append(self.equations.slots[symbol.index])
                self._local(slots[-1])
        schedule = self.scheduled(targets, self._free(), block.where == FIXED)
        used = {name for s in schedule.statements for value in s.values for name in value.names}
        loads = [
            Statement.of(LOAD, self._local(slot), self._access(slot, block))
            for slot in slots
            if self._local(slot) in used and slot.kind != "size"
        ]
        return [*loads, *schedule.statements]


# Kinds of symbols that terms do not read by their arrays s.
_DIRECT = ("param", "size", "index", "input", "sum", "place")


def _stride(at: Affine | None, pairs: bool) -> str:
    """Returns the index in an array s of what a term reads for member k, or for pair k of a
    member."""
    step = 0 if at is None else at.factor(OTHER if pairs else ROW)
    return {0: "0", 1: "k", -1: "-k"}.get(step, f"{step} * k")


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
