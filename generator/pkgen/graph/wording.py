"""Writes an expression in the syntax of .lag files, such as "sin(theta)" or "x^2 + y^2"."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

from ..functions import FUNCTIONS
from .differentiate import swept
from .graph import Graph, Kind, Node, Op, Symbol

# The largest number of characters of a text; longer texts are truncated.
LONGEST = 60
# The precedence of the outermost operator of a text.
_SUM, _NEGATED, _PRODUCT, _POWER, _ATOM = range(5)
Worded = tuple[str, int]


def wording(g: Graph, node: Node, name: Callable[[Symbol], str]) -> str:
    """Returns the text of a node, truncated to LONGEST characters; `name` returns the name of a
    symbol."""
    return wordings(g, [node], name)[0]


def wordings(g: Graph, nodes: Iterable[Node], name: Callable[[Symbol], str]) -> list[str]:
    """Returns the texts of several nodes, as wording() does."""

    def written(part: Node, parts: list[Worded]) -> Worded:
        text, tightness = _joined(g, part, parts, name)
        return text[: 2 * LONGEST], tightness  # the result is truncated further

    texts = [text for text, _ in swept(g, nodes, written)]
    return [x if len(x) <= LONGEST else x[: LONGEST - 3] + "..." for x in texts]


def _joined(g: Graph, node: Node, parts: list[Worded], name: Callable[[Symbol], str]) -> Worded:
    op, data = g.op[node], g.data[node]
    if op is Op.NUMBER:
        return _number(data)
    if op is Op.SYMBOL:
        return ("pi" if data.kind is Kind.PI else name(data)), _ATOM
    if op is Op.ADD:
        (first, _), (second, tightness) = sorted(parts, key=lambda part: part[1] == _NEGATED)
        sign, second = ("-", second[1:]) if tightness == _NEGATED else ("+", second)
        return f"{first} {sign} {second}", _SUM
    if op is Op.MULTIPLY:
        (first, tightness), second = parts
        if first == "-1":
            return "-" + _held(second, _PRODUCT), _NEGATED
        if tightness == _NEGATED:
            return f"{first}*{_held(second, _PRODUCT)}", _NEGATED
        return f"{_held(parts[0], _PRODUCT)}*{_held(second, _PRODUCT)}", _PRODUCT
    if op is Op.POWER:
        if data < 0:
            inner = parts[0] if data == -1 else _raised(parts[0], -data)
            return f"1/{_held(inner, _POWER)}", _PRODUCT
        return _raised(parts[0], data)
    if data == "piece":
        return parts[0]
    row = FUNCTIONS[data]
    given = parts[: len(row.orders)] if row.orders else parts
    primes = "'" * sum(row.orders) if len(row.orders) < 2 else "_".join(("", *map(str, row.orders)))
    return f"{row.table or data}{primes}({', '.join(text for text, _ in given)})", _ATOM


def _held(part: tuple[str, int], needed: int) -> str:
    text, tightness = part
    return text if tightness >= needed else f"({text})"


def _raised(base: tuple[str, int], exponent: Fraction) -> tuple[str, int]:
    power, tightness = _number(exponent)
    return f"{_held(base, _ATOM)}^{_held((power, tightness), _ATOM)}", _POWER


def _number(value: Fraction) -> tuple[str, int]:
    if value.denominator == 1:
        return str(value), _ATOM if value >= 0 else _NEGATED
    return f"{value.numerator}/{value.denominator}", _PRODUCT if value >= 0 else _NEGATED
