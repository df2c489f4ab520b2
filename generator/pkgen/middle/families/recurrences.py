"""Recurrences along the members of a family, such as the positions along a chain of links:

    X[m] = Phi(X[m-1], ..., q[m], ..., t)

X is called a carried value. In L it is treated like a family of coordinates, with derivatives of L
(rows) of its own. By the chain rule these rows are added to those of the variables in Phi, from the
last member to the first; M a = f is solved in the same order (back/c/families/elimination.py).
Both need the derivatives of Phi, which this module makes.
"""

from __future__ import annotations

from ...graph.affine import ROW
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Kind, Node
from ..derive.impulses import arguments_of
from .equations import Limit
from .expand import FamilyExpander
from .indexed_ir import CELLS, Carried, NotKept, Piece, Slot, Sum
from .rows import ATTITUDES, STATE, Assembler
from .slots import M

# M a = f is solved by elimination index by index. One step has as unknowns all scalar coordinates,
# and several neighbouring members of each family. This is the largest number of unknowns in a step.
FRONT = 24

MOST = 200  # members_chain.h has room for 256 entries of a row.


def carried_of(x: FamilyExpander, assembler: Assembler) -> tuple[Carried, ...]:
    """Returns the recurrences that occur in the expressions converted so far, and further ones on
    which these depend, sorted by level."""
    pieces: dict[str, tuple[Piece, ...]] = {}
    seen: set[str] = set()
    while len(seen) < len(x.carried):
        for name in [n for n in x.carried if n not in seen]:
            seen.add(name)
            values = _values(x, assembler, name)
            for k, group in enumerate(x.carried[name]):
                found = [_piece(x, assembler, lo, hi, value[k]) for lo, hi, value in values]
                pieces[group.name] = tuple(found)
    levels = _levels(pieces)
    for _ in pieces:  # repeated, because a recurrence varies with time if one that it uses does
        assembler.moving |= {
            n for n, own in pieces.items() if any(_moves(x, assembler, p) for p in own)
        }
    groups = x.coordinates
    found = [Carried(groups[name], pieces[name], levels[name]) for name in pieces]
    return tuple(sorted(found, key=lambda item: item.level))


def _values(x: FamilyExpander, assembler: Assembler, name: str) -> list[tuple]:
    """Returns (lo, hi, components) for each statement that defines a name, where the components are
    expressions for member m."""
    found = []
    for lo, hi, item in x.pieces(name):
        x.members.clear()
        value = x.value(item.value, x.loop_of(item))
        nodes = value if isinstance(value, tuple) else (value,)
        if item.range is None:
            nodes = tuple(assembler.seen_from(node, lo) for node in nodes)
        assembler.limits += x.limits_over(lo, hi)
        found.append((lo, hi, nodes))
    return found


def _piece(x: FamilyExpander, assembler: Assembler, lo, hi, value: Node) -> Piece:
    g, name = x.graph, x.slots.node
    for slot in x.slots.below(value):
        _allowed(x, assembler, slot, lo, hi)
    rate = x.derivative(value)
    coasting = assembler.coast(rate)
    if arguments_of(g, [value, rate, coasting]):
        raise NotKept("what a carried value is made of bends or jumps")
    slopes = gradient(g, value, STATE | ATTITUDES)
    cells = dict.fromkeys(
        (n, slot.at) for slot in x.slots.below(value) for n in x.rotations.moved(slot)
    )
    along = {Slot("q", *cell): x.rotations.slope(slopes, *cell, False) for cell in cells}
    by = {slot: node for slot, node in along.items() if node != ZERO}
    if len(by) > MOST:
        raise NotKept(f"a carried value is made of more than {MOST} others")
    own = [g.multiply(node, name("d" if z.at else "v", z.name, z.at)) for z, node in by.items()]
    return Piece(
        lo,
        hi,
        value,
        rate,
        coasting,
        g.sum(own),
        by,
        {slot: x.derivative(node) for slot, node in by.items()},
    )


