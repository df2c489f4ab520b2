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
from .graph import ONE, VARIABLE, ZERO, Graph, Node, Op, Symbol
from .wording import wording

# What each of them is called where its side is given too, as a first argument.
SIDED = {name: f"side_{name}" for name in ("step", "sign", "abs", "min", "max")}


def switches_of(
    g: Graph, outputs: Iterable[Node], name: Callable[[Symbol], str]
) -> tuple[Switch, ...]:
    """Those of the equations that `outputs` are, each argument once: of x and -x the first.

    None where one stands in what has no value everywhere, max(0, x)^(3/2) say: a step that is held
    on one side goes a little beyond the zero, where that is no number. Then all stay as they are.
    """
    found: dict[Node, None] = {}
    bounded = [a for n in reachable(g, outputs, VARIABLE) if _bounded(g, n) for a in g.args[n]]
    if any(_argument(g, n)[0] != ZERO for n in reachable(g, bounded, VARIABLE)):
        return ()
    for node in reachable(g, outputs, VARIABLE):
        argument, _ = _argument(g, node)
        if g.depends[argument] & VARIABLE and g.negate(argument) not in found:
            found[argument] = None
    return tuple(Switch(Quantity(wording(g, x, name), "", ""), x) for x in found)


def sides(g: Graph, switches: Iterable[Switch]) -> dict[Node, tuple[int, int]]:
    """Of each call that a switch decides: which one, and 1 or -1 as its own argument has the sign
    of the switch's or the other."""
    places: dict[Node, tuple[int, int]] = {}
    for k, switch in enumerate(switches):
        places[switch.node] = (k, 1)
        places[g.negate(switch.node)] = (k, -1)
    found = {}
    for node in range(len(g) if places else 0):  # all that there are: arguments are made on the way
        argument, sign = _argument(g, node)
        if argument in places:
            k, side = places[argument]
            found[node] = k, sign * side
    return found


def _bounded(g: Graph, node: Node) -> bool:
    """Whether it has a value for some arguments alone."""
    if g.op[node] is Op.POWER:
        return g.data[node].denominator != 1
    return g.op[node] is Op.CALL and g.data[node] in ("sqrt", "log", "asin", "acos", "pow")


def _argument(g: Graph, node: Node) -> tuple[Node, int]:
    """What decides a call, without a number in front, of which the sign alone counts; 0 of what is
    smooth."""
    if g.op[node] is not Op.CALL or g.data[node] not in SIDED:
        return ZERO, 1
    a, *b = g.args[node]
    argument = g.subtract(a, *b) if b else a
    scale, rest = g.split(argument)
    if g.op[scale] is not Op.NUMBER or rest == ONE:
        return argument, 1
    return rest, 1 if g.data[scale] > 0 else -1
