"""The numbers of families, and of ranges of indices, in the C tables of a model."""

from __future__ import annotations

from dataclasses import replace

from ...graph.affine import OTHER, ROW, Affine
from ...middle.loops.indexed_ir import Cell, Group, Slot
from ...middle.loops.loops import LoopEquations
from .loops import Places
from .loops_kernels import beyond

# Kinds of symbols (Slot): the array in C, and which derivative of a given value stands for it where
# it is given: the value, its rate or its acceleration, or none, which means 0.
ARRAYS = {
    "q": ("Q", 0),
    "s": ("V", 0),
    "v": ("V", 1),
    "d": ("V", -1),
    "w": ("ZERO", 2),
    "a": ("A", -1),
    "acc": ("A", 2),
    "p": ("P", -1),
    "let": ("LETS", -1),
    "lambda": ("LAMBDA", -1),
    "side": ("SIDES", -1),
}


class Numbers:
    """The numbers of families in C, and the indices in the array `at_` of struct NAME_params, which
    has their ranges first, then ranges of sums and other indices."""

    def __init__(self, e: LoopEquations, places: Places):
        self.e, self.places = e, places
        self.groups = {g.name: g for g in (*e.coordinates, *e.carried_groups)}
        self.families: dict[tuple[str, str], int] = {}
        self.rows: list[tuple[str, str, str]] = []  # first number, least and greatest index
        self.shapes: list[str] = []  # rows of struct pk_family
        for g in (*e.coordinates, *e.carried_groups):
            self._enter(g.name, "", places.first[g.name], g)
        for rows in e.bound:
            # A single row counts as a scalar: it is read and written without its index.
            g = replace(rows.group, lo=None, hi=None) if rows.is_single else rows.group
            self._enter(g.name, "lambda", places.first[g.name], g)
        for item in (item for found in e.along for item in found):
            self._enter(item.name, "let", places.lets[item.name][0], item.group)
        for g in e.carried_groups:
            for kind in ("w", "d", "hung_p", "hung_f"):
                _, first = places.carried(kind, g.name, g.lo)
                self._enter(g.name, kind, first, g)
        for k in range(len(e.switches)):
            self._side(k)
        self.more: list[str] = []
        self._known: dict[tuple[Affine, ...], int] = {}

    def _enter(self, name: str, kind: str, first: Affine, g: Group) -> None:
        index = self.places.index
        self.families[name, kind] = len(self.rows)
        lo, hi = (index(g.lo), index(g.hi)) if g.is_family else ("0", "0")
        self.rows.append((index(first), lo, hi))
        below, above = beyond(g, self.e) if not g.periodic and not kind else (0, 0)
        self.shapes.append(f"{{{int(g.periodic)}, {below}, {above}}}")

    def _side(self, k: int) -> None:
        self.families[str(k), "side"] = len(self.rows)
        lo, hi = (f"p->side_{end}_[{k}]" for end in ("lo", "hi"))
        self.rows.append((f"p->side_at_[{k}] + {lo}", lo, hi))
        self.shapes.append("{0, 0, 0}")

    def range(self, *ends: Affine) -> int:
        """Returns the index in `at_` of successive numbers."""
        if ends not in self._known:
            self._known[ends] = 3 * len(self.rows) + len(self.more)
            self.more += map(self.places.index, ends)
        return self._known[ends]

    def shift(self, at: Affine) -> tuple[int, int]:
        """Returns the constant part of an index without loop variables, and the index in `at_` of
        the rest, or 0 if there is none."""
        rest = Affine(0, at.terms)
        return at.constant, 0 if rest.is_constant else self.range(rest)

    def family(self, slot: Slot) -> int:
        """Returns the number of the family that a symbol belongs to, or of the scalar."""
        kind = slot.kind if slot.kind in ("let", "lambda", "side") else ""
        if (slot.name, slot.kind) in self.families and slot.name in self.groups:
            kind = slot.kind if slot.kind in ("w", "d", "hung_p", "hung_f") else ""
        return self.families[slot.name, kind]

    def slot(self, slot: Slot, array: str = "", order: int = -1) -> str:
        """Returns a row of struct pk_slot."""
        family = self.family(slot)
        if not array:
            array, order = self._array(slot)
        at = slot.at if slot.at is not None else Affine()
        of_m, of_j = at.factor(ROW), at.factor(OTHER)
        shift, extra = self.shift(at.without(ROW).without(OTHER))
        return f"{{PK_OF_{array}, {order}, {family}, {of_m}, {of_j}, {shift}, {extra}}}"

    def _array(self, slot: Slot) -> tuple[str, int]:
        group = self.groups.get(slot.name)
        if group is not None and group.is_carried:
            return ("V" if slot.kind == "v" else "Q"), -1
        if group is not None and group.is_state and slot.kind == "a":
            return "RATED", 1
        array, order = ARRAYS[slot.kind]
        if group is not None and group.is_state and slot.kind == "acc":
            return "A", 1
        return array, order

    def cell(self, cell: Cell) -> str:
        """Returns the place to which values are added, as a row of struct pk_slot."""
        name, at = cell
        return self.slot(Slot("q" if name in self.groups else "lambda", name, at), "Q")
