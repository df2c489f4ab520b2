"""Finds expressions that jump at the branch cut of an angle atan2(y, x), from pi to -pi.

If the energy jumps, the cut is a singularity, given by the zeros of the cosine of half the angle.
If only forces jump, y is a switch (derive/switches.py), so that steps of the integrator end at its
zeros.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from ...equations import Equations
from ...graph.differentiate import reachable
from ...graph.graph import VARIABLE, ZERO, Graph, Node, Op
from ...graph.normal import Normal
from ...graph.ranges import Ranges
from ...graph.substitute import substituted
from .squares import bounds_of

# A rational number that is used instead of pi: whether terms cancel does not depend on its value.
PI = Fraction(355, 113)


def jumping_angles(g: Graph, nodes: Sequence[Node], ranges: Ranges) -> Iterator[Node]:
    """Yields the angles atan2(y, x) at whose branch cut any of the nodes may jump. There is no jump
    in sines and cosines of integer multiples of the angle, in even functions of the angle, in nodes
    that vanish for y = 0, or if x is positive."""
    for angle in reachable(g, nodes, VARIABLE):
        cut = is_call(g, angle, "atan2") and not ranges(g.args[angle][1]).positive
        if cut and any(_jumps(g, node, angle) for node in nodes):
            yield angle


def half_cosine(g: Graph, angle: Node) -> Node:
    return g.call("cos", g.multiply(g.number(Fraction(1, 2)), angle))


def switched(e: Equations, forces: Sequence[Node]) -> list[Node]:
    """Returns the argument y of each angle atan2(y, x) at whose branch cut forces jump, but not the
    energy."""
    g, ranges = e.graph, Ranges(e.graph, [bounds_of(e.graph, slot) for slot in e.parameters])
    ends = {*jumping_angles(g, [e.lagrangian], ranges)}
    return [g.args[x][0] for x in jumping_angles(g, forces, ranges) if x not in ends]


def _jumps(g: Graph, node: Node, angle: Node) -> bool:
    copy = g.copy()
    same = {n: n for n in reachable(g, [node], VARIABLE) if _turns(g, n, angle)}
    y, _ = g.args[angle]
    at_cut = {y: ZERO, g.negate(y): ZERO} if g.depends[y] & VARIABLE else {}
    try:
        above, below = (
            substituted(copy, [node], same | at_cut | {angle: copy.number(side)})[0]
            for side in (PI, -PI)
        )
        jump = copy.subtract(above, below)
        return not (jump == ZERO or Normal(copy)(jump) == {})
    except ZeroDivisionError:
        return True


def is_call(g: Graph, node: Node, *functions: str) -> bool:
    return g.op[node] is Op.CALL and g.data[node] in functions


def _turns(g: Graph, node: Node, angle: Node) -> bool:
    """Whether a node is a sine or cosine of an integer multiple of the angle, plus terms without
    the angle."""
    if not is_call(g, node, "sin", "cos"):
        return False
    inside = g.args[node][0]
    terms = g.args[inside] if g.op[inside] is Op.ADD else (inside,)
    split = [g.split(term) for term in terms]
    scales = [g.value(scale) for scale, rest in split if rest == angle]
    others = [rest for _, rest in split if rest != angle]
    whole = all(x is not None and x.denominator == 1 for x in scales)
    return bool(scales) and whole and angle not in reachable(g, others)
