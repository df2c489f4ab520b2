"""Writes the equations of a family q[1..N] in the form of a textbook: one equation in the index i,
and separate equations for some members at each end of the family.

An equation is a sum of parts, and each part holds for a range lo <= i <= hi. For the indices at
which all parts hold, there is one equation in i. A few members at each end have separate equations:
members at which some parts do not hold, and neighbours of an index outside the family where the
value copies a member (`free`) or has an acceleration (`fixed` at a function of t). The family is
assumed to be longer than both ends together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ..graph.affine import COUNTERS, OTHER, ROW, Affine, variable
from ..graph.differentiate import reachable
from ..graph.graph import ZERO, Kind, Node, Op, Symbol
from ..indices import indexed
from ..middle.analyze.sympy_bridge import plain, to_sympy, written_size
from ..middle.families.constant_sums import within
from ..middle.families.equations import FamilyEquations
from ..middle.families.indexed_ir import Addend, Group, Over, Slot, Sum
from ..middle.families.indices import unlike_loops
from ..middle.families.slots import Slots
from ..record import record

if TYPE_CHECKING:
    import sympy

SHOWN_OPERATIONS = 300
M = variable(ROW)
PRIMES = {"v": "'", "w": "''", "d": "'", "acc": "''"}

# A function of a member's index. It returns the left side of the member's equation; None if the
# member has no such equation.
Label = Callable[[Affine], str | None]


class Unclear(Exception):
    """The range of a part and the range of its family cannot be compared, since the values of sizes
    such as N are unknown."""


@record
class Part:
    """The contribution of an addend to the equations of the members lo..hi of a family. `inner` is
    the contribution far from the ends, where no member has a given value."""

    lo: Affine
    hi: Affine
    node: Node
    inner: Node

    @property
    def is_point(self) -> bool:
        """Whether the range lo..hi has a constant length of a few members, which does not depend on
        the length of the family."""
        length = self.hi - self.lo
        return length.is_constant and length.constant <= 8


@record
class EquationLine:
    left: str
    right: str
    range: str = ""  # such as "i = 1..N"; "" if the equation has no i

    def __str__(self) -> str:
        return f"{self.left} = {self.right}" + (f"   for {self.range}" if self.range else "")


@record
class Style:
    """Functions that format: an expression; in place of a large expression, its number of
    operations; a sum over an index; a sum of given terms."""

    expression: Callable[[sympy.Expr], str]
    large: Callable[[int], str]
    total: Callable[[str, str], str]
    plus: Callable[[list[str]], str]


PLAIN = Style(
    expression=plain,
    large="({} operations)".format,
    total=lambda over, body: f"sum({body}, {over})",
    plus=" + ".join,
)


class Writer:
    """Writes expressions of a model, and equations with an index."""

    def __init__(self, e: FamilyEquations, style: Style = PLAIN):
        self.e = e
        self.style = style
        self._slots_of = Slots(e.graph, e.slots)
        self._carried = {g.name for g in e.carried_groups}
        self.groups = {g.name: g for g in (*e.coordinates, *e.carried_groups)}
        self.inputs = [q.name for q in e.inputs]
        own = {x.name for x in (*e.model.sizes, *e.coordinates, *e.parameters)} | {*self.inputs}
        self.i = next(letter for letter in ("i", "k", "n", "i_") if letter not in own)
        self.j = next(letter for letter in ("j", "l", "o", "j_") if letter not in own)
        # A size of the model that is named like a loop variable of pkgen has another name
        # internally; its own name is shown.
        sizes = {unlike_loops(size.name): size.name for size in e.model.sizes}
        free = (letter for letter in "jklnopqrsuvw" if letter not in own)
        self._shown = sizes | {ROW: self.i, OTHER: self.j} | dict(zip(COUNTERS, free, strict=False))
        once = (x for item in (*e.defaults, *e.starts) for x in (*item.before, *item.each))
        self._summed = [inner for x in once for inner in within(x)]

    def index(self, at: Affine) -> str:
        """Returns an index as text, such as `i+1` or `N-1`. If the model uses the name `i`, another
        letter replaces it."""
        return at.text(self._shown).replace(" ", "")

    def span(self, lo: Affine, hi: Affine) -> str:
        return f"{self.i} = {self.index(lo)}..{self.index(hi)}"

    def over(self, over: Over) -> str:
        """Returns index ranges as text, such as `i = 1..N, j = i+1..N`."""
        lo, hi, *others = over
        more = [f", {self.j} = {self.index(others[0])}..{self.index(others[1])}"] if others else []
        return "".join([self.span(lo, hi), *more])

    def part(self, x: Addend) -> Part:
        """Returns the contribution of an addend to the rows of a family, with the index m."""
        at, slots = x.to[0][1], self._slots_of
        if x.over:
            shift = (at - M).constant
            lo, hi = (end + shift for end in x.over)
            node = slots.shifted(x.node, -shift)
        else:
            lo = hi = at
            node = self._seen_from(x.node, at)
        return Part(lo, hi, node, slots.inside(node, self._carried))

    def _seen_from(self, node: Node, place: Affine) -> Node:
        """Returns the node with indices shifted so that `place` becomes m, if their distance from
        it is constant."""

        def swap(slot: Slot) -> Node | None:
            if slot.at is None or not (slot.at - place).is_constant:
                return None
            return self._slots_of.node(slot.kind, slot.name, M + (slot.at - place))

        return self._slots_of.swapped(node, swap)

    # -- expressions --------------------------------------------------------------------------

    def total(self, total: Sum) -> str:
        style = self.style
        alone = [(x.node, M) for x in total if not x.over]
        parts = [self.text(alone)] if alone else []
        parts += [style.total(self.over(x.over), self.text([(x.node, M)])) for x in total if x.over]
        return style.plus(parts) if parts else "0"

    def text(self, pieces: Iterable[tuple[Node, Affine]]) -> str:
        """Returns the text of a sum of nodes. Each node is evaluated at the index that is paired
        with it in `pieces`."""
        import sympy as sp

        pieces = [(node, at) for node, at in pieces if node != ZERO]
        size = sum(written_size(self.e.graph, node) for node, _ in pieces)
        if size > SHOWN_OPERATIONS:
            return self.style.large(size)
        total = sp.Add(*(self._expression(node, at) for node, at in pieces))
        return self.style.expression(min(total, sp.expand(total), key=sp.count_ops))

    def _expression(self, node: Node, at: Affine) -> sympy.Expr:
        import sympy as sp

        def symbol(s: Symbol) -> sp.Expr:
            if s.kind is Kind.TIME:
                return sp.Symbol("t")
            return self._symbol(self._slots_of.all[s.index], at)

        (found,) = to_sympy(self.e.graph, [node], symbol)
        return found

    def _symbol(self, slot: Slot, at: Affine) -> sympy.Expr:
        import sympy as sp

        if slot.kind == "index":
            place = variable(slot.name).replaced({ROW: at})
            return sum(
                (f * sp.Symbol(self.index(variable(n))) for n, f in place.terms), place.constant
            )
        if slot.kind == "sum":
            total = self.e.sums[int(slot.name)]
            if not any(x.over for x in total):
                return sp.Add(*(self._expression(x.node, M) for x in total))
            text = self.total(total)
            return sp.Symbol(f"({text})" if len(total) > 1 else text)
        if slot.kind == "place":
            return sp.Symbol(self._once(int(slot.name[5:-1])))
        name = self.inputs[int(slot.name)] if slot.kind == "input" else slot.name
        if slot.kind == "lambda":
            name = next(f"lambda_{x.name}" for x in self.e.bound if x.group.name == slot.name)
        primes, group = PRIMES.get(slot.kind, ""), self.groups.get(slot.name)
        if slot.kind == "let":
            name, primes = name.replace("'", ""), "'" * name.count("'")
        elif slot.kind == "a":
            primes = "'" if group.is_state else "''"
        if group is not None and group.is_turn:
            name, primes = group.shown, primes[1:]
        if slot.at is not None:
            place = slot.at.replaced({ROW: at})
            if slot.kind in ("q", "v", "w", "d", "s", "a", "acc"):
                if slot.kind == "w" and group.is_carried:
                    # In this equation the accelerations of carried values count as zero.
                    return sp.Integer(0)
                place = self.home(group, place)
                if slot.kind == "w" and at != M and self._is_own(group, place):
                    return sp.Integer(0)
            name = indexed(name, self.index(place))
        return sp.Symbol(name + primes)

    def _once(self, k: int) -> str:
        """Returns the text of sum number k over families. Such sums are computed once per run, not
        in each step."""
        [found] = [x for x in self._summed if x.place == k]
        ranges = (
            f"{self.index(variable(v))} = {self.index(a)}..{self.index(b)}"
            for v, a, b in found.ranges
        )
        return self.style.total(", ".join(ranges), self.text([(found.node, M)]))

    # -- members ------------------------------------------------------------------------------

    def home(self, group: Group, at: Affine) -> Affine:
        """Returns the index of the member whose value is copied at an index outside the family; for
        any other index, returns that index."""
        below, above = at - group.lo, group.hi - at
        if group.periodic:
            if below.is_constant and below.constant < 0:
                return at + group.count
            if above.is_constant and above.constant < 0:
                return at - group.count
        for place, end in group.ends:
            if end.kind == "free" and place == at:
                return group.lo if place == group.lo - 1 else group.hi
        return at

    def _is_own(self, group: Group, at: Affine) -> bool:
        return group.is_family and _reaches(group.lo, at) and _reaches(at, group.hi)

    def _images(self, group: Group, at: Affine) -> list[Affine]:
        """Returns the index of a member, and all indices outside the family at which the member's
        value is copied."""
        found = [at]
        if group.periodic:
            found += [at + group.count, at - group.count]
        found += [
            place
            for place, end in group.ends
            if end.kind == "free" and self.home(group, place) == at
        ]
        return found

    def name(self, group: Group, at: Affine) -> str | None:
        """Returns the name of a member; None at an index where the value is prescribed."""
        place = self.home(group, at)
        given = any(end.kind == "fixed" and p == place for p, end in group.ends)
        return None if given else indexed(group.shown, self.index(place))

    # -- rows ---------------------------------------------------------------------------------

    def rows(self, group: Group, items: list[tuple[Label, tuple[Part, ...]]]) -> list[EquationLine]:
        """Returns the equations of a family. Each of `items` is an equation: a label (its left
        side), and the parts of the sum on its right side."""
        try:
            below, above = self._ends(group, [part for _, parts in items for part in parts])
            labels = [label for label, _ in items if label(M) is not None]
            while not group.periodic and any(x(group.lo + below) is None for x in labels):
                below += 1
            while not group.periodic and any(x(group.hi - above) is None for x in labels):
                above += 1
            cells = [group.lo + k for k in range(below)]
            cells += [group.hi - k for k in reversed(range(above))]
            inside = group.count - len(cells)
            if inside.is_constant and inside.constant <= 0:
                cells = [group.lo + k for k in range(group.count.constant)]
            lines = [line for cell in cells for line in self._at(group, cell, items)]
        except Unclear:
            return self._listed(items)
        if inside.is_constant and inside.constant <= 0:
            return lines
        return [*self._inside(items, self.span(group.lo + below, group.hi - above)), *lines]

    def _inside(self, items, where: str) -> list[EquationLine]:
        found = []
        for label, parts in items:
            bulk = [(part.inner, M) for part in parts if not part.is_point]
            left = label(M)
            if left is not None and bulk:
                found.append(EquationLine(left, self.text(bulk), where))
        return found

    def _at(self, group: Group, cell: Affine, items) -> list[EquationLine]:
        found: dict[str, list[tuple[Node, Affine]]] = {}
        for label, parts in items:
            for image in self._images(group, cell):
                here = [p for p in parts if _reaches(p.lo, image) and _reaches(image, p.hi)]
                left = label(image)
                if left is not None and here:
                    found.setdefault(left, []).extend((part.node, image) for part in here)
        return [EquationLine(left, self.text(pieces)) for left, pieces in found.items()]

    def _listed(self, items) -> list[EquationLine]:
        """Returns a line for each part, with the range of indices for which the part holds. rows()
        calls this if ranges cannot be compared."""
        found = []
        for label, parts in items:
            left = label(M)
            if left is not None:
                for k, part in enumerate(parts):
                    right = ("" if k == 0 else "... + ") + self.text([(part.node, M)])
                    found.append(EquationLine(left, right, self.span(part.lo, part.hi)))
        return found

    def _ends(self, group: Group, parts: list[Part]) -> tuple[int, int]:
        """Returns how many members at the lower and at the upper end have separate equations."""
        below = above = 0
        for part in parts:
            low, high = part.lo - group.lo, group.hi - part.hi
            if part.is_point:
                if (part.hi - group.lo).is_constant:
                    below = max(below, (part.hi - group.lo).constant + 1)
                else:
                    above = max(above, (group.hi - part.lo).constant + 1)
                continue
            if not (low.is_constant and high.is_constant):
                raise Unclear
            whole = group.periodic and part.hi - part.lo + 1 == group.count
            if not whole or self._by_index(part.node):
                below, above = max(below, low.constant), max(above, high.constant)
                if group.periodic:
                    below, above = max(below, -high.constant), max(above, -low.constant)
            free = {place for place, end in group.ends if end.kind == "free"}
            if low.constant < 0 and group.lo - 1 in free:
                below = max(below, 1)
            if high.constant < 0 and group.hi + 1 in free:
                above = max(above, 1)
            for slot in self._slots(part.node):
                if slot.kind == "w" and slot.at is not None and slot.at.factor(ROW):
                    shift = (slot.at - M).constant
                    below, above = max(below, -shift), max(above, shift)
        return below, above

    def _by_index(self, node: Node) -> bool:
        """Whether the value of a node depends explicitly on the index i: as a number, or by a
        parameter with an index."""
        return any(
            slot.kind == "index" or (slot.kind == "param" and slot.at is not None)
            for slot in self._slots(node)
        )

    def _slots(self, node: Node) -> Iterable[Slot]:
        g = self.e.graph
        for n in reachable(g, [node]):
            if g.op[n] is Op.SYMBOL and g.data[n].kind not in (Kind.PI, Kind.TIME):
                yield self._slots_of.all[g.data[n].index]


def _reaches(low: Affine, high: Affine) -> bool:
    """Whether low <= high, if all families are long enough. Raises Unclear if that depends on which
    of two sizes is larger."""
    distance = high - low
    if distance.is_constant:
        return distance.constant >= 0
    signs = {factor > 0 for _, factor in distance.terms}
    if len(signs) > 1:
        raise Unclear
    return signs.pop()
