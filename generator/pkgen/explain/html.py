"""`pkgen explain --html`: the report as one page with the equations typeset; it loads nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from ..back.c.program import operations_text
from ..back.facts import facts, found, loop_facts
from ..compiler import Compilation
from ..equations import Equations, Invariant, Quantity, Structure, Symmetries
from ..graph.graph import ZERO, Kind, Node
from ..middle.analyze import sympy_bridge
from ..middle.loops.loops import Facts
from ..system import page
from ..version import __version__
from . import mathml
from .bound import constraint_rows, rates_title
from .explain import NOTHING, SHOWN_OPERATIONS, canonical_rows, default_text
from .html_loops import loop_sections
from .scenes import SceneShown

MATRIX = 4  # coordinates up to which M is shown whole
TERMS = 12  # of an invariant's formula; more are cut


def html(compilation: Compilation, scenes: Sequence[SceneShown] = ()) -> str:
    """The page. `scenes` are those that were reduced, each by itself."""
    model = compilation.model
    sections = loop_sections(compilation) if compilation.looped else _sections(compilation)
    return page.document(
        model.name.replace("_", " "),
        [
            f"<p>{escape(model.description)}</p>" if model.description else "",
            *sections,
            *_structure(compilation),
            *_constants(compilation.structure, _known(compilation)),
            *(part for scene in scenes for part in scene_section(scene)),
            page.heading("Operations of each kernel"),
            _operations(compilation),
            f"<p>pkgen {__version__}</p>",
        ],
    )


def scene_section(scene: SceneShown) -> list[str]:
    """What the scene left out and why, and what that saves."""
    names = [*scene.before, *(name for name in scene.after if name not in scene.before)]
    rows = [(name, _count(scene.before.get(name)), _count(scene.after.get(name))) for name in names]
    return [
        page.heading(f"Scene {scene.name}"),
        f"<p>{escape(scene.description)}</p>" if scene.description else "",
        page.items(scene.lines) if scene.lines else "<p>It needs all of the model.</p>",
        page.table(("kernel", "operations of the model", "of the scene"), rows) if rows else "",
    ]


def _count(operations: int | None) -> str:
    return "not there" if operations is None else str(operations)


def _sections(compilation: Compilation) -> list[str]:
    e = compilation.equations
    motion = [
        page.heading("Lagrangian"),
        *_lagrangian(e),
        page.heading("Equations of motion"),
        *_equations(e),
    ]
    return [
        *_quantities("Coordinates", e.seen),
        *_quantities("Body rates", e.rates[len(e.seen) :]),
        *_quantities("Attitudes", e.states[: e.quaternions]),
        *_quantities("States", e.states[e.quaternions :]),
        *_parameters(e),
        *(motion if e.coordinates else []),
        *_constraints(e),
        *_rates(e),
        *_canonical(e),
        *_outputs(e),
    ]


def _quantities(title: str, quantities: Sequence[Quantity]) -> list[str]:
    if not quantities:
        return []
    rows = [(q.name, q.unit, q.description) for q in quantities]
    return [page.heading(title), page.table(("", "unit", ""), rows)]


def _parameters(e: Equations) -> list[str]:
    if not e.parameters:
        return []
    rows = [
        (slot.quantity.name, default_text(e, slot), slot.quantity.description)
        for slot in e.parameters
    ]
    return [page.heading("Parameters"), page.table(("", "default", ""), rows)]


def _lagrangian(e: Equations) -> Iterable[str]:
    yield _line(mathml.name("L"), _math(e, e.lagrangian))
    if e.kinetic is not None and e.potential is not None:
        yield _line(mathml.name("T"), _math(e, e.kinetic))
        yield _line(mathml.name("V"), _math(e, e.potential))


def _equations(e: Equations) -> Iterable[str]:
    names, force = e.moving, e.force if e.constraints is None else e.constraints.free_force
    n = len(names)
    if n <= MATRIX:
        mass = [[_math(e, e.mass[i][j]) for j in range(n)] for i in range(n)]
        rates = (f"{q.name}'" for q in e.rates)
        left = [mathml.matrix(mass), mathml.matrix([[mathml.name(x)] for x in rates])]
        right = mathml.matrix([[_math(e, f)] for f in force])
        yield _line(mathml.row(*left), right)
        return
    yield _line(mathml.row(mathml.name("M"), mathml.name("q''")), mathml.name("f"))
    for i, row in enumerate(e.mass):
        for j in range(i + 1):
            if row[j] != ZERO:
                yield _line(mathml.name(f"M[{names[i]}, {names[j]}]"), _math(e, row[j]))
    for x, node in zip(names, force, strict=True):
        yield _line(mathml.name(f"f[{x}]"), _math(e, node))


def _constraints(e: Equations) -> Iterable[str]:
    rows = list(constraint_rows(e))
    if rows:
        yield page.heading("Constraints: 0 =, their forces J^T lambda beside f; and lambda =")
        yield from (_line(mathml.name(name), _math(e, node)) for name, node in rows)


def _rates(e: Equations) -> Iterable[str]:
    if e.states:
        yield page.heading(rates_title(e))
    for q, node in zip(e.states, e.state_rates, strict=True):
        yield _line(mathml.name(f"{q.name}'"), _math(e, node))


def _canonical(e: Equations) -> Iterable[str]:
    rows = canonical_rows(e)
    if rows:
        yield page.heading("Canonical form")
        yield from (_line(mathml.name(name), _math(e, node)) for name, node in rows)


def _outputs(e: Equations) -> Iterable[str]:
    named = [
        *zip(e.observed_names, e.observed, strict=True),
        *zip(e.conserved_names, e.conserved, strict=True),
        *zip(e.event_names, e.events, strict=True),
    ]
    if named:
        yield page.heading("Outputs and events")
        yield from (_line(mathml.name(q.name), _math(e, node)) for q, node in named)


def _structure(compilation: Compilation) -> Iterable[str]:
    yield page.heading("Structure")
    if compilation.looped:
        yield page.table(("", ""), loop_facts(compilation.equations))
    else:
        yield page.table(("", ""), facts(compilation.equations, compilation.structure))


def _known(compilation: Compilation) -> list[tuple[str, str]]:
    """What is constant where no symmetries were searched for."""
    if compilation.looped:
        return [("energy", "time shift")] if compilation.structure.conservative else []
    return found(compilation.equations, compilation.structure)


def _constants(structure: Structure | Facts, known: list[tuple[str, str]]) -> Iterable[str]:
    """The invariants with their proofs, and the claims with theirs."""
    symmetries = structure.symmetries
    rows = [(mathml.inline(mathml.name(name)), escape(why)) for name, why in known]
    if symmetries is not None and symmetries.searched:
        rows = [(mathml.inline(_formula(symmetries, x)), _why(x)) for x in symmetries.invariants]
    for claim in structure.claims:
        why = escape(f"claimed, {claim.outcome}: {claim.says}")
        rows.append((mathml.inline(mathml.name(claim.name)), why))
    yield page.heading("Constants of the motion")
    if not rows:
        yield "<p>None is proved.</p>"
    else:
        cells = "".join(f"<tr><td>{formula}</td><td>{why}</td></tr>" for formula, why in rows)
        yield f"<table><tr><th></th><th>why it is constant</th></tr>{cells}</table>"
    if symmetries is not None:
        yield f"<p>Searched: {escape(symmetries.searched or NOTHING)}.</p>"
        if any(len(x.terms) > TERMS for x in symmetries.invariants):
            yield "<p>Long sums are whole in what <code>explain --json</code> says.</p>"


def _why(x: Invariant) -> str:
    shift = "" if x.reason == "time shift" else f"<br>generator {escape(_cut(x.generator))}"
    return escape(", ".join(part for part in (x.reason, x.when) if part)) + shift


def _cut(text: str) -> str:
    parts = text.split(" + ")
    return text if len(parts) <= TERMS else " + ".join([*parts[:2], "...", parts[-1]])


def _formula(symmetries: Symmetries, x: Invariant) -> str:
    import sympy as sp

    def symbol(s) -> sp.Expr:
        assert s.kind is Kind.PARAMETER
        return sp.Symbol(symmetries.parameters[s.index])

    parts = []
    for coefficient, names in x.terms:
        (scale,) = sympy_bridge.to_sympy(symmetries.graph, [coefficient], symbol)
        parts.append(scale * sp.Mul(*map(sp.Symbol, names)))
    if len(parts) > TERMS:
        negative = parts[-1].could_extract_minus_sign()
        sign, last = ("-", -parts[-1]) if negative else ("+", parts[-1])
        shown = [
            mathml.expression(parts[0] + parts[1]),
            mathml.operator("+ …"),
            mathml.operator(sign),
        ]
        return mathml.row(*shown, mathml.expression(last))
    return mathml.expression(sp.Add(*parts))


def _operations(compilation: Compilation) -> str:
    if compilation.looped:
        return page.items(compilation.program.context["operations"])
    kernels = compilation.program.kernels
    rows = [(kernel.name, operations_text(kernel.operations)) for kernel in kernels]
    return page.table(("kernel", "operations"), rows)


def _line(left: str, right: str) -> str:
    return mathml.block(mathml.equation(left, right))


def _math(e: Equations, node: Node) -> str:
    shown = sympy_bridge.expression(e, node, SHOWN_OPERATIONS)
    if isinstance(shown, int):
        return mathml.words(f"({shown} operations)")
    return mathml.expression(shown)
