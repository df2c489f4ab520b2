"""Solves M a = f of a chain by elimination, index by index: the formulas of one index, as C blocks.

Each index passes a symmetric matrix `front` on to the next lower index. Its rows and columns belong
to variables of lower indices and to scalar coordinates. The step from an index to the next is
repeated until it adds no nonzero entry; this gives the pattern of `front`. The matrix `bulk` is
`front` without elimination of coordinates. Its diagonal is that of the mass matrix M, and a pivot
must be positive in comparison with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ....graph.graph import ZERO, Graph, Node
from ....middle.families.indexed_ir import Addend, Group
from ...targets import STORE, Target
from .blocks import INNER, Block
from .carried import BESIDE, Carrying, Clear, Variable
from .kernels import Vector

Pair = tuple[Variable, Variable]


@dataclass
class MassRows:
    """The row of the matrix M~ (see carried.py) of one family: the entries in columns of the
    same and of lower indices, as a vector with an output for each."""

    group: dict
    number: int
    vector: Vector
    clears: list[Clear]
    first: int  # the number of its first entry in memory
    is_padded: bool  # whether it is a coordinate; its pivot is 1 outside its range

    @property
    def outs(self) -> list[str]:
        """The C arrays of the vector's outputs."""
        return [f"out_{k}" for k in range(self.vector.outputs)]


class _Symmetric:
    """A symmetric matrix of graph nodes, indexed by pairs of variables."""

    def __init__(self, g: Graph):
        self.g = g
        self.entries: dict[Pair, Node] = {}

    def __call__(self, a: Variable, b: Variable) -> Node:
        return self.entries.get(_pair(a, b), ZERO)

    def add(self, a: Variable, b: Variable, node: Node) -> None:
        if node != ZERO:
            self.entries[_pair(a, b)] = self.g.add(self(a, b), node)

    def row(self, a: Variable) -> dict[Variable, Node]:
        """Returns the off-diagonal entries of a row."""
        return {y if x == a else x: n for (x, y), n in self.entries.items() if (x == a) != (y == a)}

    def without(self, a: Variable) -> None:
        self.entries = {pair: n for pair, n in self.entries.items() if a not in pair}

    def put(self, a: Variable, slopes: list[tuple[Variable, Node]]) -> None:
        """Replaces the variable `a` by the sum of slope * x over the pairs (x, slope) of
        `slopes`."""
        own, row = self(a, a), self.row(a)
        self.without(a)
        multiply = self.g.multiply
        for k, (x, slope) in enumerate(slopes):
            for y, node in row.items():
                twice = multiply(self.g.number(2), slope) if x == y else slope
                self.add(x, y, multiply(twice, node))
            for y, other in slopes[k:]:
                self.add(x, y, multiply(multiply(slope, other), own))


def _pair(a: Variable, b: Variable) -> Pair:
    return (a, b) if a <= b else (b, a)


