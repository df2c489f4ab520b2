"""The rows of a vector in C: sums of elements of a buffer of terms, and what is added to single
rows. Rows beyond a ring's end or a free end are added to the members that they stand for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from ....graph.affine import variable
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Group
from ..tree import Function, If, Loop, Node, Scope, rendered
from .blocks import plus
from .kernels import Goal, Vector, added, chunk_of, halo_of, reach, rows_beyond
from .merge import moves
from .places import Places
from .readers import Ends, Readers, X, declared


class Rows:
    """The rows of one vector of a model."""

    def __init__(
        self, of: Vector, e: FamilyEquations, places: Places, readers: Readers, block: int
    ):
        self.of, self.places, self.name = of, places, f"{e.model.name}_{of.name}"
        self.model, self.index = e.model.name, places.index
        self.halo, self.low = halo_of(of), reach(of)[0]
        self.most, self.chunk, self.count = reach(of)[1], chunk_of(of, block), added(of, e)
        self.width = self.chunk + self.halo
        self.first: dict[str, int] = {}  # The number of each term's first value in e.
        self.values = 0
        for terms in of.of(2):
            self.first[terms.name] = self.values
            self.values += len(terms.nodes)
        self.ends = {g.name: readers.ends(g) for g in of.families}
        self.beyond = {g.name: rows_beyond(of, g, e) for g in of.families}
        self.has_ends = self.count > 0
        self.scalars = [g.name for g in of.scalars]
        self.kicks = ""

    def place(self, g: Group, at: str) -> str:
        """Returns the index in arrays of the member `at` of a family."""
        return self.index(self.places.first[g.name] + variable(at) - g.lo)

    def rows(self, g: Group, width: int) -> list[str]:
        """Returns the row of each output before a division, as the sum of elements of e."""
        values = []
        for output in range(self.of.outputs):
            text = ""
            for goal in self.of.goals:
                cell = goal.to[0]
                if len(goal.terms.over) == 2 and goal.output == output and cell[0] == g.name:
                    column = self.most - cell[1].constant
                    row = self.first[goal.terms.name] + goal.value
                    sign = (" - " if text else "-") if goal.sign < 0 else " + " * bool(text)
                    text += f"{sign}e[{plus('k', row * width + column)}]"
            values.append(text or "0")
        return values

    def fills(self, first: str, n: str, e: str, width: int) -> Iterator[Node]:
        """Yields the calls that write the terms of n rows to e; `first` is the index m of the first
        column."""
        for terms in self.of.of(2):
            lo, hi = map(self.index, terms.over)
            done = self.first[terms.name]
            to = f"{e} + {done * width}" if done else e
            own = f"{self.model}_{terms.name}, {len(terms.nodes)}, {lo}, {hi}"
            yield f"pk_fill(x, {own}, {first}, {n}, {to}, {width});"

    def clip(self, g: Group) -> tuple[str, str]:
        """Returns the range of k of a family's members in a chunk."""
        ends, (first, last) = self.ends[g.name], self.range
        low = "0" if first == ends.lo else f"pk_most(0, {ends.lo} - from)"
        high = "n" if last == ends.hi else f"pk_least(n, {ends.hi} + 1 - from)"
        return low, high

    @property
    def range(self) -> tuple[str, str]:
        """The least and the greatest row of all families; terms of scalars extend it."""
        lows = [self.ends[g.name].lo for g in self.of.families]
        highs = [self.ends[g.name].hi for g in self.of.families]
        for terms in dict.fromkeys(goal.terms.name for goal in self.to_scalars):
            over = next(x.over for x in self.of.of(2) if x.name == terms)
            lows.append(self.index(over[0] + self.most))
            highs.append(self.index(over[1] + self.low))
        return extreme(lows, "pk_least"), extreme(highs, "pk_most")

    @property
    def to_scalars(self) -> list[Goal]:
        return [g for g in self.of.goals if len(g.terms.over) == 2 and not moves(g.to[0])]

    def lane_loop(self, low: str, high: str, body: Sequence[str]) -> list[Node]:
        return ["PK_LANE_LOOP", Loop(f"k = {low}; k < {high}; k++", [Scope(body)])]

    @property
    def minus(self) -> str:
        return plus("", -self.most).rstrip() if self.most else ""

    def added_to(self, first: str, end: str, scalars: str = "NULL") -> list[Node]:
        if not self.has_ends:
            return []
        if not self.of.families:
            return [f"(void){self.name}_ends(x, 0, 0, NULL, {scalars});"]
        call = f"{self.name}_ends(x, {first}, {end}, added, {scalars})"
        return [
            f"struct pk_added added[{self.count}] = {{{{0, 0, 0, 0}}}};",
            f"const int n_added = {call};",
        ]

    def buffered(
        self, number: int, values: Sequence[str], low: str, high: str, width: str
    ) -> list[Node]:
        """Returns the lines that write the rows of a family before a division to r."""
        stores = [
            f"r[{f'{k} * {width} + ' if k > 1 else f'{width} + ' if k else ''}k] = {value};"
            for k, value in enumerate(values)
        ]
        loop = self.lane_loop(low, high, stores)
        return [*loop, f"pk_add_to(added, n_added, {number}, from, n, r, {width});"]

    # -- single rows --------------------------------------------------------------------------

    def ends_function(self) -> str:
        says = "Lists what is added to single rows of first .. end - 1, and adds up scalars."
        head = (
            f"static int {self.name}_ends({X}, ptrdiff_t first, ptrdiff_t end, "
            "struct pk_added *added, pk_real *scalars)"
        )
        body: list[Node] = ["const ptrdiff_t k = 0;", "int count = 0;", "", *self._singles()]
        for number, g in enumerate(self.of.families):
            found = [*self._beyond(number, g)]
            body += [Scope(found)] if found else []
        rest = unused(("x", "k", "first", "end", "added", "scalars"), body)
        body = [*declared(self.model, body), *rest, "return count;"]
        return Function(head, body, says).text + "\n"

    def _append(self, number: int, output: int, ends: Ends, at: str, value: str) -> str:
        there = f"added, count, {number}, {output}, {ends.home(at)}, {ends.lo}, first, end, {value}"
        return f"count = pk_append({there});"

    def _singles(self) -> Iterator[Node]:
        names = [g.name for g in self.of.families]
        for terms in self.of.of(0):
            count = len(terms.nodes)
            to = ", ".join(f"one + {k}" for k in range(count))
            body: list[Node] = [f"pk_real one[{count}], *const o[] = {{{to}}};", ""]
            body.append(f"{self.model}_{terms.name}(x, 0, 0, 1, o);")
            for goal in self.of.goals_of(terms):
                (name, at), sign = goal.to[0], "-" if goal.sign < 0 else ""
                if name in self.scalars:
                    k = self.scalars.index(name) * self.of.outputs + goal.output
                    body.append(f"scalars[{k}] += {sign}one[{goal.value}];")
                else:
                    ends, value = self.ends[name], f"{sign}one[{goal.value}]"
                    own = names.index(name), goal.output, ends, self.index(at), value
                    body.append(self._append(*own))
            yield Scope(body)

    def _beyond(self, number: int, g: Group) -> Iterator[Node]:
        """Yields a loop over the rows beyond the ends of a family."""
        ends, width = self.ends[g.name], self.halo + 1
        below, above = self.beyond[g.name]
        if not self.values or not below + above:
            return
        first, last = self.index(g.lo - below if below else g.hi + 1), self.index(g.hi + above)
        step = f"i = i + 1 == {ends.lo} ? {self.index(g.hi + 1)} : i + 1" if below else "i++"
        inner: list[Node] = [
            f"pk_real e[{self.values * width}];",
            "",
            *self.fills(plus("i", -self.most), str(width), "e", width),
        ]
        inner += [
            f"count = pk_append(added, count, {number}, {output}, home, {ends.lo}, first, end, "
            f"{value});"
            for output, value in enumerate(self.rows(g, width))
            if value != "0"
        ]
        there = f"home >= {ends.lo} && home >= first && home < end"
        body = [f"const ptrdiff_t home = {ends.home('i')};", "", If(there, [Scope(inner)])]
        yield "ptrdiff_t i;"
        yield ""
        yield Loop(f"i = {first}; i <= {last}; {step}", [Scope(body)])


def unused(names: Iterable[str], body: Sequence[Node]) -> list[Node]:
    """Returns a statement for each name that the body does not use."""
    text = "\n".join(rendered(body))
    return [f"(void){x};" for x in names if not re.search(rf"\b{x}\b(?! =)", text)]


def extreme(found: Iterable[str], call: str) -> str:
    text, *more = dict.fromkeys(found)
    for other in more:
        text = f"{call}({text}, {other})"
    return text
