"""What a scene makes of its model, from the options of the command line beside it."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import dataclass, replace

from . import diagnostics, scene_model
from . import scene as scenes
from .compiler import Use
from .exits import UsageError
from .methods import called, carries_quadratures
from .middle.reduce import APART, REDUCTIONS
from .middle.reduction import ENOUGH, Needs
from .middle.report import Line
from .middle.specialise import folded, held
from .model import Model, Scene
from .option_values import unknown

FOLD = "fold"
EXACT = "exact"  # the flow of a linear system, by its exponential
EVERY = frozenset((*REDUCTIONS, FOLD, APART, EXACT))


@dataclass(frozen=True)
class Asked:
    """What options say beside the scene: other columns, an event, parameters to be set in the run,
    and reductions that are not to be made."""

    columns: tuple[str, ...] | None
    event: str | None
    run_time: frozenset[str]
    off: frozenset[str]
    quadratures: bool
    method: str  # "" without
    apart: bool
    judged: bool = True  # what the scene expects is measured


def of_run(options: argparse.Namespace) -> Use | None:
    """For a run: no more than its rows need."""
    if options.scene is None:
        return None
    columns = None
    if options.record is not None:
        columns = tuple("".join(name.split()) for name in options.record.split(","))
    off = switched_off(options.no_reduce)
    if options.diagnose:
        off |= {APART}
    if diagnostics.of_whole(options.diagnose):
        off |= {*REDUCTIONS}
    asked = Asked(
        columns,
        options.at,
        frozenset(text.partition("=")[0].strip() for text in options.set),
        off,
        True,
        options.method or "",
        options.ensemble is None,
    )
    return _use(options.scene, asked)


def whole(options: argparse.Namespace) -> Use | None:
    """For charts and maps: all coordinates that the scene does not hold, all parameters."""
    if options.scene is None:
        return None
    run_time = frozenset(text.partition("=")[0].strip() for text in options.set)
    return _use(options.scene, Asked(None, None, run_time, EVERY, False, "", False), swarm=False)


def as_written(name: str) -> Use:
    """For what is to be known of a scene without options; no C is made of it."""
    use = _use(name, Asked(None, None, frozenset(), frozenset(), True, "", True))
    return Use(use.model, use.needs, lambda _: ENOUGH)


def of_compile(options: argparse.Namespace) -> Use | None:
    """For C of a scene."""
    if options.scene is None:
        return None
    more = frozenset({"canonical"}) if options.canonical else frozenset()  # p of the starts
    return of_scene(options.scene, switched_off(options.no_reduce), more)


def of_scene(
    name: str, off: frozenset[str] = frozenset(), more: frozenset[str] = frozenset()
) -> Use:
    """For C to be embedded: named after model and scene, and no more kernels than the scene's
    method calls, and `more`."""
    asked = Asked(
        None, None, frozenset(), off, quadratures=True, method="", apart=True, judged=False
    )
    use = _use(name, asked, swarm=True)

    def named(declared: Model) -> tuple[Model, tuple[Line, ...]]:
        model, lines = use.model(declared)
        return replace(model, name=f"{model.name}_{name}"), lines

    def kernels(used: Model) -> frozenset[str]:
        scene = _chosen(used, name, asked)
        return called(scene.method) | shown(used, scene) | more

    return Use(named, use.needs, kernels)


def shown(model: Model, scene: Scene) -> frozenset[str]:
    """The kernels of what it records: all where it says nothing about that."""
    if scene.record is None:
        return frozenset({"energy", "conserve"})
    return frozenset({"energy"} & set(scene_model.columns(scene)))


def _divided(model: Model, scene: Scene, columns: Iterable[str]) -> bool:
    """Whether an accuracy can be promised part by part: not of what may be made of several."""
    coordinates = {item.name for item in model.coordinates}
    plain = all(column.rstrip("'").split("[")[0] in coordinates for column in columns)
    return scene.accuracy is None or (plain and not scene.expects)


def switched_off(text: str | None) -> frozenset[str]:
    """`--no-reduce`, or `--no-reduce=cyclic,fold`."""
    if text is None:
        return frozenset()
    names = frozenset(name.strip() for name in text.split(","))
    if names == {"all"}:
        return EVERY
    for name in sorted(names - EVERY):
        raise UsageError(unknown("--no-reduce", name, sorted(EVERY), "reduction"))
    return names


def _chosen(model: Model, name: str, asked: Asked) -> Scene:
    scene = scenes.chosen(model, name)
    return scene if asked.judged else replace(scene, expects=())


def _use(name: str, asked: Asked, swarm: bool = True) -> Use:
    def model(declared: Model) -> tuple[Model, tuple[Line, ...]]:
        scene = _chosen(declared, name, asked)
        if scene.swarm is not None and not swarm:
            place = scenes.place(declared, scene.swarm.span)
            raise UsageError(f"{place}: a swarm is many motions: 'pkgen run' runs it")
        if asked.columns is not None:
            columns = scene_model.written_out(declared, asked.columns)
            scene = scene_model.recording(declared, scene, columns)
        used, lines = scene_model.used(declared, scene, asked.run_time), []
        if FOLD not in asked.off:
            used, lines = folded(used, scene, asked.run_time)
        at = asked.event or (scene.record.at if scene.record else "")
        used, of_holds = held(used, scene, scene_model.events(scene) | {at})
        return used, (*lines, *of_holds)

    def needs(used: Model) -> Needs | None:
        scene = _chosen(used, name, asked)
        columns = asked.columns and scene_model.written_out(used, asked.columns)
        if columns is None and scene.record is not None:
            columns = tuple(scene_model.columns(scene))
        if columns is None or frozenset(REDUCTIONS) <= asked.off:
            return None
        at = asked.event or (scene.record.at if scene.record else "")
        return Needs(
            frozenset(columns) | scene_model.needed(scene),
            frozenset((at,)) | scene_model.events(scene),
            asked.quadratures and carries_quadratures(asked.method or scene.method),
            asked.apart and scene.swarm is None and _divided(used, scene, columns),
            asked.off,
        )

    return Use(model, needs)
