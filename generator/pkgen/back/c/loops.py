"""LoopEquations -> blocks of C statements: bodies of loops, guarded parts of rows, assignments.

A block is straight-line code in the index m (and j, in a pair); what it reads is loaded into
locals, from the arrays directly where no end is near, else through functions that know what lies
beyond an end. What depends on parameters and sizes alone is hoisted into `prepare`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from ...graph.affine import LOOPS, OTHER, ROW, Affine
from ...graph.graph import Kind, Node, Op, Symbol
from ...middle.loops.expand import unlike_loops
from ...middle.loops.loops import LoopEquations, Slot
from ...middle.quantities import input_quantities
from ..targets import LOAD, STORE, TRIG, Target
from .expressions import Code, variable
from .literals import PI
from .names import FIELD_RESERVED, LOCAL_RESERVED, Names, local_wish
from .program import Statement, operations_in
from .rewrite import Workspace, rewrite
from .schedule import Schedule, number_text

# Names of the templates where the model's own are written beside them.
_OURS = (
    *("m", "j", "l", "r", "s", "lo", "hi", "base", "sum", "first", "last", "steps", "h", "g"),
    *("flux", "total", "own"),
)
INNER, EDGE, PAIR, FIXED = "inner", "edge", "pair", "fixed"


@dataclass
class Block:
    """Statements to come; `where` says how members are reached. Filled by Lowering.finish."""

    targets: list[Target]
    where: str
    rewritten: list[Target] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    operations: Counter[str] = field(default_factory=Counter)

    @property
    def trig(self) -> bool:
        return any(s.kind == TRIG for s in self.statements)

    @property
    def words(self) -> set[str]:
        """Variables and functions of the model in the block."""
        return {name for s in self.statements for name in s.names}


class Lowering:
    """Collects blocks, hoists what they share, and writes them out."""

    def __init__(self, equations: LoopEquations, libm: bool):
        self.libm = libm
        self.equations = equations
        self.prefix = equations.model.name + "_"
        self.work = Workspace(equations.graph)
        self.blocks: list[Block] = []
        self.hoisted: dict[Node, int] = {}
        self.helpers: set[str] = set()
        self.prepare: list[Statement] = []
        fields = Names(FIELD_RESERVED, (), self.prefix)
        self.sizes = {s.name: fields.take(s.name) for s in equations.model.sizes}
        self.fields = {g.name: fields.take(g.name) for g in equations.parameters}
        self.size_texts = {
            unlike_loops(name): f"p->{c_name}" for name, c_name in self.sizes.items()
        }
        self.first = _firsts(equations)
        self.inputs = [q.name for q in input_quantities(equations.model, equations.orders)]
        self._locals = Names(LOCAL_RESERVED, _OURS, self.prefix)
        self._names: dict[Slot, str] = {}

    # -- text ---------------------------------------------------------------------------------

    def index(self, at: Affine) -> str:
        """An index as C."""
        return at.text(self.size_texts)

    def cell(self, array: str, name: str, at: Affine | None) -> str:
        """A member of q, v, ... (at is None: of a scalar coordinate)."""
        group = self.equations.group(name)
        flat = self.first[name] if at is None else self.first[name] + at - group.lo
        return f"{array}[{self.index(flat)}]"

    def member(self, name: str, at: Affine | None) -> str:
        """A parameter."""
        if at is None:
            return f"p->{self.fields[name]}"
        group = next(g for g in self.equations.parameters if g.name == name)
        return f"p->{self.fields[name]}[{self.index(at - group.lo)}]"

    def _access(self, slot: Slot, where: str) -> Code:
        """Where a slot's value is read from, and the variables in that."""
        index = () if slot.at is None else self._names_in(slot.at)
        if slot.kind == "param":
            return Code(self.member(slot.name, slot.at), ("p", *index))
        if slot.kind == "index":
            name = ROW if slot.name == ROW else OTHER
            return Code(f"(pk_real){name}", (name,))
        if slot.kind in ("input", "sum"):
            return variable(f"{'u' if slot.kind == 'input' else 'sum'}[{slot.name}]")
        if slot.kind == "flux":
            return variable(flux_place(int(slot.name), -slot.at.constant))
        near = (
            slot.at is None or where in (INNER, PAIR) or not any(slot.at.factor(v) for v in LOOPS)
        )
        array = {"q": "q", "v": "v", "w": "v", "d": "v"}[slot.kind]
        if near:
            first = self._names_in(self.first[slot.name])
            return Code(self.cell(array, slot.name, slot.at), (array, *first, *index))
        reader = f"{self.prefix}{slot.kind}_{slot.name}"
        text = f"{reader}(p, t, {array}, u, {self.index(slot.at)})"
        return Code(text, (reader, "p", "t", array, "u", *index))

    def _names_in(self, at: Affine) -> tuple[str, ...]:
        return tuple(self.size_texts.get(name, name) for name, _ in at.terms)

    def _local(self, slot: Slot) -> str:
        if slot not in self._names:
            if slot.kind == "input":
                wish = local_wish(self.inputs[int(slot.name)])
            elif slot.kind == "sum":
                wish = f"sum_{slot.name}"
            elif slot.kind == "index":
                wish = f"real_{slot.name}"
            else:
                suffix = {"v": "_dot", "w": "_ddot", "d": "_own"}.get(slot.kind, "")
                wish = slot.name + _place(slot.at) + suffix
            self._names[slot] = self._locals.take(wish)
        return self._names[slot]

    # -- blocks -------------------------------------------------------------------------------

    def block(self, targets: Iterable[Target], where: str) -> Block:
        block = Block(list(targets), where)
        self.blocks.append(block)
        return block

    def finish(self) -> None:
        """Hoists and writes out every block."""
        for block in self.blocks:
            roots = [n for t in block.targets for n in t.nodes]
            new = rewrite(self.work, roots, gather=block.where != FIXED)
            block.rewritten = [
                replace(t, nodes=tuple(new[n] for n in t.nodes)) for t in block.targets
            ]
        self._hoist([b for b in self.blocks if b.where != FIXED])
        for block in self.blocks:
            block.statements = self._written(block)
            block.operations = operations_in(block.statements)

    def _hoist(self, blocks: list[Block]) -> None:
        found: set[Node] = set()
        seen: set[Node] = {n for b in blocks for t in b.rewritten for n in t.nodes}
        stack = list(seen)
        while stack:
            node = stack.pop()
            if self.work.fixed[node] and self.work.negated(node) is None:
                if not self.work.is_leaf(node):
                    found.add(node)
                continue
            for a in self.work.args[node]:
                if a not in seen:
                    seen.add(a)
                    stack.append(a)
        order = sorted(found)
        new = rewrite(self.work, order, gather=False)
        distinct = sorted({new[node] for node in order})
        places = {node: f"p->c_[{k}]" for k, node in enumerate(distinct)}
        schedule = self._schedule(FIXED, frozenset(places.values()))
        schedule.run(Target(STORE, places[node], (node,)) for node in distinct)
        self.helpers |= schedule.helpers
        self.prepare = schedule.statements
        self.hoisted = {node: distinct.index(new[node]) for node in order}

    @property
    def hoisted_count(self) -> int:
        return len(set(self.hoisted.values()))

    def _schedule(self, where: str, known: frozenset[str] = frozenset()) -> Schedule:
        names = Names(LOCAL_RESERVED, (*_OURS, *self._names.values()), self.prefix)
        return Schedule(
            self.work,
            names,
            self.prefix,
            self._leaf(where),
            known_after=known,
            inline_sincos=not self.libm and where != FIXED,
        )

    def _leaf(self, where: str) -> Callable[[Node], Code | None]:
        def leaf(node: Node) -> Code | None:
            if where != FIXED and node in self.hoisted:
                return variable(f"p->c_[{self.hoisted[node]}]")
            if self.work.op[node] is Op.NUMBER:
                return number_text(self.work.data[node])
            if self.work.op[node] is not Op.SYMBOL:
                return None
            symbol = self.work.data[node]
            assert isinstance(symbol, Symbol)
            if symbol.kind is Kind.PI:
                return Code(PI)
            if symbol.kind is Kind.TIME:
                return variable("t")
            slot = self.equations.slots[symbol.index]
            if slot.kind == "size":
                size = self.size_texts[slot.name]
                return Code(f"(pk_real){size}", (size,))
            if symbol.kind is Kind.PARAMETER:
                index = () if slot.at is None else self._names_in(slot.at)
                return Code(self.member(slot.name, slot.at), ("p", *index))
            return variable(self._local(slot))

        return leaf

    def _written(self, block: Block) -> list[Statement]:
        # Every slot of the block has its name before other locals are named.
        roots = [n for t in block.rewritten for n in t.nodes]
        slots = []
        for node in self.work.reachable(roots):
            symbol = self.work.data[node]
            if self.work.op[node] is Op.SYMBOL and symbol.kind not in (Kind.PI, Kind.TIME):
                slots.append(self.equations.slots[symbol.index])
                self._local(slots[-1])
        schedule = self._schedule(block.where)
        schedule.run(block.rewritten)
        self.helpers |= schedule.helpers
        used = {name for s in schedule.statements for value in s.values for name in value.names}
        loads = [
            Statement.of(LOAD, self._local(slot), self._access(slot, block.where))
            for slot in slots
            if self._local(slot) in used and slot.kind != "size"
        ]
        return [*loads, *schedule.statements]


CHUNK = 64  # members that are gone through at once
WIDEST_BOND = 4  # members between the ends of a bond whose force is computed once
FLUX_STRIDE = CHUNK + WIDEST_BOND


def flux_place(k: int, back: int) -> str:
    """Where the force of bond kind k is, of the bond that begins `back` members before m."""
    return f"flux[{k * FLUX_STRIDE - back}]"


def _place(at: Affine | None) -> str:
    """m + 1 as p1, m - 2 as m2, j as j, 3 as at_3."""
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


def _firsts(e: LoopEquations) -> dict[str, Affine]:
    """The flat index of each declared coordinate's first member."""
    found, total = {}, Affine()
    for group in e.coordinates:
        found[group.name] = total
        total = total + group.count
    return found
