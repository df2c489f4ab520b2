"""Switches: where the equations of motion change from one smooth form to another.

step(x), and the sign of x that differentiating abs makes, jump where x vanishes; abs(x) has a kink
there, and min(a, b) and max(a, b) have one where a - b does. Each such x is a switch: on either
side of its zero the function is a smooth one, and which side it is, is a number beside the
parameters. The runtime locates the zeros and sets the sides (pk/events.h), so that a step is one of
a smooth system; side 0 leaves the function as it is.

Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
Springer 1993, section II.6, "Discontinuous equations".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction

from ..equations import Quantity, Switch
from .differentiate import reachable
from .graph import ONE, VARIABLE, ZERO, Graph, Node, Op, Symbol
from .normal import Normal
from .wording import wording

# What each of them is called where its side is given too, as a first argument.
SIDED = {name: f"side_{name}" for name in ("step", "sign", "abs", "min", "max")}


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
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Those of the equations that `outputs` are, each surface once: of x and -x the first."""
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
    return tuple(found.values())


def free(g: Graph, nodes: Iterable[Node]) -> set[Node]:
    """The calls that stand in what has no value everywhere, max(0, x) of max(0, x)^(3/2) say: a
    step that is held on one side goes a little beyond the zero, where that is no number. They stay
    as they are, and steps end at their zeros all the same."""
    bounded = [a for n in reachable(g, nodes, VARIABLE) if _bounded(g, n) for a in g.args[n]]
    return {n for n in reachable(g, bounded, VARIABLE) if argument_of(g, n) != ZERO}


def sides(g: Graph, switches: Iterable[Switch]) -> dict[Node, tuple[int, int]]:
    """Of each call that is held: by which switch, and 1 or -1 as its own argument has the sign of
    the switch's or the other."""
    surfaces, found = Surfaces(g.copy()), {}
    places = {surfaces(x.node)[0]: (k, surfaces(x.node)[1]) for k, x in enumerate(switches)}
    loose = free(g, range(len(g))) if places else set()
    for node in range(len(g) if places else 0):
        surface, sign = surfaces.of_call(node)
        if surface in places and node not in loose:
            k, side = places[surface]
            found[node] = k, sign * side
    return found


def _bounded(g: Graph, node: Node) -> bool:
    """Whether it has a value for some arguments alone."""
    if g.op[node] is Op.POWER:
        return g.data[node].denominator != 1
    return g.op[node] is Op.CALL and g.data[node] in ("sqrt", "log", "asin", "acos", "pow")


def argument_of(g: Graph, node: Node) -> Node:
    """What decides a call, without a number in front; 0 of what is smooth."""
    argument = _deciding(g, node)
    scale, rest = g.split(argument)
    return argument if g.op[scale] is not Op.NUMBER or rest == ONE else rest


def _deciding(g: Graph, node: Node) -> Node:
    if g.op[node] is not Op.CALL or g.data[node] not in SIDED:
        return ZERO
    a, *b = g.args[node]
    return g.subtract(a, *b) if b else a
