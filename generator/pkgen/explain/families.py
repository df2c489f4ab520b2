"""`pkgen explain` of a model whose families q[1..N] are compiled to loops: equations in i."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ..compiler import Compilation
from ..equations import ParameterSlot, Quantity
from ..graph.affine import Affine
from ..indices import indexed
from ..middle.families.equations import Assigned, Bounded, FamilyEquations
from ..middle.families.indexed_ir import Addend, Cell, Group, Over, of_name
from .contents import Contents, Shown
from .rows import EquationLine, M, Part, Writer


def contents(compilation: Compilation) -> Contents:
    e, model = compilation.equations, compilation.model
    assert isinstance(e, FamilyEquations)
    write, operations = Writer(e), compilation.program.context["operations"]
    fused = compilation.program.context["stepper"]
    energy = [f"{name} = {text}" for name, text in energies(write)]
    motion = "   M q'' = f" * bool(model.coordinates) + " + J^T lambda" * bool(e.bound)
    return Contents(
        e=e,
        text=lambda node: write.text([(node, M)]),
        freedom=freedom(e),
        declared=declared(write),
        parameters=[
            _slot(write, *at) for at in zip(e.parameters, e.defaults, e.bounds, strict=True)
        ],
        equations=[
            ("Lagrangian   L = T - V" if energy[1:] else "Lagrangian", energy),
            (f"Equations of motion{motion}", _equations(write)),
            (
                "Constraints   0 =, J their derivatives by the rates",
                map(str, constraint_lines(write)),
            ),
            ("Made along the members, for outputs alone", map(str, along_lines(write))),
        ],
        outputs=[*_outputs(write)],
        families=[
            ("families", "loops in C, the sizes given at run time"),
            ("fused steps", "yes: kick and drift in one pass over memory" if fused else "no"),
        ],
        costs=("Loops", operations),
        record={
            "families": "loops",
            "sizes": {size.name: size.value for size in model.sizes},
            "coordinates": [name_of(write, g) for g in e.coordinates],
            "mass": _record(mass_lines(write)),
            "force": _record(force_lines(write)),
            "pairs": [
                {"range": write.over(over), "force": _record(lines)}
                for over, lines in pair_lines(write)
            ],
            "beyond": beyond(write),
            "carried": _record(carried_lines(write)),
            "constraints": _record(constraint_lines(write)),
            "operations": list(operations),
        },
    )


def freedom(e: FamilyEquations) -> str:
    """Returns counts of degrees of freedom, rotations and states, like "2 N degrees of freedom"."""
    write = Writer(e)
    kinds = (
        ("degrees of freedom", lambda g: not g.is_state),
        ("rotations", lambda g: g.is_turn and g.name.endswith(".x")),  # the first of three
        ("states", lambda g: g.is_state and "." not in g.name),
    )
    counts = [(sum((g.count for g in e.coordinates if of(g)), Affine()), x) for x, of in kinds]
    parts = [f"{write.index(count)} {what}" for count, what in counts if count != Affine()]
    sizes = ", ".join(f"{s.name} = {s.value}" for s in e.model.sizes)
    return f"{' and '.join(parts)} ({sizes}); sizes are set at run time"


def _record(lines: list[EquationLine]) -> dict[str, str]:
    return {f"{x.left} for {x.range}" if x.range else x.left: x.right for x in lines}


def name_of(write: Writer, group: Group) -> str:
    over = f"{write.index(group.lo)}..{write.index(group.hi)}" if group.is_family else None
    return indexed(group.shown, over)


def _quantity(write: Writer, g: Group) -> Quantity:
    return Quantity(name_of(write, g), g.declared.unit, g.declared.description)


def _outputs(write: Writer) -> Iterator[Shown]:
    for x in write.e.outputs:
        span = "" if x.lo is None else write.span(x.lo, x.hi)
        yield indexed(x.item.name, write.i if span else None), x.item.unit, x.node, span
    for item, node in zip(write.e.model.conserved, write.e.conserved, strict=True):
        yield item.name, item.unit, node, ""


def _slot(write: Writer, g: Group, default: Assigned, at: Bounded) -> ParameterSlot:
    """Returns a ParameterSlot that stands for all members of a parameter family."""
    own, follows = g.declared.bounds, g.declared.follows
    shown = (at.lo, at.hi, own.lo_open, own.hi_open)
    return ParameterSlot(_quantity(write, g), g.name, 0, 0, default.node, follows, *shown)


def declared(write: Writer) -> list[tuple[str, list[Quantity]]]:
    """Returns coordinates, angular velocities of bodies, attitudes and states, by kind."""
    e, numbers = write.e, {name for r in write.e.model.rotations for name in r.quaternion}
    kinds = {
        "Coordinates": [g for g in e.coordinates if not (g.is_state or g.is_turn)],
        "Body rates": [g for g in e.coordinates if g.is_turn],
        "Attitudes": [g for g in e.states if g.name in numbers],
        "States": [g for g in e.states if g.name not in numbers],
    }
    return [(kind, [_quantity(write, g) for g in groups]) for kind, groups in kinds.items()]


def energies(write: Writer) -> list[tuple[str, str]]:
    """Returns the formulas of T and V, or of L if the model does not have both."""
    e = write.e
    parts = [("T", e.kinetic), ("V", e.potential)]
    if e.kinetic is None or e.potential is None:
        parts = [("L", e.lagrangian)]
    return [(name, write.total(total)) for name, total in parts if total is not None]


def _equations(write: Writer) -> Iterator[str]:
    yield from map(str, (*mass_lines(write), *force_lines(write)))
    for over, lines in pair_lines(write):
        yield f"for each pair {write.over(over)}:"
        yield from (f"  {line.left} += {line.right}" for line in lines)
    yield from map(str, rate_lines(write))
    yield from (f"where {line}" for line in beyond(write))
    if write.e.carried:
        yield f"where {carried_says(write)}:"
        yield from (f"  {line}" for line in carried_lines(write))


def along_lines(write: Writer) -> list[EquationLine]:
    """Returns those recurrences along families whose values only outputs use. Time derivatives of
    the recurrences are left out."""
    found = []
    for item in (item for together in write.e.along for item in together):
        for part in item.parts if "'" not in item.name else ():
            lo, hi = part.over
            left = indexed(item.name, write.index(lo if lo == hi else M))
            over = "" if lo == hi else write.span(lo, hi)
            found.append(EquationLine(left, write.text([(part.node, M)]), over))
    return found


def carried_says(write: Writer) -> str:
    """Returns a sentence about carried values, which are defined by a recurrence along a family:
    how forces on them are passed back to the variables that define them."""
    names = ", ".join(g.name for g in write.e.carried_groups)
    return f"the rows of {names} go over to what each is made of, from the last member to the first"


def carried_lines(write: Writer) -> list[EquationLine]:
    """Returns the recurrences that define carried values along a family."""
    found = []
    for item in write.e.carried:
        parts = tuple(Part(p.lo, p.hi, p.value, p.value) for p in item.pieces)
        label = partial(_member, write, "{}", item.group)
        found += write.rows(item.group, [(label, parts)])
    return found


def mass_lines(write: Writer) -> list[EquationLine]:
    """Returns the lower triangle of the mass matrix M. For each member of a family it has the
    entries with earlier members of the same family, with families declared earlier, and with single
    coordinates."""
    e, found = write.e, []
    order = [g.name for g in e.rows]
    for g in e.rows:
        if g.is_state:
            continue
        entries: dict[Cell, list[Addend]] = {}
        for x in of_name(e.mass, g.name):
            (_, row), (other, column) = x.to
            key = other, None if column is None else column - row
            if column is None or order.index(other) <= order.index(g.name):
                entries.setdefault(key, []).append(x)
        items = [
            (_label(write, g, other, shift), tuple(map(write.part, parts)))
            for (other, shift), parts in entries.items()
        ]
        found += write.rows(g, items)
    scalars = {g.name: k for k, g in enumerate(e.scalars)}
    corner: dict[tuple[str, str], list[Addend]] = {}
    for x in e.mass:
        (a, _), (b, _) = x.to
        if scalars.get(a, -1) >= scalars.get(b, len(scalars)) and not write.groups[a].is_state:
            corner.setdefault((a, b), []).append(x)
    return found + [
        EquationLine(
            f"M[{write.groups[a].shown}, {write.groups[b].shown}]", write.total(tuple(total))
        )
        for (a, b), total in corner.items()
    ]


def _label(write: Writer, g: Group, other: str, shift: Affine | None):
    if shift is None:
        return partial(_member, write, f"M[{write.groups[other].shown}, {{}}]", g)
    return partial(_entry, write, g, write.groups[other], shift.constant)


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
    return _rows_of(write, "f[{}]", False)


def constraint_lines(write: Writer) -> list[EquationLine]:
    """Returns the function phi(q, t) of each holonomic constraint phi = 0, and the expression
    J v + j0 of each rolling constraint J v + j0 = 0 on the rates v."""
    found = []
    for rows in write.e.bound:
        group, what = rows.group, rows.position if rows.holonomic else rows.rate
        single = rows.is_single
        at = group.lo if single else M
        name = rows.name + (f"[{write.index(at)}]" if group.is_family else "")
        text = write.total(what) if single else write.text([(what[0].node, M)] if what else [])
        span = "" if single else write.span(group.lo, group.hi)
        found.append(EquationLine(name, text, span))
    return found


def rate_lines(write: Writer) -> list[EquationLine]:
    """Returns the rates of change of the first-order variables."""
    return _rows_of(write, "{}'", True)


def _rows_of(write: Writer, form: str, states: bool) -> list[EquationLine]:
    e, found = write.e, []
    for group in e.rows:
        if group.is_state != states:
            continue
        own = of_name(e.force, group.name)
        parts = tuple(write.part(x) for x in own if len(x.over) < 4)
        if parts:
            found += write.rows(group, [(partial(_member, write, form, group), parts)])
        elif not e.has_pairs:
            left = form.format(indexed(group.shown, write.i))
            found.append(EquationLine(left, "0", write.span(group.lo, group.hi)))
    return found + [
        EquationLine(
            form.format(g.shown),
            write.total(tuple(x for x in of_name(e.force, g.name) if len(x.over) < 4)),
        )
        for g in e.scalars
        if g.is_state == states
    ]


def pair_lines(write: Writer) -> list[tuple[Over, list[EquationLine]]]:
    """Returns the forces of sums over pairs, with the ranges of both indices."""
    found: dict[Over, list[EquationLine]] = {}
    for x in write.e.force:
        if len(x.over) < 4:
            continue
        name, at = x.to[0]
        group = write.groups[name]
        index = None if at is None else write.index(at)
        form = "{}'" if group.is_state else "f[{}]"
        left = form.format(indexed(group.shown, index))
        line = EquationLine(left, write.text([(x.node, M)]))
        found.setdefault(x.over, []).append(line)
    return list(found.items())


def beyond(write: Writer) -> list[str]:
    """Returns the boundary conditions of families: for each index just outside a family, the value
    there."""
    found = []
    for g in write.e.families:
        if g.is_turn:
            # Attitudes have the same boundary conditions as the angular velocities of the
            # rotations, and are listed once.
            continue
        if g.periodic:
            far = indexed(g.name, f"{write.i}+{write.index(g.count)}")
            found.append(f"{far} = {indexed(g.name, write.i)} (periodic)")
        for at, end in g.ends:
            if end.kind == "fixed":
                value = write.text([(write.e.given[g.name, at][0], M)])
            else:
                value = indexed(g.name, write.index(write.home(g, at)))
            found.append(f"{indexed(g.name, write.index(at))} = {value} ({end.kind})")
    return found
