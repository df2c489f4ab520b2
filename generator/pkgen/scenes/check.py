"""Finds errors of a scene that only its equations reveal: a method that cannot integrate them, a
quantity that is expected to be constant but is not, a motion that cannot be prescribed."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice

from ..compiler import STAGES, Compilation, stages
from ..equations import AnyEquations
from ..front.check.expects import calls
from ..indices import unrolled
from ..methods import Own, known, provides
from ..middle.quantities import indexed, sizes
from ..middle.report import Report
from ..middle.structure import Structure
from ..model import Model, Scene
from ..run.methods_table import in_words
from ..source import Diagnostic, ModelError
from ..system.exits import UsageError
from . import compile_plan as scene_use
from . import expects, lengths
from . import model as scene_model

# Options that change the equations of a scene, with a text for messages.
_OTHERWISE = {
    "no_reduce": "--no-reduce switches reductions off",
    "set": "--set leaves parameters to the run",
    "record": "--record asks for other columns",
    "at": "--at asks for another event",
    "diagnose": "--diagnose is of the whole motion",
    "ensemble": "--ensemble has no loops over families",
}

NOT_PROMISED = (
    "the scene's accuracy is not promised: --method, --step, --rtol or --atol choose in its place"
)


def wrong(declared: Model, given: Mapping[str, int], scene: Scene) -> list[Diagnostic]:
    """Returns the errors that a scene has if it runs without options other than --size. `given` has
    the values of --size."""
    unroll = lengths.UNROLL if scene.swarm is None else lengths.UNROLL_MEMBERS  # as in prepare()
    use = scene_use.CheckUse(scene=scene.name, apart=True)
    made = stages(declared.source, given, unroll=unroll, use=use)
    try:
        *_, (equations, structure, report) = islice(made, STAGES.index("reduce") + 1)
    except ModelError as error:
        return error.diagnostics
    alike = _alike(declared, scene, report)
    return [
        *_unfit(scene, structure, declared.methods),
        *alike,
        *_drifting(scene, equations, structure),
    ]


def refuse(options: argparse.Namespace, compilation: Compilation, scene: Scene) -> None:
    """Checks a scene that runs with options. Raises ModelError for errors of the scene alone,
    UsageError for errors that the options cause."""
    equations, structure = compilation.equations, compilation.structure
    alone = replace(scene, method="") if options.method else scene
    own = compilation.model.methods
    compiled = [
        *_unfit(alone, structure, own),
        *_alike(compilation.declared, scene, compilation.report),
    ]
    found = [*compiled, *_drifting(scene, equations, structure)]
    if not found:
        return
    declared = compilation.declared
    as_written = wrong(declared, lengths.given(options.size), alone)
    if as_written:
        raise ModelError(declared.source, as_written)
    # `found` includes errors about drifts of constants. Without --set they are left out: the motion
    # is that of the scene alone, which has no such errors.
    for item in found if options.set else compiled:
        why = ", ".join(text for name, text in _OTHERWISE.items() if getattr(options, name))
        place = declared.source.place(item.span)
        raise UsageError(f"{place}: scene '{scene.name}': {item.message}: {why}")


def refuse_method(compilation: Compilation, scene: Scene) -> None:
    """Raises ModelError if the scene's method cannot integrate its equations."""
    found = [*_unfit(scene, compilation.structure, compilation.model.methods)]
    if found:
        raise ModelError(compilation.declared.source, found)


def _unfit(scene: Scene, structure: Structure, own: tuple[Own, ...]) -> Iterator[Diagnostic]:
    if not scene.method:
        return
    missing = [f for f in known(own)[scene.method].requires if not provides(structure, f)]
    if missing:
        yield Diagnostic(
            f"{scene.method} needs a system that is {in_words(missing)[0]}, and this is not",
            scene.method_span,
            "'pkgen methods' says what each requires, 'pkgen explain' what this model is",
        )


def _drifting(scene: Scene, equations: AnyEquations, structure: Structure) -> Iterator[Diagnostic]:
    names = (p.name for p in equations.momenta_names)
    constant = {"energy": structure.conservative, **dict(zip(names, structure.cyclic, strict=True))}
    for item in scene.expects:
        for call in calls(item, "drift"):
            name = expects.column(call.arguments[0])
            if constant.get(name, True):
                continue
            if name == "energy":
                message, help = "the energy is not constant here", "record it, or what it loses"
            else:
                message, help = f"{name} is not constant here: its coordinate is not cyclic", ""
            yield Diagnostic(f"drift({name}): {message}", call.span, help)


def _alike(declared: Model, scene: Scene, report: Report) -> Iterator[Diagnostic]:
    """Yields an error for a swarm whose starts have no effect on the recorded columns."""
    differ = [s for s in scene.starts if scene_model.of_swarm(scene, s.value)]
    for start in differ:
        names = (indexed(start.name, index) for index, _ in unrolled(start, sizes(declared)))
        if any(n not in report.unused or (n, start.order) in report.starts for n in names):
            return
    if not differ:
        return
    yield Diagnostic(
        "all members of the swarm would be the same: nothing recorded depends on the starts that "
        "differ",
        scene.swarm.span,
        "record what differs, or start what is recorded",
    )
