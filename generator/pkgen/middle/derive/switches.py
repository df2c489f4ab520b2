"""Switches: where the equations of motion change from one smooth form to another.

step(x), and the sign of x that differentiating abs makes, jump where x vanishes; abs(x) has a kink
there, and min(a, b) and max(a, b) have one where a - b does. atan2(y, x) jumps where y vanishes and
x is negative (points/cuts.py). Each such argument is a switch: on either side of its zero the
function is a smooth one, and the side is a number beside the parameters. The runtime locates the
zeros and sets the sides (pk/events.h), so that a step is one of a smooth system; side 0 leaves the
function as it is.

Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
Springer 1993, section II.6, "Discontinuous equations".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction

from ...equations import Quantity, Switch
from ...functions import FUNCTIONS
from ...graph.differentiate import reachable
from ...graph.graph import ONE, VARIABLE, ZERO, Graph, Node, Op, Symbol
from ...graph.normal import Normal
from ...graph.substitute import substituted
from ...graph.wording import wording


class Surfaces:
    """Which arguments vanish in the same places: those with one normal form, but for a number in
    front. What that makes on the way is added to the graph."""

    def __init__(self, g: Graph):
        self.graph = g
        self.normal = Normal(g)

    def __call__(self, argument: Node) -> tuple[object, int]:
        """What is the same for all of these, and a sign."""
        form = self.normal(argument)
        if not form:
            return argument, 1
        first = Fraction(form[min(form)])
        return frozenset((m, c / first) for m, c in form.items()), 1 if first > 0 else -1

    def of_call(self, node: Node) -> tuple[object, int]:
        """That of the argument by which a call is decided; None where it is smooth."""
        g = self.graph
        argument = _deciding(g, node)
        if argument == ZERO or not g.depends[argument] & VARIABLE:
            return None, 0
        return self(argument)


def switches_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str], cuts: Iterable[Node]
) -> tuple[Switch, ...]:
    """Those of the equations that `outputs` are, and the zeros of `cuts`, each surface once: of x
    and -x the first."""
    found: dict[object, Switch] = {}
    calls = [n for n in reachable(g, outputs, VARIABLE) if argument_of(g, n) != ZERO]
    loose = free(g, outputs)
    surfaces = Surfaces(g.copy())
    for node in calls:
        surface, sign = surfaces.of_call(node)
        if not sign:
            continue
        x = argument_of(g, node)
        known = found.setdefault(surface, Switch(Quantity(wording(g, x, name), "", ""), x))
        if node in loose:
            found[surface] = replace(known, held=False)
    for y in cuts:
        found.setdefault(surfaces(y)[0], Switch(Quantity(wording(g, y, name), "", ""), y))
    return tuple(found.values())


def free(g: Graph, nodes: Iterable[Node]) -> set[Node]:
    """The calls in a function of limited domain that may reach the end of it where they bend,
    max(0, x) of max(0, x)^(3/2) say: a step that is held on one side goes a little beyond the zero,
    where that is no number. They are not held, and steps end at their zeros all the same."""
    g, found = g.copy(), set()
    for n in reachable(g, nodes, VARIABLE):
        ends = _ends(g, n)
        calls = reachable(g, g.args[n][:1], VARIABLE) if ends else ()
        found |= {c for c in calls if argument_of(g, c) != ZERO and _may_be(g, n, c, ends)}
    return found


def _ends(g: Graph, node: Node) -> tuple[int, ...]:
    """Where what has a value for some arguments alone ceases to have one."""
    if g.op[node] is Op.POWER:
        return (0,) if g.data[node].denominator != 1 else ()
    return FUNCTIONS[g.data[node]].ends if g.op[node] is Op.CALL else ()


def _may_be(g: Graph, node: Node, call: Node, ends: tuple[int, ...]) -> bool:
    """Whether the argument of `node` may be one of `ends` where `call` bends or jumps."""
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
    """Of each call that is held: by which switch, and 1 or -1 as its own argument has the sign of
    the switch's or the other. Where a row of `positions` jumps, they are held as it is."""
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


def argument_of(g: Graph, node: Node) -> Node:
    """What decides a call, without a number in front; 0 of what is smooth."""
    argument = _deciding(g, node)
    scale, rest = g.split(argument)
    return argument if g.op[scale] is not Op.NUMBER or rest == ONE else rest


def _deciding(g: Graph, node: Node) -> Node:
    if g.op[node] is not Op.CALL or FUNCTIONS[g.data[node]].smooth:
        return ZERO
    a, *b = g.args[node]
    return g.subtract(a, *b) if b else a
