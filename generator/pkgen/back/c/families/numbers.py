"""The numbers of families, and of ranges of indices, in the C tables of a model."""

from __future__ import annotations

from ....graph.affine import Affine
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Group
from .places import Places
from .plan import row_group
from .readers import Readers


class Numbers:
    """The numbers of families in C, and the indices in the array `at_` of struct NAME_params: three
    for each family, then those of `more`. Only models with matrices need families in tables."""

    def __init__(self, e: FamilyEquations, places: Places, readers: Readers, matrices: bool):
        self.places, self.readers = places, readers
        self.families: dict[tuple[str, str], int] = {}
        self.rows: list[tuple[str, str, str]] = []  # first number, least and greatest index
        self.shapes: list[str] = []  # rows of struct pk_family
        self.more: list[str] = []
        self._known: dict[tuple[Affine, ...], int] = {}
        if not matrices:
            return
        for g in (*e.coordinates, *e.carried_groups):
            self._enter(g, "")
        for rows in e.bound:
            self._enter(row_group(rows), "lambda")

    def _enter(self, g: Group, kind: str) -> None:
        self.families[g.name, kind] = len(self.rows)
        ends = self.readers.ends(g, open=not kind)
        self.rows.append((self.places.index(self.places.first[g.name]), ends.lo, ends.hi))
        self.shapes.append(f"{{{int(ends.ring)}, {ends.below}, {ends.above}}}")

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
