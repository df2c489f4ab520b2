"""`pkgen explain --html`: the report as one self-contained page with typeset equations.

`fragment()` makes the same report for inclusion in another page, which also needs the styles from
`style()` of `style.py`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from pkgen.back.c.program import operations_text
from pkgen.back.facts import facts
from pkgen.compiler import Compilation
from pkgen.describe.drawing import shown as drawn
from pkgen.explain.contents import Contents
from pkgen.explain.explain import contents
from pkgen.explain.scenes import SceneShown
from pkgen.version import __version__

from .. import page
from .constants import constants
from .equations import EquationSections, parameter_table, quantity_rows
from .families import family_sections
from .prose import Prose
from .shown import Shown
from .style import style
from .tables import details, facts_table, heading, listed, table
from .written import Written


def html(compilation: Compilation, scenes: Sequence[SceneShown] = ()) -> str:
    """Returns the page. `scenes` are the scenes of the model, each compiled separately."""
    title = compilation.model.name.replace("_", " ")
    parts = [fragment(compilation, scenes), f"<footer>pkgen {__version__}</footer>"]
    return page.document(title, parts, style())


def fragment(compilation: Compilation, scenes: Sequence[SceneShown] = (), level: int = 2) -> str:
    """Returns the content of the page without its title: equations, structure, constants of the
    motion, and the simplifications in each scene. `level` is the level of its headings. The content
    has no styles, scripts, ids or URLs."""
    model = compilation.model
    written = Written(model)
    prose = Prose(written, *_words(compilation))
    e, c = compilation.equations, contents(compilation)
    shown = Shown(e) if e.dense else None
    if shown is None:
        equations = family_sections(e, written)
    else:
        equations = EquationSections(shown, written, prose).all()
    parts = [
        f"<p>{prose(model.description)}</p>" if model.description else "",
        f'<p class="count">{prose(c.freedom)}</p>',
        *_quantities(c, prose),
        *parameter_table(c, prose),
        *equations,
        heading("Structure"),
        facts_table((n, prose(t)) for n, t in facts(e, compilation.structure)),
        *constants(compilation, prose, shown),
        *_reductions(compilation, prose),
        *(part for scene in scenes for part in scene_section(scene, prose)),
        heading("Drawing"),
        listed(f"<code>{escape(line)}</code>" for line in drawn(compilation.declared)),
        details("Operations of each kernel", *_operations(compilation)),
    ]
    body = "\n".join(part for part in parts if part)
    if level != 2:
        body = body.replace("<h2>", f"<h{level}>").replace("</h2>", f"</h{level}>")
    return f'<div class="explained">\n{body}\n</div>\n'


def _words(compilation: Compilation) -> tuple[set[str], set[str]]:
    """Returns the model's names, and its formulas, that may occur in sentences."""
    e, model = compilation.equations, compilation.model
    declared = (*model.parameters, *model.coordinates, *model.states, *model.inputs)
    names = {x.name for x in (*declared, *model.observed, *model.conserved, *model.rotations)}
    names |= {x.name for x in model.definitions}
    if not e.dense:
        return names, set()
    kinds = e.coordinates, e.rates, e.momenta_names, e.inputs, e.states, e.observed_names
    names |= {q.name for kind in kinds for q in kind}
    names |= {slot.quantity.name for slot in e.parameters}
    formulas = {x.quantity.name for x in e.switches} | {*compilation.structure.singular}
    return names, formulas - names


def _quantities(c: Contents, prose: Prose) -> Iterable[str]:
    for title, quantities in (*c.declared, ("Inputs", c.e.inputs)):
        if quantities:
            yield heading(title)
            yield table(("symbol", "unit", "meaning"), quantity_rows(quantities, prose))


# -- scenes ---------------------------------------------------------------------------------------


def scene_section(scene: SceneShown, prose: Prose) -> Iterable[str]:
    """Yields the section about a scene: the parts of the model that are left out of the scene's C,
    and the operations that this saves."""
    yield heading(f"Scene {scene.name.replace('_', ' ')}")
    if scene.description:
        yield f"<p>{prose(scene.description)}</p>"
    yield listed(map(prose, scene.lines)) if scene.lines else "<p>It needs all of the model.</p>"
    called = [name for name in scene.before if name in scene.after]
    rows = [(name, _count(scene.before[name]), _count(scene.after[name])) for name in called]
    rows += [
        (name, "not there", _count(scene.after[name]))
        for name in scene.after
        if name not in scene.before
    ]
    if rows:
        parts = [table(("kernel", "operations of the model", "of the scene"), rows)]
        gone = [name for name in scene.before if name not in scene.after]
        parts += [f"<p>Not called, so not there: {', '.join(gone)}.</p>"] if gone else []
        yield details("What that saves", *parts)


def _count(operations: int) -> str:
    return f"{operations:,}"


def _reductions(compilation: Compilation, prose: Prose) -> Iterable[str]:
    lines = compilation.report.lines
    if lines:
        yield heading("Reductions")
        yield listed(prose(str(line)) for line in lines)


def _operations(compilation: Compilation) -> list[str]:
    if not compilation.equations.dense:
        return [listed(map(escape, compilation.program.context["operations"]))]
    kernels = compilation.program.kernels
    rows = [(kernel.name, escape(operations_text(kernel.operations))) for kernel in kernels]
    return [table(("kernel", "operations"), rows)]
