"""C functions that read members of families: NAME_read_Q(x, i) returns a member of Q, also one
beyond the ends of the family. Terms read successive members by pk_row() of members.h."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from ....graph.affine import OTHER, ROW, Affine, variable
from ....graph.graph import ZERO
from ....middle.families.indexed_ir import Group, Over, Slot
from ..expressions import Code
from ..kernel_code import statements
from ..names import Names
from ..tree import Declare, Function, If, Loop, Node, rendered
from .blocks import Block, Window
from .places import Places

# Which derivative of a given member a symbol (Slot) of this kind stands for: its value, its rate or
# its acceleration. Symbols of other kinds are 0 for a given member. A state has no acceleration.
ORDERS = {"q": 0, "s": 0, "v": 1, "w": 2, "acc": 2}
OF_STATES = {"s": 0, "a": 1, "acc": 1}
SUFFIXES = {"v": "_dot", "w": "_ddot", "d": "_own", "a": "_acc", "acc": "_acc", "p": "_momentum"}
X = "const struct pk_members *x"


class Ends(NamedTuple):
    """The indices of a family, and which indices beyond them stand for members (see pk_home)."""

    lo: str
    hi: str
    ring: bool
    below: int
    above: int

    def home(self, i: str) -> str:
        """Returns the C expression of the member that index i stands for."""
        return f"pk_home({i}, {self.lo}, {self.hi}, {int(self.ring)}, {self.below}, {self.above})"

    @property
    def are_members(self) -> bool:
        return bool(self.ring or self.below or self.above)


def beyond(group: Group, wraps: int) -> tuple[int, int]:
    """Returns the number of indices below the first member of a family, and above the last one,
    that stand for members; `wraps` is this number for a ring."""
    below = above = wraps
    for at, end in group.ends:
        if end.kind == "free":
            low, high = group.lo - at, at - group.hi
            if low.is_constant and low.constant > 0:
                below = max(below, low.constant)
            elif high.is_constant:
                above = max(above, high.constant)
    return below, above


def declared(model: str, body: Sequence[Node]) -> list[Node]:
    """Returns the body of a function of x, after declarations of what it uses of x."""
    words = {*re.findall(r"(?<![\w>.])[a-z]\w*", "\n".join(rendered(body)))}
    params = f"const struct {model}_params *const"
    found = [
        Declare(kind, word, value)
        for kind, word, value in (
            (params, "p", f"({params.removesuffix('const')})x->params"),
            ("const pk_real", "t", "x->t"),
            ("const pk_real *const", "u", "x->u"),
        )
        if word in words
    ]
    declares = isinstance(body[0], str) and body[0].startswith(("ptrdiff_t ", "const ", "pk_"))
    return [*found, *([""] if found and not declares else []), *body]


class Readers:
    """The readers of one model. `given` has the blocks of the value, the rate and the acceleration
    of each given member."""

    def __init__(self, places: Places, given: dict[tuple[str, Affine], list[Block]]):
        self.places, self.e, self.given = places, places.equations, given
        self.name = self.e.model.name
        own = (*self.e.coordinates, *self.e.carried_groups)
        rows = (bound.group for bound in self.e.bound)
        self.groups: dict[str, Group] = {g.name: g for g in (*own, *rows)}
        self.groups |= {item.name: item.group for found in self.e.along for item in found}
        self._names = Names(frozenset())
        self._read: dict[tuple[str, str], str] = {}  # (kind, family) -> part of the C name
        self._rows: set[tuple[str, str]] = set()

    # -- for terms ----------------------------------------------------------------------------

    def member(self, slot: Slot, over: Over) -> Code:
        """Returns the C expression of a member, for the index m, or the indices m and j."""
        if not self._is_inside(slot, over):
            own = self._reader(slot.kind, slot.name)
            return Code(
                f"{self.name}_read_{own}(x, {self.places.index(slot.at or Affine())})", ("m",)
            )
        return Code("PK_C(0.0)" if self._is_zero(slot) else self._stored(slot), ("m",))

    def pointer(self, window: Window, over: Over) -> str:
        """Returns the C expression of a window's pointer."""
        low, high = (
            replace(window.slot, at=window.slot.at + end) for end in (window.low, window.high)
        )
        first = low.at.replaced({OTHER if len(over) == 4 else ROW: variable("from")})
        inside = self._is_inside(low, over) and self._is_inside(high, over)
        if inside and not self._is_zero(low):
            return self._pointer(replace(low, at=first))
        key, span = (low.kind, low.name), window.high - window.low
        count = f"n + {span}" if span else "n"
        to = f"{self.places.index(first)}, {count}, {window.pointer}_room"
        if self._is_zero(low):
            self._rows.add(key)
            return f"{self.name}_row_{self._reader(*key)}(x, {to})"
        ends, is_side = self._ends(low), low.kind == "side"
        base = self._pointer(
            replace(low, at=variable(ends.lo) if is_side else self.groups[low.name].lo)
        )
        reads = ends.are_members or any(self._given(low))
        read = f"{self.name}_read_{self._reader(*key)}" if reads else "NULL"
        return f"pk_row(x, {base}, {read}, {ends.lo}, {ends.hi}, {to})"

    def _is_zero(self, slot: Slot) -> bool:
        """Returns whether all existing members are 0."""
        return slot.kind == "w" and not self.groups[slot.name].is_carried

    def _is_inside(self, slot: Slot, over: Over) -> bool:
        """Returns whether an index is known to be that of a member, as those of pairs are."""
        if slot.kind == "side":
            return False
        group = self.groups[slot.name]
        if len(over) == 4 or slot.at is None or not group.is_family:
            return True
        step = slot.at.factor(ROW)
        ends = [slot.at.replaced({ROW: end}) for end in over] if step else [slot.at, slot.at]
        lo, hi = ends if step >= 0 else ends[::-1]
        return all(x.is_constant and x.constant >= 0 for x in (lo - group.lo, group.hi - hi))

    def _stored(self, slot: Slot) -> str:
        """Returns the C expression of a member in its array."""
        if slot.kind == "side":
            return f"p->side_[p->side_at_[{slot.name}] + {self.places.index(slot.at)}]"
        array, place = self.places.stored(slot)
        return f"{_in_x(array)}[{self.places.index(place)}]"

    def _pointer(self, slot: Slot) -> str:
        if slot.kind == "side":
            return f"p->side_ + p->side_at_[{slot.name}] + {self.places.index(slot.at)}"
        array, place = self.places.stored(slot)
        index = self.places.index(place)
        return _in_x(array) if index == "0" else f"{_in_x(array)} + {index}"

    # -- the functions -------------------------------------------------------------------------

    def _reader(self, kind: str, name: str) -> str:
        if (kind, name) not in self._read:
            own = self.places.ids.get(name, re.sub(r"\W", "_", name))
            suffix = SUFFIXES.get(kind, "" if kind in ("q", "s") else f"_{kind}")
            self._read[kind, name] = self._names.take(own + suffix)
        return self._read[kind, name]

    def ends(self, g: Group, open: bool = True) -> Ends:
        """Returns the ends of a family; unless `open`, all indices beyond them are given."""
        lo, hi = map(self.places.index, (g.lo, g.hi)) if g.is_family else ("0", "0")
        there = open and not g.periodic
        below, above = beyond(g, self.e.wraps.get(g.name, 0)) if there else (0, 0)
        return Ends(lo, hi, g.periodic, below, above)

    def _ends(self, slot: Slot) -> Ends:
        if slot.kind == "side":
            lo, hi = (f"p->side_{end}_[{slot.name}]" for end in ("lo", "hi"))
            return Ends(lo, hi, False, 0, 0)
        g = self.groups[slot.name]
        inner = ("w", "d", "hung_p", "hung_f") if g.is_carried else ()
        return self.ends(g, slot.kind not in (*inner, "let", "lambda"))

    @property
    def text(self) -> str:
        return "".join(
            self._text(Slot(*key, variable("i")), own) for key, own in self._read.items()
        )

    def _text(self, slot: Slot, own: str) -> str:
        read, row = (f"{self.name}_{x}_{own}" for x in ("read", "row"))
        body = list(self._body(slot))
        made = [
            Function(
                f"PK_PERHAPS static pk_real {read}({X}, ptrdiff_t i)", declared(self.name, body)
            )
        ]
        if (slot.kind, slot.name) in self._rows:
            loop = Loop("k = 0; k < n; k++", [f"room[k] = {read}(x, from + k);"])
            body = ["ptrdiff_t k;", "", loop, "return room;"]
            head = f"static const pk_real *{row}({X}, ptrdiff_t from, ptrdiff_t n, pk_real *room)"
            made.append(Function(head, declared(self.name, body)))
        return "".join(f"{function.text}\n" for function in made)

    def _body(self, slot: Slot) -> Iterator[Node]:
        ends, given = self._ends(slot), list(self._given(slot))
        value = "0" if self._is_zero(slot) else self._stored(slot)
        inside = f"i >= {ends.lo} && i <= {ends.hi}"
        if ends.are_members:
            at_home = replace(slot, at=variable("home"))
            value = "0" if self._is_zero(slot) else self._stored(at_home)
            yield from (f"const ptrdiff_t home = {ends.home('i')};", "")
            inside = f"home >= {ends.lo}"
        if not given:
            yield f"return {inside} ? {value} : 0;"
            return
        yield If(inside, [f"return {value};"])
        for at, block in given:
            yield If(f"i == {at}", [*statements(block.statements)])
        yield "return 0;"

    def _given(self, slot: Slot) -> Iterator[tuple[str, Block]]:
        """Yields the index and the block of each given member that is not always 0."""
        g = self.groups.get(slot.name)
        orders = {} if g is None or g.is_carried else OF_STATES if g.is_state else ORDERS
        for (name, at), blocks in self.given.items():
            if name == slot.name and slot.kind in orders:
                block = blocks[orders[slot.kind]]
                if any(node != ZERO for node in block.nodes):
                    yield self.places.index(at), block


def _in_x(array: str) -> str:
    """Returns the array in functions of struct pk_members x."""
    return f"x->{array}" if array in ("q", "v") else array
