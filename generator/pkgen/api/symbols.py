"""A model's Lagrangian and equations as SymPy objects, and as LaTeX for a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from ..compiler import Compilation
from ..equations import Equations
from ..graph.graph import Kind, Node, Symbol
from ..middle.analyze.sympy_bridge import expression
from .errors import UsageError

if TYPE_CHECKING:
    import sympy


_LONGEST = 100_000  # largest number of operations of an expression written out in full


class Symbolic(NamedTuple):
    """The equations M a = f. Symbols are named as in the model: `theta1`, `theta1'`, `m1`."""

    L: sympy.Expr
    M: sympy.Matrix
    f: sympy.Matrix
    q: list[sympy.Symbol]
    v: list[sympy.Symbol]


class Typeset:
    """The equations of motion in LaTeX, one per coordinate; a notebook renders them."""

    def __init__(self, rows: list[str]):
        self.rows = rows

    @property
    def latex(self) -> str:
        return "\\begin{aligned}\n" + " \\\\\n".join(self.rows) + "\n\\end{aligned}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex}$"

    def __repr__(self) -> str:
        return self.latex


def symbolic(compilation: Compilation) -> Symbolic:
    """Returns the equations as SymPy objects. Raises UsageError for a model with constraints or
    rotations, without coordinates, or with an expression that is too long."""
    import sympy as sp

    e = compilation.equations
    assert isinstance(e, Equations)
    if e.constraints or e.attitudes or not e.own:
        raise UsageError(
            f"{compilation.model.name} has constraints, rotations or states alone: "
            "pkgen explain shows its equations"
        )

    def made(nodes: Iterable[Node]) -> list[sp.Expr]:
        found = [expression(e, node, _LONGEST) for node in nodes]
        if size := max((x for x in found if isinstance(x, int)), default=0):
            raise UsageError(
                f"{compilation.model.name}: an expression has {size:,} operations, and SymPy gets "
                f"{_LONGEST:,} at most: pkgen explain shows what is shorter"
            )
        chosen = lambda c, a, b: sp.Piecewise((a, c > 0), (b, True))  # noqa: E731
        return [x.replace(sp.Function("if"), chosen) for x in found]

    def numbered(kind: str) -> list[Node]:
        return [e.graph.symbol(Symbol(kind, i)) for i in range(e.own)]

    (L,) = made([e.lagrangian])
    M = sp.Matrix([made(row[: e.own]) for row in e.mass[: e.own]])
    q, v = (made(numbered(kind)) for kind in (Kind.COORDINATE, Kind.RATE))
    return Symbolic(L, M, sp.Matrix(made(e.force[: e.own])), q, v)


def typeset(found: Symbolic) -> Typeset:
    import sympy as sp

    def dotted(symbol: sp.Symbol, dot: str) -> str:
        stem, _, index = sp.latex(symbol).partition("_")
        return f"\\{dot}{{{stem}}}" + (f"_{index}" if index else "")

    names = {v: dotted(q, "dot") for q, v in zip(found.q, found.v, strict=True)}
    rows = []
    for i in range(len(found.q)):
        terms = []
        for entry, q in zip(found.M.row(i), found.q, strict=True):
            if entry == 0:
                continue
            text = sp.latex(entry, symbol_names=names)
            text = f"\\left({text}\\right)" if isinstance(entry, sp.Add) else text
            terms.append(f"{text}\\,{dotted(q, 'ddot')}" if entry != 1 else dotted(q, "ddot"))
        right = sp.latex(found.f[i], symbol_names=names)
        rows.append(f"{' + '.join(terms) or '0'} &= {right}")
    return Typeset(rows)
