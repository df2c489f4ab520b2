"""Chooses the shortest of several forms of an expression, measured after typesetting."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from . import mathml

if TYPE_CHECKING:
    import sympy

TRIED = 120  # Other forms are tried only for expressions with at most this many operations.
LONGER = 1.2  # The form with collected terms may be longer than the shortest form by this factor.
TERMS = 40  # Most terms of the expanded form.


def shortest(
    expr: sympy.Expr,
    constants: frozenset[str],
    typeset: Callable[[sympy.Expr], str],
    others: Iterable[sympy.Expr] = (),
) -> sympy.Expr:
    """Returns the shortest form: the expression itself, one of `others`, the expanded form, or
    products of sines written as sines of sums. The form with like terms collected, and their
    coefficients factored, is preferred even if it is a little longer."""
    import sympy as sp
    from sympy.simplify.fu import TR10i

    expr = expr.replace(_has_content, _content_outside)
    if expr.is_Atom or sp.count_ops(expr) > TRIED:
        return expr
    forms, gathered = [expr, sp.factor_terms(expr)], None
    for other in others:
        forms += [other, sp.factor_terms(other), _gathered(other, constants)]
    flat = _expanded(expr)
    if len(sp.Add.make_args(flat)) <= TERMS:
        if len(expr.atoms(sp.sin, sp.cos)) > 1:
            forms += [TR10i(expr)]
            flat = TR10i(flat)
        forms.append(flat)
        gathered = _gathered(flat, constants)
    costs = [_cost(typeset(form)) for form in forms]
    if gathered is not None and _cost(typeset(gathered)) <= LONGER * min(costs):
        return gathered
    return forms[costs.index(min(costs))]


def _expanded(expr: sympy.Expr) -> sympy.Expr:
    """Expands the expression, except inside functions, roots and denominators."""
    import sympy as sp

    kept: dict[sympy.Expr, sympy.Expr] = {}

    def name(x: sympy.Expr) -> sympy.Expr:
        return kept.setdefault(x, sp.Dummy())

    def whole(x: sympy.Expr) -> bool:
        return x.is_Function or (x.is_Pow and not (x.exp.is_Integer and x.exp > 0))

    flat = sp.expand(_outermost(expr, whole, name))
    return flat.xreplace({dummy: x for x, dummy in kept.items()})


def _outermost(
    expr: sympy.Expr,
    found: Callable[[sympy.Expr], bool],
    by: Callable[[sympy.Expr], sympy.Expr],
) -> sympy.Expr:
    if found(expr):
        return by(expr)
    if not expr.args:
        return expr
    return expr.func(*(_outermost(a, found, by) for a in expr.args))


def _has_content(x: sympy.Expr) -> bool:
    return x.is_Pow and x.base.is_Add and x.base.primitive()[0] != 1


def _content_outside(x: sympy.Expr) -> sympy.Expr:
    """Moves the common factor of a sum out of a power of it: sqrt(x^2/4 + y^2/4) becomes
    sqrt(x^2 + y^2)/2."""
    content, rest = x.base.primitive()
    return content**x.exp * rest**x.exp


def _cost(shown: str) -> float:
    """Returns the number of letters plus half of the number of bracket pairs."""
    return mathml.width(shown) + shown.count('form="postfix"') / 2


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
