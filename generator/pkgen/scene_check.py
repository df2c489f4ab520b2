"""What is wrong with a scene that only its equations show: a method that does not fit them, a drift
of what is not constant, a motion that cannot be given."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice

from . import options as parsing
from . import scene_use
from .compiler import STAGES, Compilation, stages
from .equations import Equations, Structure
from .exits import UsageError
from .front.check_expects import calls
from .methods import METHODS
from .methods_table import in_words
from .middle.loops import Facts, LoopEquations
from .middle.quantities import indexed
from .model import Model, Scene
from .source import Diagnostic, ModelError
from .tree import Expr, Name, Number

# What options make of the model that the scene does not.
_OTHERWISE = {
    "no_reduce": "--no-reduce switches reductions off",
    "set": "--set leaves parameters to the run",
    "record": "--record asks for other columns",
    "at": "--at asks for another event",
    "diagnose": "--diagnose is of the whole motion",
}


def wrong(declared: Model, sizes: Mapping[str, int], scene: Scene) -> list[Diagnostic]:
    """Of a scene as it is written."""
    unroll = parsing.UNROLL if scene.swarm is None else None  # as it is run
    use = scene_use.as_written(scene.name)
    made = stages(declared.source, sizes, unroll=unroll, use=use)
    try:
        *_, (equations, structure, _) = islice(made, STAGES.index("reduce") + 1)
    except ModelError as error:
        return error.diagnostics
    return [*_unfit(scene, structure), *_drifting(scene, equations, structure)]


def refuse(options: argparse.Namespace, compilation: Compilation, scene: Scene) -> None:
    """Of a scene that is run, options beside it. Raises ModelError; UsageError where the scene is
    right and these are not."""
    equations, structure = compilation.equations, compilation.structure
    method = [] if options.method else [*_unfit(scene, structure)]
    found = [*method, *_drifting(scene, equations, structure)]
    if not found:
        return
    alone = replace(scene, method="") if options.method else scene
    declared = compilation.declared
    as_written = wrong(declared, parsing.sizes(options.size), alone)
    if as_written:
        raise ModelError(declared.source, as_written)
    # What is constant in the scene is so without its reductions: it is the same motion.
    for item in found if options.set else method:
        why = ", ".join(text for name, text in _OTHERWISE.items() if getattr(options, name))
        place = declared.source.place(item.span)
        raise UsageError(f"{place}: scene '{scene.name}': {item.message}: {why}")


def refuse_method(compilation: Compilation, scene: Scene) -> None:
    """Of a scene whose C is written. Raises ModelError."""
    found = [*_unfit(scene, compilation.structure)]
    if found:
        raise ModelError(compilation.declared.source, found)


def _unfit(scene: Scene, structure: Structure | Facts) -> Iterator[Diagnostic]:
    if not scene.method:
        return
    missing = [f for f in METHODS[scene.method].requires if not getattr(structure, f)]
    if missing:
        yield Diagnostic(
            f"{scene.method} needs a system that is {in_words(missing)[0]}, and this is not",
            scene.method_span,
            "'pkgen methods' says what each requires, 'pkgen explain' what this model is",
        )


def _drifting(
    scene: Scene, equations: Equations | LoopEquations, structure: Structure | Facts
) -> Iterator[Diagnostic]:
    constant = {"energy": structure.conservative}
    if isinstance(equations, Equations):
        names = (p.name for p in equations.momenta_names)
        constant |= dict(zip(names, structure.cyclic, strict=True))
    for item in scene.expects:
        for call in calls(item, "drift"):
            name = _shown(call.arguments[0])
            if constant.get(name, True):
                continue
            if name == "energy":
                message, help = "the energy is not constant here", "record it, or what it loses"
            else:
                message, help = f"{name} is not constant here: its coordinate is not cyclic", ""
            yield Diagnostic(f"drift({name}): {message}", call.span, help)


def _shown(expr: Expr) -> str:
    if not isinstance(expr, Name):
        return ""
    index = expr.index.value if isinstance(expr.index, Number) else None
    return indexed(expr.id, index)
