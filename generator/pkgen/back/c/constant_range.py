"""Finds constants of the equations that are out of the range of double.

The checker and `graph/magnitudes.py` check the constants in a model's text. Constants that
arise from these by differentiation or in a canonical form, such as `2*1e308`, are known only when C
is written.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from decimal import Context, Decimal
from fractions import Fraction
from sys import float_info

from ...graph.evaluate import value_of
from ...graph.graph import Kind, Node, Op
from ...graph.magnitudes import may_vanish
from ...model import Model
from ...source import Diagnostic, ModelError
from ...tree import Number

_FLOAT = 2.0**-126, 2.0**128  # The smallest normal number and the upper bound of C's float.


class Beyond(Exception):
    """A constant is too large or too small for a double. The message contains the constant."""

    def placed(self, model: Model) -> ModelError:
        """Returns the error as a ModelError at a position in the model: that of the number farthest
        from 1, since it is the likely cause. Values of parameters are no candidates, since no
        constant contains them."""
        numbers = [n for n in _numbers(replace(model, parameters=())) if n.value]
        far = max(numbers, key=lambda n: (abs(_log(n.value)), -n.span.start), default=model)
        help = "it comes from this number and what it is multiplied with: choose other units"
        message = f"the equations need {self}"
        return ModelError(model.source, [Diagnostic(message, far.span, help)])


class Constants:
    """Checks the range of the constants in a C program while it is written. `work` is a Workspace
    (rewrite.py)."""

    def __init__(self, work) -> None:
        self._work = work
        self._values: dict[Node, float | None] = {}  # None for nodes with parameters
        self.float_too = True  # whether all constants fit in C's float

    def see(self, node: Node) -> None:
        """Raises Beyond if a constant node is out of the range of double."""
        work = self._work
        if not work.fixed[node] or node in self._values:
            return
        for a in work.args[node]:
            self.see(a)
        args = [self._values[a] for a in work.args[node]]
        symbol = work.op[node] is Op.SYMBOL and work.data[node].kind is not Kind.PI
        known = not symbol and None not in args
        value = self._values[node] = value_of(work, node, args, {}) if known else None
        if value is None:
            return
        if not math.isfinite(value):
            raise Beyond(f"a constant that is too large for a double{self._shown(node)}")
        if abs(value) < float_info.min and not may_vanish(work, node, args):
            raise Beyond(f"a constant that is too small for a double{self._shown(node)}")
        if value and not _FLOAT[0] <= abs(value) < _FLOAT[1]:
            self.float_too = False

    def _shown(self, node: Node) -> str:
        value = self._work.data[node]
        return f": {_short(value)}" if self._work.op[node] is Op.NUMBER else ""


def extreme(graph) -> bool:
    """Returns whether a number in the graph is so large or small that a constant computed from it
    may be out of the range of double."""
    return any(abs(_log(Fraction(*key))) > 90 for key in graph.tables()[Op.NUMBER] if key[0])


def _log(value: Fraction) -> float:
    """Returns log10 |value|, also for values out of the range of double."""
    return math.log10(abs(value.numerator)) - math.log10(value.denominator)


def _short(value: Fraction) -> str:
    context = Context(prec=4, Emax=10**6, Emin=-(10**6))
    return str(context.divide(Decimal(value.numerator), Decimal(value.denominator)).normalize())


def _numbers(part: object) -> Iterator[Number]:
    """Yields all number literals of a model, also nested ones."""
    if isinstance(part, Number):
        yield part
    elif isinstance(part, tuple):
        for inner in part:
            yield from _numbers(inner)
    elif is_dataclass(part):
        for field in fields(part):
            yield from _numbers(getattr(part, field.name))
