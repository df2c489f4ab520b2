"""Evaluates indices as affine expressions of sizes and loop variables, and finds the conditions on
sizes under which the indexed members exist."""

from __future__ import annotations

from ...graph.affine import LOOPS, ROW, Affine, affine, extremes, variable
from ...indices import NotAnInteger
from ...model import Coordinate, Model, Parameter, Range, State
from ...record import record
from ...tree import Expr
from .indexed_ir import Group, NotKept
from .slots import Slots

Loop = dict[str, Affine]


@record
class Limit:
    """A condition on the model's sizes, such as N in q[1..N]. It holds if `needs` >= 0, or if
    `unless` < 0, where `unless` is the length of an index range minus 1: if the range is empty,
    nothing is needed. None: `needs` >= 0 must hold."""

    needs: Affine
    unless: Affine | None


class Indices:
    """Evaluates the indices in one model, and records the members with these indices."""

    def __init__(self, model: Model, slots: Slots) -> None:
        self.model = model
        self.slots = slots
        self.graph = slots.graph
        self.sizes: Loop = {size.name: variable(unlike_loops(size.name)) for size in model.sizes}
        # For each member of a family that was used so far: (lo, hi, index), lo..hi being the range
        # of the family.
        self.members: list[tuple[Affine, Affine, Affine]] = []

    def _group(self, item: Coordinate | State | Parameter) -> Group:
        if item.range is None:
            return Group(item, None, None)
        lo, hi = self.index(item.range.lo, self.sizes), self.index(item.range.hi, self.sizes)
        ends, periodic = [], False
        for end in self.model.ends:
            if end.name != item.name or isinstance(item, Parameter):
                continue
            if end.kind == "periodic":
                periodic = True
            elif end.at is not None:
                ends.append((self.index(end.at, self.sizes), end))
            else:
                first = lo.value(size_values(self.model))
                below = end.index is not None and end.index < first
                ends.append((lo - 1 if below else hi + 1, end))
        return Group(item, lo, hi, tuple(ends), periodic)

    def index(self, expr: Expr, loop: Loop) -> Affine:
        try:
            return affine(expr, loop)
        except NotAnInteger as wrong:
            raise NotKept(
                f"an index is not a sum of sizes and a loop variable: {wrong.message}"
            ) from None

    def limits_of(self, length: Affine | None, at: dict[str, tuple[Affine, Affine]]) -> list[Limit]:
        """Returns the conditions on the model's sizes under which all recorded members exist, and
        deletes the record. `at` has the ranges of loop variables. `length` is the length minus 1 of
        the range of the outer loop: the conditions are not needed if it is negative. None: they are
        always needed."""
        found = []
        for lo, hi, index in self.members:
            first, last = extremes(index, at)
            found += [Limit(first - lo, length), Limit(hi - last, length)]
        self.members.clear()
        return found

    def limits_over(self, lo: Affine | None, hi: Affine | None) -> list[Limit]:
        """Returns the conditions of `limits_of` for members that occur in the loop m = lo..hi, or
        outside all loops if `lo` is None."""
        return self.limits_of(None, {}) if lo is None else self.limits_of(hi - lo, {ROW: (lo, hi)})

    def over(
        self, range_: Range | None, index: Expr | None = None
    ) -> tuple[Affine | None, Affine | None, Loop]:
        """Returns the index range lo..hi of a statement (None if it has no index), and the values
        of the names in its indices."""
        loop = dict(self.sizes)
        if range_ is not None:
            lo, hi = self.index(range_.lo, loop), self.index(range_.hi, loop)
            return lo, hi, loop | {range_.variable: variable(ROW)}
        at = None if index is None else self.index(index, loop)
        return at, at, loop


def unlike_loops(size: str) -> str:
    """Returns the name that stands for a size, such as N in q[1..N], in index expressions. A prime
    is appended to a name that is also the name of a loop variable."""
    return f"{size}'" if size in LOOPS else size


def size_values(model: Model) -> dict[str, int]:
    return {unlike_loops(size.name): size.value for size in model.sizes}
