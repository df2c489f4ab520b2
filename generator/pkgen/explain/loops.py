"""`pkgen explain` of a model whose families are loops: one row of the equations stands for all."""

from __future__ import annotations

from functools import partial

from ..back.facts import loop_facts, loop_invariants
from ..compiler import Compilation
from ..describe.drawing import shown
from ..graph.affine import Affine
from ..middle.loops.loops import Facts, Group, LoopEquations, PairForce, PairPart, Total
from .explain import constants_text, drawing, proofs_record, structure_record
from .rows import EquationLine, M, Writer


def explain_loops(compilation: Compilation) -> str:
    """The whole report."""
    e = compilation.equations
    assert isinstance(e, LoopEquations)
    write = Writer(e)
    sections = [
        _title(compilation, write),
        _declared(write, "Coordinates", e.coordinates),
        _declared(write, "Parameters", e.parameters),
        _lagrangian(write),
        _equations(write),
        drawing(compilation),
        _structure(compilation, e),
        _constants(e.facts),
        _cost(compilation),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def record_loops(compilation: Compilation) -> dict[str, object]:
    """The same for `--json`."""
    e = compilation.equations
    assert isinstance(e, LoopEquations)
    write = Writer(e)
    return {
        "model": compilation.model.name,
        "description": compilation.model.description,
        "families": "loops",
        "sizes": {size.name: size.value for size in compilation.model.sizes},
        "coordinates": [name_of(write, g) for g in e.coordinates],
        "mass": _record(mass_lines(write)),
        "force": _record(force_lines(write)),
        "pairs": [
            {"range": pair_range(write, pair), "force": _record(pair_lines(write, pair))}
            for pair in e.force.pairs
        ],
        "beyond": beyond(write),
        "structure": structure_record(e.facts),
        **proofs_record(e.facts),
        "drawing": list(shown(compilation.declared)),
        "operations": list(compilation.program.context["operations"]),
    }


def _record(lines: list[EquationLine]) -> dict[str, str]:
    return {f"{x.left} for {x.range}" if x.range else x.left: x.right for x in lines}


def _title(compilation: Compilation, write: Writer) -> str:
    model = compilation.model
    title = model.name + (f": {model.description}" if model.description else "")
    sizes = ", ".join(f"{s.name} = {s.value}" for s in model.sizes)
    count = write.index(write.e.count)
    return f"{title}\n{count} degrees of freedom ({sizes}); sizes are set at run time"


def name_of(write: Writer, group: Group) -> str:
    return group.name + (
        f"[{write.index(group.lo)}..{write.index(group.hi)}]" if group.is_family else ""
    )


def _declared(write: Writer, title: str, groups: tuple[Group, ...]) -> str:
    rows = [
        (
            name_of(write, g),
            f"[{unit}]" if (unit := g.declared.unit) else "",
            g.declared.description,
        )
        for g in groups
    ]
    if not rows:
        return ""
    width = max(len(name) for name, _, _ in rows)
    lines = [f"  {name:<{width}}  {unit:<10} {says}".rstrip() for name, unit, says in rows]
    return "\n".join([title, *lines])


def _lagrangian(write: Writer) -> str:
    e = write.e
    if e.kinetic is None or e.potential is None:
        return f"Lagrangian\n  L = {total_of(write, e.lagrangian)}"
    parts = [("T", e.kinetic), ("V", e.potential)]
    return "\n".join(
        ["Lagrangian   L = T - V", *(f"  {name} = {total_of(write, x)}" for name, x in parts)]
    )


def _equations(write: Writer) -> str:
    lines = ["Equations of motion   M q'' = f"]
    lines += [f"  {line}" for line in (*mass_lines(write), *force_lines(write))]
    for pair in write.e.force.pairs:
        lines.append(f"  for each pair {pair_range(write, pair)}:")
        lines += [f"    {line.left} += {line.right}" for line in pair_lines(write, pair)]
    lines += [f"  where {line}" for line in beyond(write)]
    return "\n".join(lines)


def mass_lines(write: Writer) -> list[EquationLine]:
    """The lower triangle: of a family's member with lower ones, and with families above it."""
    e, found = write.e, []
    order = [g.name for g in e.families]
    for g in e.families:
        items = [
            (partial(_entry, write, g, write.groups[other], shift), row.parts)
            for (own, other, shift), row in e.mass.entries.items()
            if own == g.name and order.index(other) <= order.index(own)
        ]
        items += [
            (partial(_member, write, f"M[{scalar}, {{}}]", g), row.parts)
            for (scalar, own), row in e.mass.border.items()
            if own == g.name
        ]
        found += write.rows(g, items)
    scalars = [g.name for g in e.scalars]
    return found + [
        EquationLine(f"M[{a}, {b}]", total_of(write, total))
        for (a, b), total in e.mass.corner.items()
        if scalars.index(b) <= scalars.index(a)
    ]


def _entry(write: Writer, group: Group, other: Group, shift: int, at: Affine) -> str | None:
    row, column = write.home(group, at), write.home(other, at + shift)
    below = row - column
    upper = below.constant < 0 if below.is_constant else any(f < 0 for _, f in below.terms)
    name = write.name(other, at + shift)
    if name is None or (group is other and upper):
        return None
    return f"M[{write.name(group, at)}, {name}]"


def _member(write: Writer, form: str, group: Group, at: Affine) -> str:
    return form.format(write.name(group, at))


def force_lines(write: Writer) -> list[EquationLine]:
    e, found = write.e, []
    for name, row in e.force.rows.items():
        group = write.groups[name]
        if row.parts:
            found += write.rows(group, [(partial(_member, write, "f[{}]", group), row.parts)])
        elif not e.force.pairs:
            found.append(EquationLine(f"f[{name}[{write.i}]]", "0", write.span(group.lo, group.hi)))
    return found + [EquationLine(f"f[{n}]", total_of(write, t)) for n, t in e.force.totals.items()]


def pair_lines(write: Writer, pair: PairForce) -> list[EquationLine]:
    sides = [(f"f[{n}[{write.i}]]", node) for n, node in pair.by_row]
    sides += [(f"f[{n}[{write.j}]]", node) for n, node in pair.by_other]
    sides += [(f"f[{n}]", node) for n, node in pair.by_scalar]
    return [EquationLine(left, write.text([(node, M)])) for left, node in sides]


def pair_range(write: Writer, pair: PairForce | PairPart) -> str:
    others = f"{write.j} = {write.index(pair.first)}..{write.index(pair.last)}"
    return f"{write.span(pair.lo, pair.hi)}, {others}"


def beyond(write: Writer) -> list[str]:
    """What lies beyond the ends of families."""
    found = []
    for g in write.e.families:
        if g.periodic:
            found.append(
                f"{g.name}[{write.i}+{write.index(g.count)}] = {g.name}[{write.i}] (periodic)"
            )
        for at, end in g.ends:
            if end.kind == "fixed":
                value = write.text([(write.e.given[g.name, at][0], M)])
            else:
                value = f"{g.name}[{write.index(write.home(g, at))}]"
            found.append(f"{g.name}[{write.index(at)}] = {value} ({end.kind})")
    return found


def total_of(write: Writer, total: Total) -> str:
    style = write.style
    parts = [write.text([(total.constant, M)])] if total.constant else []
    parts += [
        style.total(write.span(part.lo, part.hi), write.text([(part.node, M)]))
        for part in total.parts
    ]
    parts += [style.total(pair_range(write, p), write.text([(p.node, M)])) for p in total.pairs]
    return style.plus(parts) if parts else "0"


def _structure(compilation: Compilation, e: LoopEquations) -> str:
    fused = compilation.program.context["stepper"] is not None
    rows = [
        ("families", "loops in C, the sizes given at run time"),
        *loop_facts(e),
        ("fused steps", "yes: kick and drift in one pass over memory" if fused else "no"),
        ("constants", "energy" if e.facts.conservative else "none proved"),
    ]
    return "\n".join(["Structure", *(f"  {name:<16} {text}" for name, text in rows)])


def _constants(facts: Facts) -> str:
    return constants_text(loop_invariants(facts), facts.symmetries)


def _cost(compilation: Compilation) -> str:
    return "\n".join(["Loops", *(f"  {row}" for row in compilation.program.context["operations"])])
