"""Merges terms of a sum: a x + b x -> (a + b) x, and R sin(x)^2 + R cos(x)^2 -> R for any R."""

from __future__ import annotations

from collections.abc import Iterator

from .monomials import Factors, Node, merged
from .nodes import TERMS, ZERO, Nodes, Terms

Found = dict[Factors, tuple[Node, Node]]  # monomial of a term -> (scale, rest)


def merge(g: Nodes, left: Terms, right: Terms) -> list[tuple[Node, Node]] | None:
    """Returns the terms of left + right after merging; None if they are more than the terms of the
    longer sum."""
    if not _may_merge(g, left, right):
        return None
    terms = {g._factors[r]: (p, r) for p, r in left}
    bound = max(len(left), len(right))
    for p, r in right:
        key = g._factors[r]
        if key in terms:
            p = g.add(terms[key][0], p)
            if p == ZERO:
                del terms[key]
            else:
                terms[key] = (p, r)
        elif not _merge_squares(g, terms, p, r):
            terms[key] = (p, r)
        if len(terms) > 2 * TERMS:
            return None
    return list(terms.values()) if len(terms) <= bound else None


def _may_merge(g: Nodes, left: Terms, right: Terms) -> bool:
    """Whether the sums have a common monomial, or one of them contains a squared sine or cosine."""
    factors = g._factors
    known = [factors[r] for _, r in left]
    for _, r in right:
        if factors[r] in known or _squared(g, r):
            return True
    return any([_squared(g, r) for _, r in left])


def _squared(g: Nodes, rest: Node) -> bool:
    partner = g._partner
    for base, exponent in g._factors[rest]:  # noqa: SIM110 (a loop is faster than any() here)
        if exponent >= 2 and base in partner:
            return True
    return False


def _merge_squares(g: Nodes, terms: Found, scale: Node, rest: Node) -> bool:
    """Merges the term scale * rest with one of `terms`, by R sin^2 + R cos^2 -> R or R - R sin^2 ->
    R cos^2. Returns whether one of these rules applied."""
    for other_key, wanted_scale, new_scale, new_rest in _square_partners(g, scale, rest):
        if other_key in terms and terms[other_key][0] == wanted_scale:
            del terms[other_key]
            _merge_into(g, terms, new_scale, new_rest)
            return True
    for key, (other_scale, other) in terms.items():
        if not _squared(g, other) or g.negate(scale) != other_scale:
            continue
        for other_key, wanted_scale, new_scale, new_rest in _square_partners(g, other_scale, other):
            if other_key == g._factors[rest] and wanted_scale == scale:
                del terms[key]
                _merge_into(g, terms, new_scale, new_rest)
                return True
    return False


def _square_partners(
    g: Nodes, scale: Node, rest: Node
) -> Iterator[tuple[Factors, Node, Node, Node]]:
    """Yields the terms that merge with scale * rest by sin^2 + cos^2 = 1 and the like. A term is a
    scale times factors. Each is yielded as (factors of the term, its scale, scale of the sum,
    factors of the sum)."""
    factors = g._factors[rest]
    for base, exponent in factors:
        partner = g._partner.get(base) if exponent >= 2 else None
        if partner is None:
            continue
        common = merged(factors, ((base, -2),))
        swapped = merged(common, ((partner, 2),))
        yield swapped, scale, scale, g._product_of(common)
        yield common, g.negate(scale), g.negate(scale), g._product_of(swapped)


def _merge_into(g: Nodes, terms: Found, scale: Node, rest: Node) -> None:
    """Adds a term to `terms`, merging it with like terms."""
    scale, rest = g.multiply(scale, g._scale[rest]), g._rest[rest]
    key = g._factors[rest]
    if key in terms:
        scale = g.add(terms.pop(key)[0], scale)
    elif _merge_squares(g, terms, scale, rest):
        return
    if scale != ZERO:
        terms[key] = (scale, rest)
