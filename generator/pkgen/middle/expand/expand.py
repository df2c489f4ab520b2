"""Converts a model's expressions to nodes of the graph."""

from __future__ import annotations

from ... import limits
from ...graph.graph import TooLarge
from ...graph.magnitudes import Magnitudes
from ...model import Model
from ...tree import Expr
from ..quantities import error
from .names import Loop, Names, Value
from .terms import EXPAND


class Expander(Names):
    """Converts the expressions of one model to nodes. EXPAND has a function for each class of
    expressions."""

    def __init__(self, model: Model, orders: tuple[int, ...]):
        super().__init__(model, orders)
        self._visits = 0
        self._magnitudes = Magnitudes(self.graph)

    def value(self, expr: Expr, loop: Loop) -> Value:
        self._visits += 1
        if self._visits > limits.VISITS:
            raise TooLarge
        value = EXPAND[type(expr)](self, expr, loop)
        for node in value if isinstance(value, tuple) else (value,):
            wrong = self._magnitudes.wrong(node)
            if wrong:
                at = ", ".join(f"{k} = {v}" for k, v in loop.items() if k not in self.sizes)
                raise error(self.model, f"{wrong} at {at}" if at else wrong, expr.span)
        return value