class Elimination:
    """The elimination at one index, in two versions: one for low indices, near the first member,
    where the recurrence values may have other definitions, and one for all other indices."""

    def __init__(self, of: Carrying):
        self.of, self.g = of, of.g
        self.mass = list(self._mass_rows())
        # Entries of M~ that couple scalars, each pair once, in order.
        pairs = dict.fromkeys((x.to[0][0], x.to[1][0]) for x in of.e.mass if x.to[0][1] is None)
        alone = (pair for pair in pairs if pair[1] in of.scalar)
        self.corner = [(a, b) for a, b in alone if of.scalar[a] <= of.scalar[b]]
        self.coordinates = [k for k, rows in enumerate(self.mass) if rows.is_padded]
        self.front: dict[Pair, int] = {}
        self.bulk: dict[Pair, int] = {}
        self.kept: dict[tuple[int, Variable], int] = {}
        for low in (False, True):
            count = -1
            while count != len(self.front) + len(self.bulk):
                count = len(self.front) + len(self.bulk)
                self._stepped(low)
            if not low:  # Entries that only low indices have come last.
                self._common = len(self.front), len(self.bulk)
        self.steps = {low: self._step(low) for low in (False, True)}
        self.backs = {low: self._back(low) for low in (False, True)}

    # -- the rows of M~ -----------------------------------------------------------------------

    def _mass_rows(self) -> Iterator[MassRows]:
        of, e = self.of, self.of.e
        self.entries: list[list[tuple[Variable, int]]] = []
        first = 0
        for name, group in of.groups.items():
            number = of.number[name]
            found: dict[Variable, list[Addend]] = {}
            for x in e.mass:
                (own, row), (other, column) = x.to
                if own != name:
                    continue
                at = (
                    (BESIDE, of.scalar[other])
                    if column is None
                    else ((column - row).constant, of.number[other])
                )
                if column is None or at[0] < 0 or (at[0] == 0 and at[1] <= number):
                    found.setdefault(at, []).append(Addend(x.over, x.node, x.to[:1]))
            self.entries.append([(at, k) for k, at in enumerate(found)])
            made = of.make.vector(f"inertia_{of.places.ids[name]}", [*found.values()], [group])
            clears = [self._clear(group, at, k) for k, at in enumerate(found)]
            is_own = not group.is_carried
            yield MassRows(of.places.group(group), number, made, clears, first, is_own)
            first += len(found)

    def _clear(self, group: Group, at: Variable, k: int) -> Clear:
        of, lo, hi = self.of, [group.lo], [group.hi]
        if at[0] != BESIDE:
            other = [*of.groups.values()][at[1]]
            lo.append(other.lo - at[0])
            hi.append(other.hi - at[0])
        return Clear("", k, of.most(lo), of.least(hi))

    # -- elimination at one index ----------------------------------------------------------------

    def _incoming(self, low: bool) -> tuple[_Symmetric, _Symmetric]:
        front, bulk = _Symmetric(self.g), _Symmetric(self.g)
        for name, matrix, places in (("front", front, self.front), ("bulk", bulk, self.bulk)):
            for pair, k in places.items():
                if low or not hasattr(self, "_common") or self._is_common(name, k):
                    matrix.entries[pair] = self.of.place(f"{name}[{k}]")
        for number, entries in enumerate(self.entries):
            for at, k in entries:
                node = self.of.place(f"inertia_{number}[{k} * span]")
                front.add((0, number), at, node)
                bulk.add((0, number), at, node)
            if self.mass[number].is_padded:
                node = self.of.place(f"absent[{number}]")
                front.add((0, number), (0, number), node)
        return front, bulk

    def _is_common(self, name: str, k: int) -> bool:
        return k < self._common[name == "bulk"]

    def _stepped(self, low: bool) -> tuple[_Symmetric, _Symmetric, list[Target]]:
        """Returns `front` and `bulk` for the next lower index, and the stores of pivots, factors
        and forces."""
        of, g = self.of, self.g
        front, bulk = self._incoming(low)
        right: dict[Variable, Node] = {}
        targets = []

        def force(at: Variable) -> Node:
            return right.get(at) or of.place(of.cell(at))

        for item in reversed(of.e.carried):
            own = (0, of.number[item.group.name])
            slopes = list(of.slope(item.group.name, low))
            front.put(own, slopes)
            bulk.put(own, slopes)
            for at, slope in slopes:
                right[at] = g.add(force(at), g.multiply(slope, force(own)))
            right.pop(own, None)
        for number in self.coordinates:
            own = (0, number)
            pivot, row = front(own, own), front.row(own)
            inverse = g.power(pivot, -1)
            targets.append(Target(STORE, f"pivot[{number}]", (pivot,)))
            targets.append(Target(STORE, f"diagonal[{number}]", (bulk(own, own),)))
            scaled = g.multiply(force(own), inverse)
            front.without(own)
            bulk.without(own)
            factors = {at: g.multiply(node, inverse) for at, node in row.items()}
            for at, factor in factors.items():
                k = self.kept.setdefault((number, at), len(self.kept))
                targets.append(Target(STORE, f"kept[{k}]", (factor,)))
            rest = list(row.items())
            for k, (x, node) in enumerate(rest):
                for y, _ in rest[k:]:
                    front.add(x, y, g.negate(g.multiply(node, factors[y])))
                right[x] = g.subtract(force(x), g.multiply(node, scaled))
            right[own] = scaled
        for matrix, places in ((front, self.front), (bulk, self.bulk)):
            handed = {_pair(_next(a), _next(b)): node for (a, b), node in matrix.entries.items()}
            matrix.entries = handed
            for pair in handed:
                places.setdefault(pair, len(places))
        targets += [Target(STORE, of.cell(at), (node,)) for at, node in right.items()]
        return front, bulk, targets

    def _step(self, low: bool) -> Block:
        front, bulk, targets = self._stepped(low)
        for name, matrix, places in (("front", front, self.front), ("bulk", bulk, self.bulk)):
            for pair, k in places.items():
                if low or self._is_common(name, k):
                    targets.append(Target(STORE, f"{name}[{k}]", (matrix(*pair),)))
        return Block(targets, INNER)

    def _back(self, low: bool) -> Block:
        """Returns the block that computes the accelerations at one index from those at lower
        indices."""
        of, g = self.of, self.g
        known: dict[Variable, Node] = {}

        def value(at: Variable) -> Node:
            return known.get(at) or of.place(of.cell(at))

        seen = self._rows_kept(low)
        for number in reversed(self.coordinates):
            terms = [
                g.negate(g.multiply(of.place(f"kept[{self.kept[number, at]}]"), value(at)))
                for at in seen[number]
            ]
            known[0, number] = g.sum((of.place(of.cell((0, number))), *terms))
        for item in of.e.carried:
            terms = [g.multiply(slope, value(at)) for at, slope in of.slope(item.group.name, low)]
            known[0, of.number[item.group.name]] = g.sum(terms)
        return Block([Target(STORE, of.cell(at), (node,)) for at, node in known.items()], INNER)

    def _rows_kept(self, low: bool) -> dict[int, list[Variable]]:
        _, _, targets = self._stepped(low)
        stored = {target.where for target in targets}
        return {
            number: [
                at for (n, at), k in self.kept.items() if n == number and f"kept[{k}]" in stored
            ]
            for number in self.coordinates
        }


