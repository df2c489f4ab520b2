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
from .graph import BIT, VARIABLE, Graph, Kind, Node, Op, Symbol

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
        self,
        g: Graph,
        nodes: Iterable[Node],
        constants: Mapping[Symbol, Any] | None,
        domain: Any = Floats,
        field: str = "enclosed",
    ):
        """Compiles the nodes. `constants` holds the values of the parameters in `domain`.
        Expressions of parameters alone are evaluated once, here. If it is None, `values` has the
        parameters too. `field` is the field of functions/row.py with the functions: "enclosed", or
        "real" for floating point numbers."""
        self.nodes, self.field = list(nodes), field
        varies = VARIABLE if constants is not None else ~BIT[Kind.PI]
        used: dict[str, object] = {"pow": math.pow}
        lines: list[str] = []
        for node in reachable(g, self.nodes):
            args, data = g.args[node], g.data[node]
            if g.depends[node] & varies:
                lines.append(f"  x{node} = {self._text(g, node, [used])}")
            elif g.op[node] is Op.NUMBER:
                used[f"x{node}"] = domain.number(data)
            elif g.op[node] is Op.SYMBOL:
                used[f"x{node}"] = domain.pi if data.kind is Kind.PI else constants[data]
            else:
                scope = used | {f"x{a}": used[f"x{a}"] for a in args} | {"e": domain}
                used[f"x{node}"] = eval(self._text(g, node, [used, scope]), scope)
        results = ", ".join(f"x{node}" for node in self.nodes)
        body = "\n".join([*lines, f"  return [{results}]"])
        exec(f"def evaluated(e, values):\n{body}", used)
        self.called: Callable[[Any, Mapping[Symbol, Any]], list[Any]] = used["evaluated"]

    def __call__(self, domain: Any, values: Mapping[Symbol, Any]) -> list[Any]:
        return self.called(domain, values)

    def _text(self, g: Graph, node: Node, scopes: Iterable[dict[str, object]]) -> str:
        """Returns the Python expression of a node that is not a number. The variables for its
        arguments are named x1, x2, ... after the numbers of the nodes. The expression also names
        objects, which are added to each dictionary in `scopes`: for a symbol the symbol, for a call
        the function."""
        op, args, data = g.op[node], [f"x{a}" for a in g.args[node]], g.data[node]
        enclosed = self.field == "enclosed"
        if op is Op.ADD:
            return " + ".join(args)
        if op is Op.MULTIPLY:
            return " * ".join(args)
        if op is Op.POWER:
            return _power(args[0], data) if enclosed else f"pow({args[0]}, {float(data)!r})"
        symbol = op is Op.SYMBOL
        name = f"s{node}" if symbol else f"f_{data}"
        for each in scopes:
            each[name] = data if symbol else getattr(FUNCTIONS[data], self.field)
        return f"values[{name}]" if symbol else f"{name}({', '.join(['e'] * enclosed + args)})"


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
