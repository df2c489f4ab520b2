"""The zeros at which functions with a kink or a jump change branch."""

from __future__ import annotations

from fractions import Fraction

from ..functions import FUNCTIONS
from .differentiate import reachable
from .graph import ONE, VARIABLE, ZERO, Graph, Node, Op
from .normal import Normal
from .substitute import rebuilt, substituted


class Surfaces:
    """Recognizes arguments with the same zeros, whose normal forms differ only by a numeric factor.
    Adds nodes to the graph."""

    def __init__(self, g: Graph):
        self.graph = g
        self.normal = Normal(g)

    def __call__(self, argument: Node) -> tuple[object, int]:
        """Returns two results: a key for dictionaries that is equal for arguments with the same
        zeros, and the sign of the argument's numeric factor."""
        form = self.normal(argument)
        if not form:
            return argument, 1
        first = Fraction(form[min(form)])
        return frozenset((m, c / first) for m, c in form.items()), 1 if first > 0 else -1

    def of_call(self, node: Node) -> tuple[object, int]:
        """Applies __call__ to the argument at whose zeros a function call has a kink or a jump.
        Returns (None, 0) if `node` is no such call."""
        g = self.graph
        argument = deciding(g, node)
        if argument == ZERO or not g.depends[argument] & VARIABLE:
            return None, 0
        return self(argument)


def argument_of(g: Graph, node: Node) -> Node:
    """Returns the argument at whose zeros a call has a kink or a jump, divided by its numeric
    factor; ZERO for any other node."""
    argument = deciding(g, node)
    scale, rest = g.split(argument)
    return argument if g.op[scale] is not Op.NUMBER or rest == ONE else rest


def deciding(g: Graph, node: Node) -> Node:
    """Returns the argument at whose zeros a call has a kink or a jump; ZERO for any other node."""
    if g.op[node] is not Op.CALL or FUNCTIONS[g.data[node]].smooth:
        return ZERO
    a, *b = g.args[node]
    place = FUNCTIONS[g.data[node]].kinked.place
    return g.call(place, a) if place else g.subtract(a, *b) if b else a


def protected(g: Graph, branch: Node, chosen: Node) -> Node:
    """Returns a branch of an `if` in which roots have max(0, u) in place of an argument u that is
    positive wherever `chosen` is 1: if(u > 0, sqrt(u), 0). A step may go a little beyond the
    boundary u = 0 with the branch that it began with, and sqrt(u) is undefined there."""
    new: dict[Node, Node] = {}
    for n in reachable(g, [branch], VARIABLE):
        if _is_root(g, n):
            (u, *others) = g.args[n]
            if _excludes(g, chosen, u):
                new[n] = rebuilt(g, n, [g.call("max", ZERO, u), *others])
    return substituted(g, [branch], new)[0] if new else branch


def _excludes(g: Graph, chosen: Node, u: Node) -> bool:
    """Whether a condition is 0 wherever u is negative."""
    surfaces = Surfaces(g.copy())
    surface, sign = surfaces(u)
    beyond = {}
    for call in reachable(g, [chosen], VARIABLE):
        own, side = surfaces.of_call(call)
        if side and own == surface and g.data[call] == "step":
            beyond[call] = ONE if sign * side < 0 else ZERO
    return bool(beyond) and substituted(g, [chosen], beyond) == [ZERO]


def _is_root(g: Graph, node: Node) -> bool:
    if g.op[node] is Op.POWER:
        return g.data[node].denominator != 1 and g.data[node] > 0
    return g.op[node] is Op.CALL and g.data[node] in ("sqrt", "pow")
