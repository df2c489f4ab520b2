"""Finds the singularities of equations with loops: expressions that must not vanish, with a value
for each member.

Divisors and arguments of roots and logarithms are found as in points/singularities.py, once for all
members. The runtime checks the value of each member. To check only the smallest value would not be
enough: if one member passes through zero within a step, another member may have a smaller value at
both ends of the step.

A pivot of a banded M has no closed expression, nor has a diagonal entry of M with contributions of
several sums with different ranges. In these cases the pivots that the factorization computes at run
time are checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from ...graph.affine import OTHER, ROW
from ...graph.collect import settled
from ...graph.graph import BIT, ZERO, Graph, Kind, Node, Symbol
from ...graph.ranges import INF, Range, Ranges
from ...graph.wording import wording
from ...indices import indexed
from ..points.cuts import half_cosine, jumping_angles
from ..points.singularities import COORDINATES, CUT, DIVISOR, about, dangerous, squared, zeros
from ..quantities import input_quantities
from .equations import FamilyEquations, FamilySingularity
from .expand import FamilyExpander
from .indexed_ir import Addend, Group, Over, Sum
from .indices import unlike_loops
from .slots import M

MOVES = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE] | BIT[Kind.TIME]
# The text that follows the name of a coordinate or state, for each kind of symbol (see Slot).
# Symbols of kind "a" occur only as time derivatives of states.
_PRIMES = {"v": "'", "d": "'", "a": "'"}
_Guarded = tuple[Over, Node]


def singularities_of(
    x: FamilyExpander, e: FamilyEquations
) -> tuple[tuple[FamilySingularity, ...], bool]:
    """Returns the singularities, first those where M is singular, and whether the pivots of M are
    singularities too."""
    return _Singularities(x, e).found()


class _Singularities:
    def __init__(self, x: FamilyExpander, e: FamilyEquations):
        self.x, self.e, self.g = x, e, x.graph
        self.ranges = Ranges(x.graph, [])
        self.ranges.known.update(_known(x, e))
        for k, total in enumerate(x.totals.all):
            self.ranges.known[x.slots.node("sum", str(k))] = self._of_total(total)

    def found(self) -> tuple[tuple[FamilySingularity, ...], bool]:
        charts, pivots = self._charts()
        motions: dict[_Guarded, str] = {}
        for over, output in outputs_of(self.x, self.e):
            for base, use in dangerous(self.g, self.ranges, [output]):
                for node, _ in zeros(self.g, self.ranges, base):
                    found = self._canonical(over, node)
                    if moves(self.x, node) and (found not in motions or use == DIVISOR):
                        motions[found] = use
        for body in self.e.lagrangian:
            for angle in jumping_angles(self.g, [body.node], self.ranges):
                motions[self._canonical(body.over, half_cosine(self.g, angle))] = CUT
        kept = dict.fromkeys(charts, COORDINATES)
        kept |= {found: use for found, use in motions.items() if found not in kept}
        roots = [(over, square) for over, node in kept for square in squared(self.g, node)]
        for root in roots:  # if both sqrt(x) and x are singularities, only sqrt(x) is kept
            kept.pop(root, None)
        singularities = [
            FamilySingularity(shown(self.x, node), kept[over, node], over, node)
            for over, node in self._distinct(kept)
        ]
        return tuple(singularities), pivots

    def _distinct(self, found: Iterable[_Guarded]) -> list[_Guarded]:
        """Returns the entries without duplicates: of two entries that are equal up to sign, one is
        kept."""
        kept: list[_Guarded] = []
        for over, node in found:
            same = [
                ways(node, other)
                for there, other in kept
                if there == over
                for ways in (self.g.subtract, self.g.add)
            ]
            if ZERO not in settled(self.g, same):
                kept.append((over, node))
        return kept

    def _of_total(self, total: Sum) -> Range:
        """Returns an interval that contains the value of a total, whose sums may be empty."""
        if not all(self.ranges(x.node).not_negative for x in total):
            return Range(-INF, INF)
        constant = self.ranges(self.g.sum(x.node for x in total if not x.over))
        return Range(constant.lo, INF, constant.below)

    # -- singularities of M -------------------------------------------------------------------

    def _charts(self) -> tuple[dict[_Guarded, None], bool]:
        """Returns two results: the factors of the entries of a diagonal M that may vanish, and
        whether the pivots of M have to be checked at run time."""
        e = self.e
        found: dict[_Guarded, None] = {}
        if e.facts.mass_constant:
            return found, False
        if not e.mass_diagonal or e.carried:
            return found, True
        pivots = False
        for group in e.coordinates:
            entry = self._single(group)
            if entry is None:
                pivots |= not self._positive(group)
                continue
            over, node = entry
            for factor, _ in zeros(self.g, self.ranges, node):
                if moves(self.x, factor):
                    found[self._canonical(over, factor)] = None
        return found, pivots

    def _diagonal(self, group: Group) -> list[_Guarded]:
        """Returns the addends to the diagonal entry of M for a family or scalar."""
        own = [x for x in self.e.mass if x.to[0] == x.to[1] and x.to[0][0] == group.name]
        return [seen_from_row(self.x, x) for x in own]

    def _single(self, group: Group) -> _Guarded | None:
        """Returns the diagonal entry of M for a family or scalar, with its index range; None if it
        consists of addends with different ranges."""
        found = self._diagonal(group)
        over = found[0][0]
        if any(there != over for there, _ in found) or bool(over) != group.is_family:
            return None
        return over, self.g.sum(node for _, node in found)

    def _positive(self, group: Group) -> bool:
        """Returns whether the diagonal entry of M is proved positive for all members: all addends
        are nonnegative, and one addend for all members is positive."""
        found = self._diagonal(group)
        always = [node for over, node in found if _covers(over, group)]
        return all(self.ranges(node).not_negative for _, node in found) and any(
            self.ranges(node).positive for node in always
        )

    # -- shifted indices ----------------------------------------------------------------------

    def _canonical(self, over: Over, node: Node) -> _Guarded:
        """Returns the expression `node`, with all indices shifted so that the least index is m, and
        the range of m. If an expression occurs in the equations of several members, the results are
        equal."""
        slots = self.x.slots.below(node)
        members = [s.at for s in slots if s.at is not None and s.at.factor(ROW)]
        if len(over) != 2:
            return over, node
        if not members:
            return (over if any(slot.kind == "index" for slot in slots) else ()), node
        least = min([(at - M).constant for at in members if (at - M).is_constant], default=0)
        lo, hi = over
        return (lo + least, hi + least), self.x.slots.shifted(node, -least)


def seen_from_row(x: FamilyExpander, addend: Addend) -> _Guarded:
    """Returns the range of the member to which an addend is added, and the addend's node, with the
    indices in it shifted so that this member has the index m."""
    at = addend.to[0][1]
    if len(addend.over) != 2 or at is None:
        return addend.over, addend.node
    shift = (at - M).constant
    lo, hi = addend.over
    return (lo + shift, hi + shift), x.slots.shifted(addend.node, -shift)


def outputs_of(x: FamilyExpander, e: FamilyEquations) -> Iterator[tuple[Over, Node]]:
    """Yields all expressions from which accelerations are computed, with their index ranges."""
    nodes = []
    for over, node in _rows(e):
        nodes.append(node)
        yield over, node
    for slot in x.totals.below(*nodes):
        if slot.kind == "sum":
            yield from ((a.over, a.node) for a in x.totals.all[int(slot.name)])


def _rows(e: FamilyEquations) -> Iterator[tuple[Over, Node]]:
    for found in (e.force, e.mass, *(bound.all for bound in e.bound)):
        yield from ((x.over, x.node) for x in found)
    for nodes in e.given.values():
        yield from (((), node) for node in nodes)
    for piece in (piece for item in e.carried for piece in item.pieces):
        for node in (piece.rate, *piece.by.values()):
            yield (piece.lo, piece.hi), node


def moves(x: FamilyExpander, node: Node) -> bool:
    """Returns whether the value of an expression may vary with time."""
    moving = ("input", "w", "a")
    return bool(x.totals.depends(node) & MOVES) or any(
        slot.kind in moving for slot in x.totals.below(node)
    )


def shown(x: FamilyExpander, node: Node) -> str:
    """Returns an expression as text with the indices i and j for m and j; in messages at run time
    they become numbers. Sums in it have the indices k and l."""
    return wording(x.graph, about(x.graph, node), _name(x, {ROW: "i", OTHER: "j"}))


def _name(x: FamilyExpander, letters: dict[str, str]) -> Callable[[Symbol], str]:
    names = {unlike_loops(size.name): size.name for size in x.model.sizes} | letters
    inputs = input_quantities(x.model, x.orders)

    def name(symbol: Symbol) -> str:
        if symbol.kind is Kind.TIME:
            return "t"
        slot = x.slots.all[symbol.index]
        if slot.kind == "index":
            return names[slot.name]
        if slot.kind == "input":
            return inputs[int(slot.name)].name
        if slot.kind == "sum":
            return _total(x, x.totals.all[int(slot.name)])
        at = None if slot.at is None else slot.at.text(names).replace(" ", "")
        group = x.coordinates.get(slot.name)
        if group is not None and group.is_turn:
            return indexed(group.shown, at)
        return indexed(slot.name, at) + _PRIMES.get(slot.kind, "")

    return name


def _total(x: FamilyExpander, found: Sum) -> str:
    letters, parts = {ROW: "k", OTHER: "l"}, []
    names = {unlike_loops(size.name): size.name for size in x.model.sizes} | letters
    for addend in found:
        text = wording(x.graph, addend.node, _name(x, letters))
        at = [end.text(names).replace(" ", "") for end in addend.over]
        ends = zip("kl", at[::2], at[1::2], strict=False)
        ranges = [f"{letter} = {lo}..{hi}" for letter, lo, hi in ends]
        parts.append(f"sum({', '.join([text, *ranges])})" if addend.over else text)
    return parts[0] if len(parts) == 1 else f"({' + '.join(parts)})"


def _covers(over: Over, group: Group) -> bool:
    if not (over and group.is_family):
        return not (over or group.is_family)
    before, behind = group.lo - over[0], over[1] - group.hi
    return all(x.is_constant and x.constant >= 0 for x in (before, behind))


def _known(x: FamilyExpander, e: FamilyEquations) -> dict[Node, Range]:
    """Maps each parameter and each size, as a node, to the range of its possible values."""
    g, found = x.graph, {}
    bounds = dict(zip(x.parameters, e.bounds, strict=True))
    for slot in list(x.slots.all):
        if slot.kind == "param":
            given, own = x.parameters[slot.name].declared.bounds, bounds[slot.name]
            lo, hi = _number(g, own.lo, -INF), _number(g, own.hi, INF)
            found[x.slots.node("param", slot.name, slot.at)] = Range(
                lo, hi, given.lo_open, given.hi_open
            )
        elif slot.kind == "size":
            found[x.slots.node("size", slot.name, slot.at)] = Range(1)
    return found


def _number(g: Graph, node: Node | None, otherwise: float) -> float:
    value = None if node is None else g.value(node)
    return otherwise if value is None else float(value)
