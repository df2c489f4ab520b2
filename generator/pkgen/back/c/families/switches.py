"""Switches of families that are loops: which switch selects the branch of a function call.

A switch is a function whose sign selects the branch of calls with a kink or jump, such as abs(x).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ....graph.affine import ROW, Affine
from ....graph.differentiate import reachable
from ....graph.graph import VARIABLE, ZERO, Node, Symbol
from ....graph.surfaces import Surfaces, deciding
from ....middle.derive.switches import free
from ....middle.families.equations import FamilyEquations
from ....middle.families.slots import Slots
from ....middle.families.switches import Members
from .kernels import Terms
from .places import Places


def terms(e: FamilyEquations) -> Iterator[Terms]:
    """Yields the switching function of each switch. The switch of a family has a value for each
    index between the least and the greatest at which it occurs."""
    for k, x in enumerate(e.switches):
        over: tuple[Affine, ...] = ()
        if x.ranges[0]:
            over = tuple(Affine(0, ((f"{which}{k}'", 1),)) for which in ("least", "most"))
        yield Terms(f"switch_{k}", over, [x.node])


def sides(
    e: FamilyEquations, slots: Slots, nodes: Iterable[Node]
) -> dict[Node, tuple[Symbol, int]]:
    """Returns a pair for each function call whose branch is fixed during a step. A switch selects
    the branch. The first of the pair is the symbol whose value is the sign of the switch; the
    second is 1 if the argument of the call has this sign, -1 if it has the other. May add nodes."""
    found: dict[Node, tuple[Symbol, int]] = {}
    if not e.switches:
        return found
    g, roots = slots.graph, [*nodes]
    members, surfaces = Members(g, slots), Surfaces(g)
    known = {surfaces(x.node)[0]: (k, surfaces(x.node)[1]) for k, x in enumerate(e.switches)}
    loose = free(g, roots)
    for call in reachable(g, roots, VARIABLE):
        argument = deciding(g, call)
        if argument == ZERO or call in loose:
            continue
        node, at = members(argument)
        surface, sign = surfaces(node)
        if surface in known:
            k, side = known[surface]
            own = slots.node("side", str(k), at if e.switches[k].ranges[0] else None)
            found[call] = g.data[own], sign * side
    return found


def described(e: FamilyEquations, places: Places) -> Iterator[dict[str, Any]]:
    """Yields a row of the table for each switch."""
    for x in e.switches:
        ranges = [r or (Affine(), Affine()) for r in x.ranges]
        yield {
            "name": x.name,
            "ranges": [tuple(map(places.index, r)) for r in ranges],
            "text": ", ".join(" .. ".join(at.text({ROW: "i"}) for at in r) for r in x.ranges if r),
        }
