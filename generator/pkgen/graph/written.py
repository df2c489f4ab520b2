"""Compiles nodes to one Python function that computes in any domain with +, * and the functions of
the language, such as balls and power series (analysis/enclose) or the expressions of another Python
package (analysis/chart)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any

from ..functions import FUNCTIONS
from .differentiate import reachable
from .graph import Graph, Kind, Node, Op, Symbol

MOST_PRODUCTS = 8


class Floats:
    """The default domain, floating point numbers. A domain has the functions that the field
    `enclosed` of functions/row.py calls, and `number` and `pi` for constants."""

    sin, cos, exp, log, sqrt = math.sin, math.cos, math.exp, math.log, math.sqrt
    asin, acos, atan, atan2, pi = math.asin, math.acos, math.atan, math.atan2, math.pi
    min, max, abs, number = min, max, abs, float
    step, sign = (staticmethod(FUNCTIONS[name].real) for name in ("step", "sign"))


class Written:
    """A compiled function (domain, values of symbols) -> values of the nodes."""

    def __init__(
        self, g: Graph, nodes: Iterable[Node], constants: Mapping[Symbol, Any], domain: Any = Floats
    ):
        """Compiles the nodes. `constants` holds the values of the parameters in `domain`.
        Expressions of parameters alone are evaluated once, here."""
        self.nodes = list(nodes)
        used: dict[str, object] = {}
        lines: list[str] = []
        how = "enclosed", "e, ", _power
        for node in reachable(g, self.nodes):
            args, data = g.args[node], g.data[node]
            if not g.is_constant(node):
                lines.append(f"  x{node} = {text_of(g, node, [used], *how)}")
            elif g.op[node] is Op.NUMBER:
                used[f"x{node}"] = domain.number(data)
            elif g.op[node] is Op.SYMBOL:
                used[f"x{node}"] = domain.pi if data.kind is Kind.PI else constants[data]
            else:
                scope = used | {f"x{a}": used[f"x{a}"] for a in args} | {"e": domain}
                used[f"x{node}"] = eval(text_of(g, node, [used, scope], *how), scope)
        results = ", ".join(f"x{node}" for node in self.nodes)
        body = "\n".join([*lines, f"  return [{results}]"])
        exec(f"def evaluated(e, values):\n{body}", used)
        self.called: Callable[[Any, Mapping[Symbol, Any]], list[Any]] = used["evaluated"]

    def __call__(self, domain: Any, values: Mapping[Symbol, Any]) -> list[Any]:
        return self.called(domain, values)


def text_of(
    g: Graph,
    node: Node,
    scopes: Iterable[dict[str, object]],
    function: str,
    before: str,
    power: Callable[[str, Fraction], str],
) -> str:
    """Returns the Python expression of a node that is not a number. The variables for its arguments
    are named x1, x2, ... after the numbers of the nodes. The expression also names objects, which
    are added to each dictionary in `scopes`: for a symbol the symbol, for a call the attribute
    `function` of the row in the table of functions. `before` is text in front of the arguments of a
    call. The function `power` returns the text of a power."""
    op, args, data = g.op[node], [f"x{a}" for a in g.args[node]], g.data[node]
    if op is Op.ADD:
        return " + ".join(args)
    if op is Op.MULTIPLY:
        return " * ".join(args)
    if op is Op.POWER:
        return power(args[0], data)
    symbol = op is Op.SYMBOL
    name = f"s{node}" if symbol else f"f_{data}"
    for each in scopes:
        each[name] = data if symbol else getattr(FUNCTIONS[data], function)
    return f"values[{name}]" if symbol else f"{name}({before}{', '.join(args)})"


def _power(base: str, exponent: Fraction) -> str:
    """Returns the text of a power. Powers with integer or half-integer exponents are written as
    products, divisions and square roots, since the power function of the library Arb is undefined
    for a ball that contains 0."""
    whole, twice = exponent.denominator == 1, exponent.denominator == 2
    if not (whole or twice):
        return f"e.exp(e.log({base}) * {exponent.numerator} / {exponent.denominator})"
    text = base if whole else f"e.sqrt({base})"
    power = abs(exponent.numerator)
    if power > 1:
        few = whole and power <= MOST_PRODUCTS
        text = " * ".join([base] * power) if few else f"({text}) ** {power}"
    return text if exponent > 0 else f"1 / ({text})"
