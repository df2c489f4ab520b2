"""Finds constants in the graph that overflow or underflow a double.

The checker has already tested the constants in the model's text. This module tests constants that
exist only in the graph: those computed from loop variables, and products of constants.
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
    """Tests constants of one graph. Caches their values, computed in doubles like in C."""

    def __init__(self, g: Graph):
        self.graph = g
        self._values: dict[Node, float] = {}
        self._wrong: dict[Node, str] = {ONE: ""}

    def wrong(self, node: Node) -> str:
        """Returns the error message for the constant factor of a node (its scale), or ""."""
        scale, _ = self.graph.split(node)
        found = self._wrong.get(scale)
        if found is None:
            found = self._wrong[scale] = self._of_scale(scale)
        return found

    def _of_scale(self, scale: Node) -> str:
        g = self.graph
        if not g.depends[scale] & _PARAMETER:
            return self._of(scale)
        # In a * 1e200 * 1e200 with a parameter a, the product of the numbers is tested too.
        product = 1.0
        for base, exponent in g.factors(scale):
            if not g.depends[base] & _PARAMETER:
                wrong = self._of(base)
                if wrong:
                    return wrong
                product *= math.pow(self._values[base], float(exponent))
        return limits.lost(1, product) if math.isfinite(product) else LARGE

    def _of(self, constant: Node) -> str:
        """Returns the error message for a constant without parameters, or ""."""
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
    """Whether a value of 0 is exact rather than an underflow. It may be exact for a sum, a call, or
    an operation with an argument 0."""
    return node == ZERO or g.op[node] in (Op.ADD, Op.CALL) or not all(args)
