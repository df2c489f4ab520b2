"""Converts nodes of the graph to SymPy expressions, node by node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

from ...equations import Equations
from ...functions import FUNCTIONS
from ...graph.differentiate import swept
from ...graph.graph import Graph, Kind, Node, Op, Symbol
from ..naming import naming

if TYPE_CHECKING:
    import sympy

# The largest number of operations of an expression in which products of sines and cosines are
# combined to sines and cosines of sums.
COMBINED = 80
# The largest number of coordinates of a model in which products of sines and cosines are combined:
# with more coordinates, this would take minutes for all entries of M.
COMBINED_COORDINATES = 8


def text(equations: Equations, node: Node, limit: int) -> str:
    """Returns the expression as text. If it has more than `limit` operations, the text is their
    number."""
    found = expression(equations, node, limit)
    if isinstance(found, int):
        return f"({found} operations)"
    return plain(found)


def plain(expr: sympy.Expr) -> str:
    """Returns the text of an expression in the syntax of models."""
    return _printer().doprint(expr).replace("**", "^")


@cache
def _printer():
    from sympy.printing.str import StrPrinter

    class Printer(StrPrinter):
        def _print_Abs(self, expr) -> str:
            return f"abs({self._print(expr.args[0])})"

        def _print_Heaviside(self, expr) -> str:
            return f"step({self._print(expr.args[0])})"

        def _print_Exp1(self, expr) -> str:
            return "exp(1)"

        def _print_Max(self, expr) -> str:
            return self._nested("max", expr.args)

        def _print_Min(self, expr) -> str:
            return self._nested("min", expr.args)

        def _nested(self, name: str, args) -> str:
            """Returns nested calls with two arguments each, such as max(a, max(b, c)): in SymPy,
            min and max have any number of arguments, in the language two."""
            first, *rest = args
            other = self._nested(name, rest) if len(rest) > 1 else self._print(rest[0])
            return f"{name}({self._print(first)}, {other})"

    return Printer()


def expression(equations: Equations, node: Node, limit: int) -> sympy.Expr | int:
    """Returns the expression as a SymPy object, or its number of operations if this exceeds
    `limit`."""
    import sympy as sp
    from sympy.simplify.fu import TR10i

    size = written_size(equations.graph, node)
    if size > limit:
        return size
    name = naming(equations)
    (expr,) = to_sympy(equations.graph, [node], lambda s: sp.Symbol(name(s)))
    few = size <= COMBINED and len(equations.coordinates) <= COMBINED_COORDINATES
    if few and expr.has(sp.sin, sp.cos):  # TR10i takes quadratic time: it tries all pairs of terms
        expr = min(expr, TR10i(expr), TR10i(sp.expand(expr)), key=sp.count_ops)
    return expr


def written_size(g: Graph, node: Node) -> int:
    """Returns the number of operations of an expression if it is written out in full, without
    common subexpressions."""
    return swept(g, [node], lambda _, sizes: sum(sizes) + (len(sizes) > 0))[0]


def to_sympy(
    g: Graph,
    nodes: Iterable[Node],
    symbol: Callable[[Symbol], sympy.Expr],
    shortened: Callable[[sympy.Expr], sympy.Expr] | None = None,
    given: Mapping[Node, sympy.Expr] | None = None,
) -> list[sympy.Expr]:
    """Returns the nodes as SymPy expressions. `symbol` converts a symbol. `shortened` is applied to
    the expression of each node to simplify it. `given` maps nodes to expressions by which they are
    replaced.

    The function `reciprocal`, which is 0 at 0, becomes 1/x.
    """
    import sympy as sp

    def made(node: Node, args: list[sp.Expr]) -> sp.Expr:
        op, data = g.op[node], g.data[node]
        if op is Op.NUMBER:
            return _rational(data)
        if op is Op.SYMBOL:
            return sp.pi if data.kind is Kind.PI else symbol(data)
        if op in (Op.ADD, Op.MULTIPLY):
            return (sp.Add if op is Op.ADD else sp.Mul)(*args)
        if op is Op.POWER:
            return sp.Pow(args[0], _rational(data))
        row = FUNCTIONS[data]
        if callable(row.sympy):
            return row.sympy(sp, *args)
        return (getattr(sp, row.sympy or data, None) or sp.Function(data))(*args)

    def _rational(value: Fraction) -> sp.Rational:
        return sp.Rational(value.numerator, value.denominator)

    def value(node: Node, args: list[sp.Expr]) -> sp.Expr:
        if given and node in given:
            return given[node]
        return shortened(made(node, args)) if shortened else made(node, args)

    return swept(g, nodes, value)