def of_scalars(chain: Elimination) -> Block:
    """Returns the block that solves for the scalar coordinates, the last unknowns."""
    of, g = chain.of, chain.g
    front, bulk = _Symmetric(g), _Symmetric(g)
    for name, matrix, places in (("front", front, chain.front), ("bulk", bulk, chain.bulk)):
        for pair, k in places.items():
            if pair[0][0] == BESIDE:
                matrix.entries[pair] = of.place(f"{name}[{k}]")
    for k, (a, b) in enumerate(chain.corner):
        for matrix in (front, bulk):
            matrix.add((BESIDE, of.scalar[a]), (BESIDE, of.scalar[b]), of.place(f"corner[{k}]"))
    targets, right, factors = [], {}, {}
    for k in of.scalar.values():
        right[k] = of.place(of.cell((BESIDE, k)))
    for k in of.scalar.values():
        own = (BESIDE, k)
        pivot, row = front(own, own), front.row(own)
        targets.append(Target(STORE, f"pivot[{k}]", (pivot,)))
        targets.append(Target(STORE, f"diagonal[{k}]", (bulk(own, own),)))
        if pivot == ZERO:
            return Block(targets, INNER)
        inverse = g.power(pivot, -1)
        front.without(own)
        factors[k] = {at: g.multiply(node, inverse) for at, node in row.items()}
        scaled = g.multiply(right[k], inverse)
        rest = list(row.items())
        for i, (x, node) in enumerate(rest):
            for y, _ in rest[i:]:
                front.add(x, y, g.negate(g.multiply(node, factors[k][y])))
            right[x[1]] = g.subtract(right[x[1]], g.multiply(node, scaled))
        right[k] = scaled
    for k in reversed(of.scalar.values()):
        for at, factor in factors[k].items():
            right[k] = g.subtract(right[k], g.multiply(factor, right[at[1]]))
        targets.append(Target(STORE, of.cell((BESIDE, k)), (right[k],)))
    return Block(targets, INNER)


def _next(at: Variable) -> Variable:
    """Returns the same variable, with an offset that counts from the next lower index."""
    offset, number = at
    return at if offset == BESIDE else (offset + 1, number)
