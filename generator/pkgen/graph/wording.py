"""An expression as a person would write it in a .lag file: "sin(theta)", "l0 + s", "x^2 + y^2"."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from .graph import Graph, Kind, Node, Op, Symbol

LONGEST = 60  # characters; of what is longer, the beginning
_SUM, _NEGATED, _PRODUCT, _POWER, _ATOM = range(5)  # how tightly a text holds together


def wording(g: Graph, node: Node, name: Callable[[Symbol], str]) -> str:
    """The text, cut where it grows too long; `name` says what symbols are called."""
    text, _ = _worded(g, node, name, 0, {})
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


Worded = tuple[str, int]


def _worded(g: Graph, node: Node, name: Callable[[Symbol], str], depth: int, known: dict) -> Worded:
    """Of what is shared once for each depth, and no more text than can be seen."""
    if (node, depth) not in known:
        text, tightness = _written(g, node, name, depth, known)
        known[node, depth] = text[: 2 * LONGEST], tightness
    return known[node, depth]


def _written(
    g: Graph, node: Node, name: Callable[[Symbol], str], depth: int, known: dict
) -> Worded:
    op, args, data = g.op[node], g.args[node], g.data[node]
    if depth > LONGEST:
        return "...", _ATOM
    if op is Op.NUMBER:
        return _number(data)
    if op is Op.SYMBOL:
        return ("pi" if data.kind is Kind.PI else name(data)), _ATOM
    parts = [_worded(g, a, name, depth + 1, known) for a in args]
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
    return f"{data}({', '.join(text for text, _ in parts)})", _ATOM


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
