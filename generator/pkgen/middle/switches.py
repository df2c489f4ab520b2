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

from ..equations import Quantity, Switch
from .differentiate import reachable
from .graph import MINUS_ONE, ONE, VARIABLE, Graph, Node, Op, Symbol
from .wording import wording

# What each of them is called where its side is given too, as a first argument.
SIDED = {name: f"side_{name}" for name in ("step", "sign", "abs", "min", "max")}


def switches_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Those of the equations that `outputs` are, each argument once: of x and -x the first."""
    found: dict[Node, None] = {}
    for node in reachable(g, outputs, VARIABLE):
        argument = _argument(g, node)
        if argument is not None and g.depends[argument] & VARIABLE:
            argument = _bare(g, argument)
            if g.negate(argument) not in found:
                found[argument] = None
    return tuple(Switch(Quantity(wording(g, x, name), "", ""), x) for x in found)


def sides(g: Graph, switches: Iterable[Switch]) -> dict[Node, tuple[int, int]]:
    """Of each call that a switch decides: which one, and 1 or -1 as its own argument has the sign
    of the switch's or the other."""
    places: dict[Node, tuple[int, int]] = {}
    for k, switch in enumerate(switches):
        places[switch.node] = (k, 1)
        places[g.negate(switch.node)] = (k, -1)
    if not places:
        return {}
    found = {}
    for node in range(len(g)):  # all that there are: arguments are made on the way
        argument = _argument(g, node)
        if argument is not None and _bare(g, argument) in places:
            found[node] = places[_bare(g, argument)]
    return found


def _argument(g: Graph, node: Node) -> Node | None:
    """What it has the sign of, or None for what is smooth."""
    if g.op[node] is not Op.CALL or g.data[node] not in SIDED:
        return None
    a, *b = g.args[node]
    return g.subtract(a, *b) if b else a


def _bare(g: Graph, argument: Node) -> Node:
    """Without a number in front, of which only the sign counts."""
    scale, rest = g.split(argument)
    if g.op[scale] is not Op.NUMBER or scale == ONE:
        return argument
    return rest if g.data[scale] > 0 else g.multiply(MINUS_ONE, rest)
