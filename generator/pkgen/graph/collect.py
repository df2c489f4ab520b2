"""Rewrites expressions with fewer operations: expands them to sums of products, then factors.

After expansion, terms from different parts of a computation may cancel (the Coriolis terms in dL/dq
and in dp/dt). A policy (policies.py) selects sums that are not expanded. Factoring is greedy. Among
the monomials that are common to two terms it chooses the one that saves most operations, and takes
this monomial out of every term that contains it. It then does the same within the bracket and among
the remaining terms. The form with the fewest operations is used.
"""

from __future__ import annotations

from collections.abc import Iterable

from . import policies
from .count import operations
from .differentiate import reachable
from .graph import BIT, MINUS_ONE, ONE, VARIABLE, Graph, Kind, Node, Op
from .monomials import merged
from .normal import WORK, Monomial, Normal, Polynomial, squares_merged
from .residues import Varying

# A term of a sum, as (factor of numbers and parameters, monomial of factors with variables).
Term = tuple[Node, Monomial]

# The largest number of terms of an output that is factored; larger sums are not.
FACTORED = 80
# The limit of work (term products) of the policy `shared`, which expands few sums.
SHARED_WORK = 50_000
# The largest number of nodes below the outputs for which all policies are tried.
THOROUGH = 400


def fewest(g: Graph, outputs: list[Node], thorough: bool = True) -> list[Node]:
    """Returns the outputs in the cheapest form: unchanged, or rewritten by one of the policies."""
    return min(forms(g, outputs, thorough), key=lambda form: operations(g, form))


def shortened(g: Graph, outputs: Iterable[Node]) -> list[Node]:
    """Returns the outputs in the form of fewest operations, after `settled`. Returns them unchanged
    if they are large."""
    outputs = list(outputs)
    thorough = len(reachable(g, outputs)) <= THOROUGH
    return fewest(g, settled(g, outputs)) if thorough else outputs


def forms(
    g: Graph, outputs: list[Node], thorough: bool = True, short_kept: bool = False
) -> list[list[Node]]:
    """Returns the unchanged outputs, followed by the outputs as rewritten by each policy. A form
    that takes too much work to find is left out.

    With `short_kept`, outputs in which nothing can be saved are not rewritten, to save time.
    """
    tried = [(policies.shared, SHARED_WORK)] + ([(policies.shifts, WORK)] if thorough else [])
    found = [rewritten(g, outputs, policy, work, short_kept) for policy, work in tried]
    return [list(outputs), *(form for form in found if form is not None)]


def settled(g: Graph, outputs: list[Node]) -> list[Node]:
    """Replaces each output whose value is the same at all states by this constant, though the
    output contains variables."""
    normal = Normal(g)
    seen = Varying(g)
    seen.learn(outputs, VARIABLE)
    result = []
    for output in outputs:
        maybe = g.depends[output] & VARIABLE and not seen(output, VARIABLE)
        polynomial = normal(output) if maybe else None
        if polynomial is not None and not varies(g, polynomial):
            output = normal.plain(polynomial)
        result.append(output)
    return result


def varies(g: Graph, polynomial: Polynomial) -> bool:
    return any(g.depends[base] & VARIABLE for monomial in polynomial for base, _ in monomial)


def rewritten(
    g: Graph,
    outputs: list[Node],
    policy: policies.Policy,
    work: int,
    short_kept: bool = False,
) -> list[Node] | None:
    """Returns the outputs expanded and factored; None if that exceeds `work`."""
    normal = Normal(g, policy(g, outputs), canonical=False, work=work)
    result: dict[Node, Node] = {}
    for output in outputs:
        if output in result:
            continue
        if not g.depends[output] & VARIABLE or (short_kept and _is_short(g, output)):
            result[output] = output
            continue
        polynomial = normal(output)
        if polynomial is None:
            return None
        result[output] = factored(g, normal, squares_merged(g, polynomial))
    return [result[output] for output in outputs]


def _is_short(g: Graph, output: Node) -> bool:
    """Whether the output's terms share no factor and contain no powers, sums or rates, so that
    nothing can cancel or be factored out."""
    if g.depends[output] & BIT[Kind.RATE]:
        return False
    bases: set[Node] = set()
    for _, rest in g.terms(g.split(output)[1]) or ((ONE, output),):
        for base, exponent in g.key(rest):
            if exponent != 1 or base in bases or g.op[base] is Op.ADD:
                return False
            bases.add(base)
    return True


