"""Constants that no double can hold, found as the expressions are entered into the graph.

The checker has seen the constants that stand in the text; what a sum or a family makes of its
loop variable, and a product of constants that each are fine, exist only now.
"""

from __future__ import annotations

import math

from .. import limits
from .differentiate import reachable
from .evaluate import value_of
from .graph import BIT, ONE, ZERO, Graph, Kind, Node, Op

_PARAMETER = BIT[Kind.PARAMETER]
LARGE = "this constant is too large for a double"
NO_VALUE = "this constant has no real value"


class Magnitudes:
    """Remembers the floating-point value of each constant, which C will compute as well."""

    def __init__(self, g: Graph):
        self.graph = g
        self._values: dict[Node, float] = {}
        self._wrong: dict[Node, str] = {ONE: ""}

    def wrong(self, node: Node) -> str:
        """What is wrong with the constant in front of a node (its scale), or ""."""
        scale, _ = self.graph.split(node)
        found = self._wrong.get(scale)
        if found is None:
            found = self._wrong[scale] = self._of_scale(scale)
        return found

    def _of_scale(self, scale: Node) -> str:
        g = self.graph
        if not g.depends[scale] & _PARAMETER:
            return self._of(scale)
        # a * 1e200 * 1e200: a parameter does not hide what it is multiplied by.
        product = 1.0
        for base, exponent in g.factors(scale):
            if not g.depends[base] & _PARAMETER:
                wrong = self._of(base)
                if wrong:
                    return wrong
                product *= math.pow(self._values[base], float(exponent))
        return limits.lost(1, product) if math.isfinite(product) else LARGE

    def _of(self, constant: Node) -> str:
        """A constant that depends on nothing, its parts first."""
        g, values = self.graph, self._values
        for node in reachable(g, [constant]):
            if node not in values:
                values[node] = value_of(g, node, [values[a] for a in g.args[node]], {})
        value = values[constant]
        if math.isnan(value):
            return NO_VALUE
        if math.isinf(value):
            return LARGE
        args = [values[a] for a in g.args[constant]]
        return limits.lost(not may_vanish(g, constant, args), value)


def may_vanish(g: Graph, node: Node, args: list[float]) -> bool:
    """A sum or a sine may be small without anything lost; numbers and products may not."""
    return node == ZERO or g.op[node] in (Op.ADD, Op.CALL) or not all(args)
