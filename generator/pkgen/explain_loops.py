"""`pkgen explain` of a model whose families are loops: one row of the equations stands for all."""

from __future__ import annotations

from .compiler import Compilation
from .middle.affine import ROW, Affine
from .middle.graph import Kind, Node, Symbol
from .middle.loops import Group, LoopEquations, Row, Total
from .middle.sympy_bridge import to_sympy, written_size

SHOWN_OPERATIONS = 300
SHOWN_AS = {ROW: "i"}  # the index of a row


def explain_loops(compilation: Compilation) -> str:
    """The whole report."""
    e = compilation.equations
    assert isinstance(e, LoopEquations)
    sections = [
        _title(compilation, e),
        _declared("Coordinates", e.coordinates),
        _declared("Parameters", e.parameters),
        _equations(e),
        _structure(compilation, e),
        _cost(compilation),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def record_loops(compilation: Compilation) -> dict[str, object]:
    """The same for `--json`."""
    e = compilation.equations
    assert isinstance(e, LoopEquations)
    return {
        "model": compilation.model.name,
        "description": compilation.model.description,
        "families": "loops",
        "sizes": {size.name: size.value for size in compilation.model.sizes},
        "coordinates": [_name(g) for g in e.coordinates],
        "mass": _mass(e),
        "force": _force(e),
        "structure": dict(vars(e.facts)),
        "operations": list(compilation.program.context["operations"]),
    }


def _title(compilation: Compilation, e: LoopEquations) -> str:
    model = compilation.model
    title = model.name + (f": {model.description}" if model.description else "")
    sizes = ", ".join(f"{s.name} = {s.value}" for s in model.sizes)
    return f"{title}\n{_index(e.count)} degrees of freedom ({sizes}); sizes are set at run time"


def _name(group: Group) -> str:
    return group.name + (f"[{_index(group.lo)}..{_index(group.hi)}]" if group.is_family else "")


def _declared(title: str, groups: tuple[Group, ...]) -> str:
    rows = [
        (_name(g), f"[{g.declared.unit}]" if g.declared.unit else "", g.declared.description)
        for g in groups
    ]
    if not rows:
        return ""
    width = max(len(name) for name, _, _ in rows)
    lines = [f"  {name:<{width}}  {unit:<10} {says}".rstrip() for name, unit, says in rows]
    return "\n".join([title, *lines])


def _equations(e: LoopEquations) -> str:
    lines = ["Equations of motion   M q'' = f, each row from its parts"]
    lines += [f"  {left} = {right}" for left, right in (*_mass(e).items(), *_force(e).items())]
    return "\n".join(lines)


def _mass(e: LoopEquations) -> dict[str, str]:
    found = {
        f"M[{a}[i], {b}[{_at(shift)}]]": _row(e, row)
        for (a, b, shift), row in e.mass.entries.items()
    }
    found |= {f"M[{b}, {a}[i]]": _row(e, row) for (b, a), row in e.mass.border.items()}
    return found | {f"M[{a}, {b}]": _total(e, t) for (a, b), t in e.mass.corner.items()}


def _force(e: LoopEquations) -> dict[str, str]:
    found = {f"f[{name}[i]]": _row(e, row) for name, row in e.force.rows.items()}
    found |= {f"f[{name}]": _total(e, total) for name, total in e.force.totals.items()}
    for pair in e.force.pairs:
        where = f"i = {_index(pair.lo)}..{_index(pair.hi)}"
        where += f", j = {_index(pair.first)}..{_index(pair.last)}"
        for index, side in (("i", pair.by_row), ("j", pair.by_other)):
            found |= {f"f[{n}[{index}]] over pairs {where}": _text(e, node) for n, node in side}
    return found


def _index(at: Affine) -> str:
    return at.text(SHOWN_AS)


def _at(shift: int) -> str:
    return "i" if not shift else f"i {'+' if shift > 0 else '-'} {abs(shift)}"


def _row(e: LoopEquations, row: Row) -> str:
    parts = [
        f"{_text(e, part.node)} for i = {_index(part.lo)}..{_index(part.hi)}" for part in row.parts
    ]
    return "\n    + ".join(parts) or "0"


def _total(e: LoopEquations, total: Total) -> str:
    parts = [_text(e, total.constant)] if total.constant or not total.parts else []
    parts += [
        f"sum({_text(e, part.node)}, i = {_index(part.lo)}..{_index(part.hi)})"
        for part in total.parts
    ]
    return "\n    + ".join(parts)


def _text(e: LoopEquations, node: Node) -> str:
    import sympy as sp

    size = written_size(e.graph, node)
    if size > SHOWN_OPERATIONS:
        return f"({size} operations)"

    def symbol(s: Symbol) -> sp.Symbol:
        if s.kind is Kind.TIME:
            return sp.Symbol("t")
        slot = e.slots[s.index]
        name = slot.name + (f"[{_index(slot.at)}]" if slot.at is not None else "")
        mark = {"v": "'", "w": "''", "d": "'"}.get(slot.kind, "")
        name = SHOWN_AS.get(name, name) if slot.kind == "index" else name
        return sp.Symbol(name + mark)

    (expr,) = to_sympy(e.graph, [node], symbol)
    return sp.sstr(expr).replace("**", "^")


def _structure(compilation: Compilation, e: LoopEquations) -> str:
    facts = e.facts
    shape = "diagonal" if facts.mass_diagonal else "banded"
    if facts.mass_constant:
        once = "a division a row" if facts.mass_diagonal else "factored once"
        shape += f", constant: {once}"
    fused = compilation.program.context["stepper"] is not None
    rows = [
        ("families", "loops in C, the sizes given at run time"),
        ("mass matrix", shape),
        ("separable", "yes: verlet and its like apply" if facts.separable else "no"),
        ("fused steps", "yes: kick and drift in one pass over memory" if fused else "no"),
        ("explicit time", "no" if facts.autonomous else "yes (or an input)"),
        ("forces beyond L", "none" if facts.variational else "yes (force or dissipation)"),
        ("smooth", "yes" if facts.smooth else "no: abs, min, max or step"),
        ("constants", "energy" if facts.conservative else "none proved"),
    ]
    return "\n".join(["Structure", *(f"  {name:<16} {text}" for name, text in rows)])


def _cost(compilation: Compilation) -> str:
    return "\n".join(["Loops", *(f"  {row}" for row in compilation.program.context["operations"])])