def factored(g: Graph, normal: Normal, polynomial: Polynomial) -> Node:
    """Converts a polynomial to an expression of few operations."""
    terms = grouped(g, normal, polynomial)
    if len(terms) > FACTORED:
        return g.sum(g.multiply(p, _monomial(g, m)) for p, m in terms)
    return _factored(g, terms)


def grouped(g: Graph, normal: Normal, polynomial: Polynomial) -> list[Term]:
    """Returns the polynomial as a list of terms. Each monomial of factors with variables occurs
    once; its scale contains all numbers and parameters."""
    scales: dict[Monomial, Polynomial] = {}
    for monomial in sorted(polynomial):
        fixed, free = parted(g, monomial)
        scales.setdefault(free, {})[fixed] = polynomial[monomial]
    return [(normal.plain(scale), free) for free, scale in scales.items()]


def parted(g: Graph, monomial: Monomial) -> tuple[Monomial, Monomial]:
    """Returns the factors of a monomial without variables, and those with variables."""
    fixed = tuple(f for f in monomial if g.is_constant(f[0]))
    return fixed, tuple(f for f in monomial if not g.is_constant(f[0]))


def _factored(g: Graph, terms: list[Term]) -> Node:
    terms = list(terms)
    while len(terms) > 1:
        found = _best_factor(g, terms)
        if found is None:
            break
        scale, common, members = found
        inner = []
        for i in members:
            p, m = terms[i]
            if scale != ONE:
                p = ONE if p == scale else MINUS_ONE
            inner.append((p, merged(m, tuple((b, -e) for b, e in common))))
        bracket = _factored(g, inner)
        p, rest = g.split(bracket)
        p = g.multiply(scale, p)
        first = members[0]
        chosen = set(members)
        terms[first] = (p, merged(common, ((rest, 1),) if rest != ONE else ()))
        terms = [t for i, t in enumerate(terms) if i == first or i not in chosen]
    return g.sum(g.multiply(p, _monomial(g, m)) for p, m in terms)


def _best_factor(g: Graph, terms: list[Term]) -> tuple[Node, Monomial, list[int]] | None:
    """Returns a scale and a monomial as a common factor, and the indices of the terms that contain
    both. The choice saves most operations. Returns None if nothing can be saved."""
    best_found = None
    best_saving = 0
    signs = {ONE, MINUS_ONE}
    tried: set[tuple[Node, Monomial]] = set()
    negated = [g.negate(p) for p, _ in terms]
    for i, (p, m) in enumerate(terms):
        for j in range(i):
            s, n = terms[j]
            common = _common(m, n)
            same = not {p, s} & signs and (p == s or negated[i] == s)
            key = (s if same else ONE, common)
            if not (common or same) or key in tried:
                continue
            tried.add(key)
            members = [
                k
                for k, (r, part) in enumerate(terms)
                if _has(part, common) and (not same or r == s or negated[k] == s)
            ]
            cost = sum(abs(e) for _, e in common) + same
            saving = cost * (len(members) - 1)
            if saving > best_saving:
                best_saving = saving
                best_found = (s if same else ONE, common, members)
    return best_found


def _common(a: Monomial, b: Monomial) -> Monomial:
    other = dict(b)
    found = []
    for base, e in a:
        f = other.get(base, 0)
        if e > 0 and f > 0:
            found.append((base, min(e, f)))
        elif e < 0 and f < 0:
            found.append((base, max(e, f)))
    return tuple(found)


def _has(monomial: Monomial, part: Monomial) -> bool:
    powers = dict(monomial)
    return all(
        (e > 0 and powers.get(b, 0) >= e) or (e < 0 and powers.get(b, 0) <= e) for b, e in part
    )


def _monomial(g: Graph, monomial: Monomial) -> Node:
    """Returns the product of the factors. The factors without rates are multiplied first, so that
    terms that differ only in rates share this partial product."""
    rates = BIT[Kind.RATE]
    slow = [f for f in monomial if not g.depends[f[0]] & rates]
    fast = [f for f in monomial if g.depends[f[0]] & rates]
    left = g.product(g.power(b, e) for b, e in slow)
    return g.multiply(left, g.product(g.power(b, e) for b, e in fast))
