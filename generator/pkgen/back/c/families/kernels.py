"""The kernels of a model with families: terms, and to what their values are added.

A kernel is made from the addends of its quantities. Addends with the same index range become one C
function (Terms), which computes its values for successive members. vectors.py writes the C
code that adds these values up.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from ....graph.affine import OTHER
from ....graph.collect import THOROUGH, fewest, settled
from ....graph.differentiate import reachable
from ....graph.graph import ZERO, Node, Op
from ....middle.families.equations import FamilyEquations
from ....middle.families.indexed_ir import Addend, Cell, Group, Over
from ....middle.families.slots import Slots
from ...targets import ADD, STORE, Target
from .blocks import TERMS, Block
from .merge import merged, moves
from .places import Places
from .readers import beyond

# A C function has at most so many values; PK_MOST_VALUES in members_rows.h is no less.
MOST_VALUES = 200
MOST_ROOM = 4096  # numbers in the buffers of a C function
BLOCK, FEWEST = 512, 16  # the most and the fewest members that are computed at a time


@dataclass
class Terms:
    """A C function of the values of terms with the index range `over`. Value r is o[r]."""

    name: str
    over: Over
    nodes: list[Node]
    sequence: bool = False  # whether members are computed one after the other
    # The values that a term of pairs m, j adds to rows j: o[len(nodes)] and the following.
    added: tuple[Node, ...] = ()
    block: Block = field(init=False)

    def __post_init__(self) -> None:
        targets = [Target(STORE, f"o[{r}][k]", (node,)) for r, node in enumerate(self.nodes)]
        first = len(self.nodes)
        targets += [Target(ADD, f"o[{first + r}][k]", (x,)) for r, x in enumerate(self.added)]
        self.block = Block(targets, TERMS, over=self.over, sequence=self.sequence)

    @property
    def is_pairs(self) -> bool:
        return len(self.over) == 4


@dataclass
class Goal:
    """Value number `value` of terms, times `sign`, is added to output number `output` at the cells
    `to`."""

    terms: Terms
    value: int
    sign: int
    output: int
    to: tuple[Cell, ...]


@dataclass
class Kernel:
    """Terms, and to what their values are added."""

    name: str
    terms: list[Terms]
    goals: list[Goal]

    @property
    def blocks(self) -> Iterator[Block]:
        return (terms.block for terms in self.terms)

    def of(self, kind: int) -> list[Terms]:
        """The terms with so many numbers in their index range: 0, 2 or 4."""
        return [terms for terms in self.terms if len(terms.over) == kind]

    def goals_of(self, terms: Terms) -> list[Goal]:
        return [goal for goal in self.goals if goal.terms is terms]

    @property
    def most(self) -> int:
        """The largest number of values of one function."""
        return max((len(terms.nodes) for terms in self.terms), default=1)


@dataclass
class Vector(Kernel):
    """A kernel with values for the members of families, and for scalars."""

    families: list[Group]
    scalars: list[Group]
    outputs: int
    # STORE stores each output, QUOTIENT output 0 / output 1; DIVIDE divides the array by output 0.
    finish: str = "STORE"
    kicks: bool = False  # whether it is an acceleration by which members are kicked
    is_merged: bool = False  # whether each row is one term (see merge.py)


class Builder:
    """Makes kernels; may add nodes to the graph."""

    def __init__(self, e: FamilyEquations, places: Places):
        self.e, self.places, self.g = e, places, e.graph
        self.slots = Slots(e.graph, e.slots)
        self._known: dict[tuple, Terms] = {}

    def terms(
        self, name: str, over: Over, nodes: list[Node], added: tuple[Node, ...] = ()
    ) -> Terms:
        """Returns terms with these values. Kernels with equal terms share their C function."""
        made = Terms(name, over, nodes, added=added)
        return self._known.setdefault((over, tuple(nodes), added), made)

    def kernel(self, name: str, outputs: Sequence[Iterable[Addend]], short: bool = True) -> Kernel:
        return Kernel(name, *self._made(name, outputs, short))

    def vector(
        self,
        name: str,
        outputs: Sequence[Iterable[Addend]],
        groups: Iterable[Group],
        finish: str = "STORE",
        short: bool = True,
        merge: bool = True,
    ) -> Vector:
        groups, outputs = list(groups), [list(x) for x in outputs]
        rows = merged(outputs, groups, self.slots, self.e.wraps) if merge else None
        families = [g for g in groups if g.is_family]
        scalars = [g for g in groups if not g.is_family]
        terms, goals = self._made(name, rows or outputs, short)
        count = len(outputs)
        return Vector(name, terms, goals, families, scalars, count, finish, is_merged=bool(rows))

    def totals(self, name: str, addends: Iterable[Addend], short: bool = True) -> list[Terms]:
        """Returns terms with one value each, whose sum is the total."""
        return [
            self.terms(f"{name}_{k}", x.over, self._short([x.node], short))
            for k, x in enumerate(addends)
        ]

    def _made(
        self, name: str, outputs: Sequence[Iterable[Addend]], short: bool
    ) -> tuple[list[Terms], list[Goal]]:
        found: dict[Over, list[tuple[int, Addend]]] = {}
        for output, addends in enumerate(outputs):
            for x in addends:
                if x.node != ZERO:
                    found.setdefault(x.over, []).append((output, x))
        terms, goals = [], []
        for over, items in found.items():
            shorter = self._short([x.node for _, x in items], short)
            nodes: list[Node] = []
            places = [self._place(nodes, node) for node in shorter]
            parts = range(0, len(nodes), MOST_VALUES)
            own = [nodes[first : first + MOST_VALUES] for first in parts]
            more = self._added(nodes, places, items) if len(over) == 4 and len(own) == 1 else ()
            made = [
                self.terms(f"{name}_{len(terms) + k}", over, x, more) for k, x in enumerate(own)
            ]
            terms += made
            goals += [
                Goal(made[value // MOST_VALUES], value % MOST_VALUES, sign, output, x.to)
                for (value, sign), (output, x) in zip(places, items, strict=True)
                if sign
            ]
        return terms, goals

    def _added(
        self,
        nodes: list[Node],
        places: list[tuple[int, int]],
        items: list[tuple[int, Addend]],
    ) -> tuple[Node, ...]:
        """Returns the values that a term of pairs adds to rows j. The rows then take one pass over
        memory instead of two. Returns () if two values go to one row, or if the function may
        compute its values twice, as with sines."""
        g, found = self.g, {}
        if any(g.op[n] is Op.CALL and g.data[n] in ("sin", "cos") for n in reachable(g, nodes)):
            return ()
        for (value, sign), (output, x) in zip(places, items, strict=True):
            if sign and of_second(x.to[0]):
                if (output, x.to) in found:
                    return ()
                found[output, x.to] = nodes[value] if sign > 0 else g.negate(nodes[value])
        return tuple(found.values())

    def _short(self, nodes: list[Node], short: bool) -> list[Node]:
        if not short or len(reachable(self.g, nodes)) > THOROUGH:
            return nodes
        return fewest(self.g, settled(self.g, nodes))

    def _place(self, nodes: list[Node], node: Node) -> tuple[int, int]:
        """Returns the number of a value and a sign: values that are opposite, as the forces of a
        spring on its ends are, are computed once."""
        if node == ZERO:
            return 0, 0
        if node in nodes:
            return nodes.index(node), 1
        opposite = self.g.negate(node)
        if opposite in nodes:
            return nodes.index(opposite), -1
        for k, other in enumerate(nodes) if len(nodes) < 8 else ():
            if settled(self.g, [self.g.add(node, other)])[0] == ZERO:
                return k, -1
        nodes.append(node)
        return len(nodes) - 1, 1


def of_second(cell: Cell) -> bool:
    """Returns whether a cell is a member j, the second of a pair."""
    return cell[1] is not None and bool(cell[1].factor(OTHER))


def members_in(values: int) -> int:
    """Returns how many members are computed at a time by functions with so many values."""
    return max(FEWEST, min(BLOCK, MOST_ROOM // max(1, values) // FEWEST * FEWEST))


def block_of(found: Iterable[Terms], slots: Slots) -> int:
    """Returns how many members C functions of terms compute at a time. Values and copies of the
    members that they read then fit into the cache."""
    most = 1
    for terms in found:
        rows = {(s.kind, s.name) for s in slots.below(*terms.nodes) if s.at is not None}
        most = max(most, len(terms.nodes) + len(rows))
    return members_in(most)


def chunk_of(vector: Kernel, block: int) -> int:
    """Returns how many rows of a vector are computed at a time."""
    values = sum(len(terms.nodes) for terms in vector.of(2))
    return min(block, members_in(values))


def halo_of(vector: Kernel) -> int:
    """Returns how many more columns than rows a chunk has: a row reads terms at up to so many more
    indices."""
    low, high = reach(vector)
    return high - low


def added(vector: Vector, e: FamilyEquations) -> int:
    """Returns the number of values that are added to rows one by one (see members_ends.h)."""
    singles = sum(not goal.terms.over for goal in vector.goals)
    ends = sum(sum(rows_beyond(vector, g, e)) for g in vector.families)
    return singles + ends * vector.outputs


def rows_beyond(vector: Vector, g: Group, e: FamilyEquations) -> tuple[int, int]:
    """Returns how many rows below the first member of a family, and above the last one, are added
    to the members that they stand for."""
    return (0, 0) if vector.is_merged else beyond(g, e.wraps.get(g.name, 0))


def reach(vector: Kernel) -> tuple[int, int]:
    """Returns the least and the greatest offset of a row from the index of a term."""
    offsets = [
        goal.to[0][1].constant
        for goal in vector.goals
        if len(goal.terms.over) == 2 and moves(goal.to[0])
    ]
    return min(offsets, default=0), max(offsets, default=0)
