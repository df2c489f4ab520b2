"""Switches: expressions at whose zeros the equations of motion have a kink or a jump.

step(x) and sign(x), the derivative of abs(x), jump where x vanishes; abs(x) has a kink there;
min(a, b) and max(a, b) have a kink where a - b vanishes. atan2(y, x) jumps where y vanishes and x
is negative (points/cuts.py). The expression that vanishes is called a switch. On either side of its
zeros the function has a smooth branch. The C code gets the branch as a number called side: 1 or -1
selects a branch, also beyond the zero, 0 selects none. The runtime locates the zeros and sets the
sides (pk/events.h), so that each step integrates a smooth system. A call is "held" if its branch is
set in this way.

Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
Springer 1993, section II.6, "Discontinuous equations".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from ...equations import Quantity, Switch
from ...functions import FUNCTIONS
from ...graph.calls import counts
from ...graph.differentiate import reachable
from ...graph.graph import ONE, VARIABLE, ZERO, Graph, Node, Op, Symbol
from ...graph.normal import Normal
from ...graph.substitute import substituted
from ...graph.surfaces import Surfaces, argument_of
from ...graph.wording import wording


def switches_of(
    g: Graph,
    outputs: Iterable[Node],
    name: Callable[[Symbol], str],
    cuts: Iterable[Node],
) -> tuple[Switch, ...]:
    """Returns the switches of the expressions `outputs`, and a switch for each of the nodes `cuts`
    (the y of atan2). Switches with the same zeros, such as x and -x, are returned once."""
    found: dict[object, Switch] = {}
    calls = [n for n in reachable(g, outputs, VARIABLE) if argument_of(g, n) != ZERO]
    loose = free(g, outputs)
    surfaces = Surfaces(g.copy())
    for node in calls:
        surface, sign = surfaces.of_call(node)
        if not sign:
            continue
        x = argument_of(g, node)
        counted = counts(g, x)
        words = wording(g, node if counted else x, name)
        new = Switch(Quantity(words, "", ""), x, counted=counted, held=node not in loose)
        known = found.setdefault(surface, new)
        if node in loose:
            found[surface] = replace(known, held=False)
    for y in cuts:
        found.setdefault(surfaces(y)[0], Switch(Quantity(wording(g, y, name), "", ""), y))
    return tuple(found.values())


def free(g: Graph, nodes: Iterable[Node]) -> set[Node]:
    """Returns the calls that must not be kept on one branch within a step, though steps end at the
    zeros of their arguments.

    An example is max(0, x) in max(0, x)^(3/2), where the kink is at the end of the domain of the
    power. A step may go a little beyond the kink to x < 0. If max(0, x) kept its branch x there,
    the power of the negative x would be undefined."""
    g, found = g.copy(), set()
    for n in reachable(g, nodes, VARIABLE):
        ends = _ends(g, n)
        calls = reachable(g, g.args[n][:1], VARIABLE) if ends else ()
        found |= {c for c in calls if argument_of(g, c) != ZERO and _may_be(g, n, c, ends)}
    return found


def _ends(g: Graph, node: Node) -> tuple[int, ...]:
    """Returns the end points of the domain of a power or a function call; () if there are none."""
    if g.op[node] is Op.POWER:
        return (0,) if g.data[node].denominator != 1 else ()
    return FUNCTIONS[g.data[node]].ends if g.op[node] is Op.CALL else ()


def _may_be(g: Graph, node: Node, call: Node, ends: tuple[int, ...]) -> bool:
    """Whether the argument of `node` may have one of the values `ends` at the kink or jump of
    `call`."""
    name, args = g.data[call], g.args[call]
    at = [ZERO]
    if name in ("step", "sign"):
        at = [ONE, ZERO if name == "step" else g.negate(ONE)]
    if name in ("min", "max"):
        at = sorted(args, key=lambda a: g.depends[a] & VARIABLE)[:1]
    for value in at:
        try:
            (there,) = substituted(g, g.args[node][:1], {call: value})
        except ZeroDivisionError:
            return True
        if g.depends[there] & VARIABLE or any(
            Normal(g)(g.subtract(there, g.number(x))) == {} for x in ends
        ):
            return True
    return False


def sides(
    g: Graph, switches: Sequence[Switch], positions: Iterable[Node]
) -> dict[Node, tuple[int, int]]:
    """Returns a map from each call that is kept on one branch within a step to (index of its
    switch, sign). The sign is 1 if the call's argument has the sign of the switch, -1 if it has the
    opposite sign. If velocities jump at a switch, all
    its calls in the nodes `positions` (potential, mass) are included."""
    surfaces, found = Surfaces(g.copy()), {}
    places = {surfaces(x.node)[0]: (k, surfaces(x.node)[1]) for k, x in enumerate(switches)}
    loose = free(g, range(len(g))) if places else set()
    placed = set(reachable(g, positions, VARIABLE))
    for node in range(len(g) if places else 0):
        surface, sign = surfaces.of_call(node)
        if g.op[node] is Op.CALL and FUNCTIONS[g.data[node]].cut:
            surface, sign = surfaces(g.args[node][0])
        if surface not in places:
            continue
        k, side = places[surface]
        if node not in loose or (switches[k].impulse and node in placed):
            found[node] = k, sign * side
    return found
