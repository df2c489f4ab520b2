"""Constants that the equations need and no double can hold.

The checker and `graph/magnitudes.py` have seen those that are written down. What a derivative or
a canonical form makes of them (`2*1e308`) exists only when C is written, so it is found there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from decimal import Context, Decimal
from fractions import Fraction
from sys import float_info

from ...graph.evaluate import value_of
from ...graph.graph import VARIABLE, Graph, Kind, Node, Op
from ...graph.magnitudes import may_vanish
from ...model import Model
from ...source import Diagnostic, ModelError
from ...tree import Number

_FLOAT = 2.0**-126, 2.0**128  # of PK_FLOAT: a loss of digits begins, the largest are beyond


class Beyond(Exception):
    """The text says of which constant, and what is wrong with it."""

    def placed(self, model: Model) -> ModelError:
        """At the number of the model that is farthest from 1, which it comes from most likely. What
        a parameter is stands in no expression."""
        numbers = [n for n in _numbers(replace(model, parameters=())) if n.value]
        far = max(numbers, key=lambda n: (abs(_log(n.value)), -n.span.start), default=model)
        help = "it comes from this number and what it is multiplied with: choose other units"
        message = f"the equations need {self}"
        return ModelError(model.source, [Diagnostic(message, far.span, help)])


class Tables:
    """What a graph has in C: its nodes, and whether one depends on parameters alone."""

    def __init__(self, graph: Graph) -> None:
        self.op = list(graph.op)
        self.args = list(graph.args)
        self.data = list(graph.data)
        self.fixed = [not mask & VARIABLE for mask in graph.depends]


class Constants:
    """Looks at the constants of a program as they are written."""

    def __init__(self, work: Tables) -> None:
        self._work = work
        self._values: dict[Node, float | None] = {}  # None: it depends on a parameter
        self.float_too = True  # whether those seen so far are in the range of float

    def see(self, node: Node) -> None:
        """Raises Beyond where a double cannot hold a node whose arguments were seen before."""
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
    """Whether some number of a graph is so far from 1 that one made of it may be beyond."""
    return any(abs(_log(Fraction(*key))) > 90 for key in graph.tables()[Op.NUMBER] if key[0])


def _log(value: Fraction) -> float:
    """log10 |value|, of any size."""
    return math.log10(abs(value.numerator)) - math.log10(value.denominator)


def _short(value: Fraction) -> str:
    context = Context(prec=4, Emax=10**6, Emin=-(10**6))
    return str(context.divide(Decimal(value.numerator), Decimal(value.denominator)).normalize())


def _numbers(part: object) -> Iterator[Number]:
    """The literals anywhere in a model."""
    if isinstance(part, Number):
        yield part
    elif isinstance(part, tuple):
        for inner in part:
            yield from _numbers(inner)
    elif is_dataclass(part):
        for field in fields(part):
            yield from _numbers(getattr(part, field.name))
