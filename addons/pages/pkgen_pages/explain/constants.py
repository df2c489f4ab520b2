"""The section of a page about constants of the motion and their proofs."""

from __future__ import annotations

from collections.abc import Iterator

from pkgen.back.facts import found
from pkgen.compiler import Compilation
from pkgen.explain.explain import NOTHING
from pkgen.graph.graph import Kind
from pkgen.middle.analyze import sympy_bridge
from pkgen.middle.structure import Invariant, Structure, Symmetries

from . import mathml
from .mathml import operator
from .prose import TERMS, Prose
from .shown import Shown
from .tables import heading, lead, table, where
from .typeset import Typesetter


def constants(compilation: Compilation, prose: Prose, shown: Shown | None) -> Iterator[str]:
    """Yields the invariants with proofs and formulas, and the author's claims. `shown` formats the
    equations; it is None if families of coordinates are compiled to loops."""
    structure = compilation.structure
    symmetries = structure.symmetries
    name = prose.written.name
    known = found(compilation.equations, structure)
    rows = [(name(n), prose(why), "") for n, why in known]
    if symmetries is not None and symmetries.searched:
        rows = [
            (_formula(symmetries, x, prose), prose(_why(x)), _generator(x, prose))
            for x in symmetries.invariants
        ]
    rows += [
        (name(claim.name), prose(f"claimed, {claim.outcome}: {claim.says}"), "")
        for claim in structure.claims
    ]
    yield heading("Constants of the motion")
    if rows:
        cells = [(mathml.inline(formula), *others) for formula, *others in rows]
        yield table(("constant", "why", "generator"), cells)
    else:
        yield "<p>None is proved.</p>"
    if shown is not None:
        yield from _meant(structure, shown)
    if symmetries is not None:
        yield f"<p>Searched: {prose(symmetries.searched or NOTHING)}.</p>"
        if any(len(x.terms) > TERMS for x in symmetries.invariants):
            yield "<p>Long sums are whole in what <code>explain --json</code> says.</p>"


def _meant(structure: Structure, shown: Shown) -> Iterator[str]:
    """Yields the formulas of those energies and momenta, as functions of the state, that occur in
    the invariants."""
    e = shown.e
    symmetries = structure.symmetries
    used = {name for name, _ in found(e, structure)}
    if symmetries is not None and symmetries.searched:
        used = {
            n
            for x in symmetries.invariants
            if len(x.terms) <= TERMS
            for _, names in x.terms
            for n in names
        }
    rows = [("energy", e.energy)] if "energy" in used else []
    momenta = zip(e.momenta_names, e.momenta, strict=True)
    rows += [(q.name, node) for q, node in momenta if q.name in used]
    if rows:
        yield lead("As functions of the state")
        yield from where(shown.where([(shown.name(name), node) for name, node in rows]))


def _generator(x: Invariant, prose: Prose) -> str:
    return "" if x.reason == "time shift" else prose.generator(x.generator)


def _why(x: Invariant) -> str:
    return ", ".join(part for part in (x.reason, x.when) if part)


def _formula(symmetries: Symmetries, x: Invariant, prose: Prose) -> str:
    import sympy as sp

    def symbol(s) -> sp.Expr:
        assert s.kind is Kind.PARAMETER
        return sp.Symbol(symmetries.parameters[s.index])

    parts = []
    order = {name: k for k, name in enumerate(symmetries.parameters)}
    for coefficient, names in x.terms:
        (scale,) = sympy_bridge.to_sympy(symmetries.graph, [coefficient], symbol)
        parts.append(scale * sp.Mul(*map(sp.Symbol, names)))
        for name in names:
            order.setdefault(name, len(order))
    typeset = Typesetter(order, frozenset(symmetries.parameters), prose.written.name)
    if len(parts) <= TERMS:
        return typeset(sp.Add(*parts))
    first, last = typeset.terms(parts[0] + parts[1]), typeset(parts[-1])
    sign = "" if parts[-1].could_extract_minus_sign() else mathml.binary("+")
    return mathml.row(*first, operator("+"), operator("…"), sign + last)
