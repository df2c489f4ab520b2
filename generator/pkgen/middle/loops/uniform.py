"""Whether all members of a model's families are alike but for the ends, whatever their number.

Then a proof with a few members holds for any number. dA/dt is a sum over members of one body of its
neighbours, and of terms at the two ends. That of N members, and that of the last N - 1 of them,
differ by an expression of the first few members alone, the same for each N. Where dA/dt vanishes
for two successive numbers, that expression vanishes, and with it dA/dt for all larger numbers.
"""

from __future__ import annotations

from ...model import Model
from ...tree import (
    Add,
    Call,
    Expr,
    Multiply,
    Name,
    Number,
    Power,
    Range,
    Sum,
    children,
    names,
    within,
)

NEAR = 2  # how far from a member or an end what is read may lie
FEWEST = 7  # members at least: twice what two ends of this width take, and one more


def members_are_alike(model: Model) -> bool:
    """Whether no body has a term by the index or the number of members, nor reaches far."""
    sizes = {size.name for size in model.sizes}
    if len(sizes) != 1:
        return False
    summed = {item.name for item in model.definitions if _sums(item.value)}
    for item in (*model.definitions, *model.forces, *model.rates, *model.constraints):
        variables = sizes | ({item.range.variable} if item.range else set())
        ends = _ends(item.range) if item.range else ()
        at = (item.index,) if item.index is not None else ()
        if not all(_near(end, sizes) for end in (*ends, *at)):
            return False
        if item.name in names(item.value) or not _is_alike(item.value, variables, sizes):
            return False
    for end in model.ends:
        if end.value is not None and not _is_alike(end.value, sizes, sizes):
            return False
    energies = (*model.kinetic, *model.potential, *model.lagrangian, *model.dissipation)
    whole = (*energies, *(item.value for item in model.conserved))
    return all(_is_alike(x, sizes, sizes) and _is_linear(x, summed) for x in whole)


def _ends(range_: Range) -> tuple[Expr, Expr]:
    return range_.lo, range_.hi


def _is_alike(expr: Expr, variables: set[str], sizes: set[str]) -> bool:
    """Whether indices and sizes stand in subscripts and ranges alone, and near a member there."""
    waiting: list[tuple[Expr, set[str]]] = [(expr, variables)]
    while waiting:
        part, known = waiting.pop()
        if isinstance(part, Name):
            if part.id in known or (part.index is not None and not _near(part.index, known)):
                return False
            continue
        if isinstance(part, Sum):
            known = known | {r.variable for r in part.ranges}
            if not all(_near(end, known) for r in part.ranges for end in _ends(r)):
                return False
            waiting.append((part.body, known))
            continue
        waiting += [(child, known) for child in children(part)]
    return True


def _near(index: Expr, variables: set[str]) -> bool:
    """Whether it is a small number, or a variable and a small number."""
    terms = zip(index.terms, index.signs, strict=True) if isinstance(index, Add) else ((index, 1),)
    seen = 0
    for term, sign in terms:
        if isinstance(term, Number):
            if abs(term.value) > NEAR:
                return False
        elif isinstance(term, Name) and term.id in variables and term.index is None and sign > 0:
            seen += 1
        else:
            return False
    return seen <= 1


def _sums(expr: Expr) -> bool:
    return any(isinstance(part, Sum) for part in within(expr))


def _is_linear(expr: Expr, summed: set[str]) -> bool:
    """Whether no sum stands in a function or beside another one in a product."""

    def has_sum(part: Expr) -> bool:
        return _sums(part) or bool(names(part) & summed)

    for part in within(expr):
        if isinstance(part, Multiply):
            parts = list(zip(part.factors, part.exponents, strict=True))
            if sum(has_sum(x) for x, _ in parts) > 1 or any(has_sum(x) and e < 0 for x, e in parts):
                return False
        if isinstance(part, Power | Call | Sum) and any(map(has_sum, _inside(part))):
            return False
    return True


def _inside(part: Expr) -> tuple[Expr, ...]:
    return (part.body,) if isinstance(part, Sum) else children(part)