def _allowed(x: FamilyExpander, assembler: Assembler, slot: Slot, lo, hi) -> None:
    """Raises NotKept if a symbol is not allowed in a recurrence X[m] = Phi. Coordinates with an
    index up to m are allowed, also those beyond a fixed end; rates and later members are not."""
    if slot.kind in ("v", "a") or (slot.kind == "s" and slot.name not in x.rotations.numbers):
        raise NotKept(f"a carried value is made of the rate or the state '{slot.name}'")
    if slot.kind == "sum" and not x.totals.is_fixed(slot):
        raise NotKept("a carried value is made of a sum over members")
    if slot.kind not in CELLS or slot.at is None:
        return
    distance, group = slot.at - M, x.coordinates[slot.name]
    if not distance.is_constant:
        raise NotKept(f"a carried value is made of {slot.name}[{slot.at.text()}] throughout")
    if distance.constant > 0:
        raise NotKept(f"a carried value is made of a later member of '{slot.name}'")
    if group.periodic or any(end.kind == "free" for _, end in group.ends):
        low, high = lo + distance - group.lo, group.hi - hi - distance
        if any(end.is_constant and end.constant < 0 for end in (low, high)):
            reached = f"{slot.name}[{slot.at.text({ROW: 'i'})}]"
            raise NotKept(
                f"a `let` of its own lower members reaches {reached} beyond an end of "
                f"'{slot.name}' that is free or periodic"
            )
        assembler.limits += [Limit(low, hi - lo), Limit(high, hi - lo)]
    else:
        assembler.in_reach(slot, lo, hi)


def _levels(pieces: dict[str, tuple[Piece, ...]]) -> dict[str, int]:
    """Returns the level of each recurrence: 0 if it uses no other recurrence at the same index,
    else 1 more than the highest level of the recurrences that it uses at the same index."""
    levels = dict.fromkeys(pieces, 0)
    # Each repetition finds one more level. One for each recurrence is enough, since the checker has
    # refused circular definitions.
    for _ in pieces:
        for name, found in pieces.items():
            same = {z.name for piece in found for z in piece.by if z.at == M and z.name in pieces}
            levels[name] = max((levels[z] + 1 for z in same), default=0)
    return levels


def _moves(x: FamilyExpander, assembler: Assembler, piece: Piece) -> bool:
    """Returns whether the value of a recurrence may vary with time while all coordinates are
    constant."""
    depends = x.graph.depends[piece.value] & BIT[Kind.TIME]
    inputs = any(slot.kind == "input" for slot in x.slots.below(piece.value))
    return bool(depends) or inputs or any(z.name in assembler.moving for z in piece.by)


def by_places(x: FamilyExpander, mass: Sum, carried: tuple[Carried, ...]) -> bool:
    """Returns whether M a = f can be solved by elimination index by index, with at most FRONT
    unknowns in each step. If not, the accelerations of the recurrences' values are additional
    unknowns."""
    if x.model.constraints or x.model.rotations:
        return False
    groups = x.coordinates
    mapped = {
        name
        for name, group in groups.items()
        if group.periodic or any(end.kind == "free" for _, end in group.ends)
    }
    coupled = [(row, column) for row, column in (x.to for x in mass) if row != column]
    if any({a, b} & mapped for (a, _), (b, _) in coupled):
        return False
    back = [0]
    for (_, at), (_, other) in coupled:
        back.append(0 if None in (at, other) else (other - at).constant)
    back += [(z.at - M).constant for c in carried for p in c.pieces for z in p.by if z.at]
    families = [group for group in groups.values() if group.is_family]
    return max(1, -min(back)) * len(families) + len(groups) - len(families) <= FRONT


def nodes_of(carried: tuple[Carried, ...]) -> list[Node]:
    """Returns all nodes of recurrences that are computed at run time."""
    found = []
    for piece in (piece for item in carried for piece in item.pieces):
        found += [piece.value, piece.rate, piece.coasting, *piece.by.values()]
        found += piece.by_rate.values()
    return found


def inert(names: set[str], carried: tuple[Carried, ...]) -> set[str]:
    """Returns the names of the variables that have inertia. `names` have diagonal entries in M. If
    a recurrence is among them, the variables in the recurrence have inertia too."""
    found = set(names)
    for item in reversed(carried):
        if item.group.name in found:
            found |= {z.name for piece in item.pieces for z in piece.by}
    return found
