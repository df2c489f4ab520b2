"""The proved properties of a system as text, for `explain` and for the header of its C."""

from __future__ import annotations

from ..equations import AnyEquations, Equations
from ..graph.graph import BIT, Kind
from ..middle.structure import Indices, Invariant, Structure, Symmetries

SHOWN = 8  # The largest number of terms of an invariant, and of blocks of coordinates, to print.


def facts(equations: AnyEquations, structure: Structure) -> list[tuple[str, str]]:
    """Returns rows (property, finding); properties without a finding are left out."""
    own = equations.inertial
    rows = [
        ("mass matrix", _mass(equations, structure) if own else ""),
        ("definite", _definite(structure) if own else ""),
        ("separable", _separable(structure)),
        ("linear", _yes(structure.affine, "constant coefficients", "")),
        ("explicit time", "no" if structure.autonomous else "yes (or an input)"),
        ("forces beyond L", _forces(equations) if own else ""),
        ("smooth", _smooth(equations, structure)),
        ("impulses", _impulses(equations)),
        ("blocks", _blocks(equations, structure.blocks)),
    ]
    return [row for row in rows if row[1]]


def invariants(equations: AnyEquations, structure: Structure) -> list[tuple[str, str]]:
    """Returns rows (constant of the motion, why it is constant). Constants that the model's author
    claims come last."""
    claims = [(x.name, f"claimed, {x.outcome}: {x.says}") for x in structure.claims]
    return [*found(equations, structure), *claims]


def found(equations: AnyEquations, structure: Structure) -> list[tuple[str, str]]:
    """Returns the rows of invariants() that pkgen has found, without the model author's claims."""
    if structure.symmetries is not None and structure.symmetries.searched:
        return found_by_symmetry(structure.symmetries)
    rows = [("energy", "time shift")] if structure.conservative else []
    momenta = zip(equations.momenta_names, structure.cyclic, strict=True)  # states have none
    rows += [(q.name, "cyclic coordinate") for q, cyclic in momenta if cyclic]
    return rows


def found_by_symmetry(symmetries: Symmetries) -> list[tuple[str, str]]:
    return [(shortened(x.name), _why(x)) for x in symmetries.invariants]


def _separable(structure: Structure) -> str:
    if structure.linear_drag:
        return "but for forces C v with constant C: verlet and its like apply"
    if structure.affine_rates:
        return "no: forces are affine in the rates, for which there is boris"
    applies = "verlet and its like apply" + ", and respa" * structure.fast
    return _yes(structure.separable, applies, "verlet does not apply")


def _why(x: Invariant) -> str:
    shift = f"{shortened(x.generator)}" if x.reason == "symmetry" else ""
    return ", ".join(part for part in (f"{x.reason} {shift}".strip(), x.when) if part)


def shortened(text: str) -> str:
    """Returns the text of a sum, shortened to its first and last term if it is long."""
    terms = text.replace(" - ", " + -").split(" + ")
    if len(terms) <= SHOWN:
        return text
    return f"{terms[0]} + ... + {terms[-1]} ({len(terms)} terms)".replace("+ -", "- ")


def _smooth(equations: AnyEquations, structure: Structure) -> str:
    if structure.smooth or not equations.switches:
        return _yes(structure.smooth, "", "abs, min, max or step: take small steps at kinks")
    names = [x.name for x in equations.switches]
    shown = names if len(names) <= SHOWN else [*names[:2], "...", names[-1], f"({len(names)})"]
    said = f"between zeros of {', '.join(shown)}, which a run locates"
    if structure.switched:
        return said
    return f"no: roots of what bends, or kinks elsewhere; {said}"


def _impulses(equations: Equations) -> str:
    names = [switch.quantity.name for switch in equations.impulsive]
    return f"where {' or '.join(names)} vanishes: the rates may jump there" if names else ""


def _mass(equations: Equations, structure: Structure) -> str:
    if equations.mass_in_words:
        return equations.mass_in_words
    shape = "diagonal" if structure.mass_diagonal else "dense"
    n = equations.inertial
    blocks = tuple(block for block in structure.mass_blocks if block[0] < n)
    if 0 < structure.mass_band < (n - 1) / 2:
        shape = f"banded, {structure.mass_band} beside the diagonal"
    elif 1 < len(blocks) < n:
        shape = f"in blocks {_listed(equations, blocks)}"
    if structure.mass_constant:
        return f"{shape}, constant: factored once"
    if not structure.quadratic:
        return f"{shape}, depends on the rates too (L is not of second degree in them)"
    return f"{shape}, depends on {_varying(equations, structure)}"


def _varying(equations: Equations, structure: Structure) -> str:
    """Returns the kinds of quantities on which the mass matrix depends, as text."""
    mask = 0
    for node in sum(equations.mass, ()):
        mask |= equations.graph.depends[node]
    kinds = {Kind.COORDINATE: "the coordinates", Kind.STATE: "the states"}
    if not structure.autonomous:
        kinds |= {Kind.TIME: "t", Kind.INPUT: "the inputs"}
    return " and ".join(text for kind, text in kinds.items() if mask & BIT[kind])


def _forces(equations: Equations) -> str:
    found = equations.forces_beyond
    return f"yes ({' and '.join(found)})" if found else "none"


def _definite(structure: Structure) -> str:
    if structure.definite is None:
        return ""
    if structure.definite:
        return "yes, everywhere"
    if structure.singular:
        return f"not proved; M may be singular where {' or '.join(structure.singular)} vanishes"
    return "not proved; no place found where M is singular"


def _blocks(equations: Equations, blocks: Indices) -> str:
    if len(blocks) < 2:
        return ""
    return f"{_listed(equations, blocks)} do not influence each other"


def _listed(equations: Equations, blocks: Indices) -> str:
    own = equations.inertial
    names = [*equations.moving[:own], *(q.name for q in equations.states)]
    names += [q.name for q in equations.rates[own:]]
    shown = [f"{{{', '.join(names[i] for i in block)}}}" for block in blocks]
    if len(shown) > SHOWN:
        shown = [*shown[:2], "...", shown[-1], f"({len(shown)} of them)"]
    return ", ".join(shown)


def _yes(fact: bool, if_so: str, if_not: str) -> str:
    reason = if_so if fact else if_not
    return ("yes" if fact else "no") + (f": {reason}" if reason else "")
