"""The shortest of some forms of an expression, as it is shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from . import mathml

if TYPE_CHECKING:
    import sympy

TRIED = 120  # operations up to which other forms are tried
TERMS = 40  # of an expanded form


def shortest(
    expr: sympy.Expr, constants: frozenset[str], typeset: Callable[[sympy.Expr], str]
) -> sympy.Expr:
    """As it is; with products of sines as sines of sums; or expanded, with like terms gathered and
    what stands in front of each a product."""
    import sympy as sp
    from sympy.simplify.fu import TR10i

    if expr.is_Atom or sp.count_ops(expr) > TRIED:
        return expr
    forms = [expr]
    flat = sp.expand(expr, power_base=False, power_exp=False, log=False, trig=False)
    if len(sp.Add.make_args(flat)) <= TERMS:
        if len(expr.atoms(sp.sin, sp.cos)) > 1:
            forms += [TR10i(expr)]
            flat = TR10i(flat)
        forms += [flat, _gathered(flat, constants)]
    return min(forms, key=lambda x: (_cost(typeset(x)), forms.index(x)))


def _cost(shown: str) -> float:
    """Letters, and for each bracket a little: they are harder to read."""
    return mathml.width(shown) + shown.count('fence="true"') / 2


def _gathered(flat: sympy.Expr, constants: frozenset[str]) -> sympy.Expr:
    import sympy as sp

    found: dict[sympy.Expr, list[sympy.Expr]] = {}
    for term in sp.Add.make_args(flat):
        variables, others = [], []
        for factor in sp.Mul.make_args(term):
            fixed = all(s.name in constants for s in factor.free_symbols)
            (others if fixed else variables).append(factor)
        found.setdefault(sp.Mul(*variables), []).append(sp.Mul(*others))
    return sp.Add(*(_product(sp.Add(*c)) * variables for variables, c in found.items()))


def _product(coefficient: sympy.Expr) -> sympy.Expr:
    import sympy as sp

    if not coefficient.is_Add:
        return coefficient
    try:
        return sp.factor(coefficient)
    except sp.PolynomialError:
        return sp.factor_terms(coefficient)
