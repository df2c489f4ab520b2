"""How a scene and the options of the command line restrict a model: makes a `Use` for compiling."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

from ..compiler import Use
from ..equations import Equations, Structure
from ..front.check.scene_numbers import Values, WrongValue
from ..graph.solve import looped
from ..methods import Method, called, in_lanes, known
from ..middle.motion import LINEAR_OF_FEW
from ..middle.reduce.reduce import APART, REDUCTIONS
from ..middle.reduce.reduction import ENOUGH, Needs
from ..middle.report import ReportLine
from ..middle.specialise import folded, held
from ..model import Model, Scene
from ..record import record
from ..run import diagnostics
from ..run.default_method import default_method
from ..system.exits import UsageError
from ..system.near import unknown
from . import model as scene_model
from . import scene as scenes
from .options import OPTIONS, is_motion, with_options

FOLD = "fold"
EXACT = "exact"  # the exact flow of a linear system by the matrix exponential
UNREAD = "unread"  # removal of parameters that nothing reads
EVERY = frozenset((*REDUCTIONS, FOLD, APART, EXACT, UNREAD))


@record(kw_only=True)
class Overrides:
    """Options that override a scene."""

    columns: tuple[str, ...] | None = None  # recorded columns; None: the scene's
    event: str | None = None
    run_time: frozenset[str] = frozenset()  # parameters that are set at run time
    off: frozenset[str] = frozenset()  # reductions that are switched off
    method: str = ""
    apart: bool = False  # whether blocks of coordinates may be integrated separately
    judged: bool = True  # whether the scene's expectations are checked
    rtol: float | None = None
    steps: bool = False  # whether a step size is given
    several: bool = False  # whether an ensemble file has members

    def event_of(self, scene: Scene) -> str:
        """Returns the event whose occurrences are rows, or ""."""
        return self.event or (scene.record.at if scene.record else "")


def of_run(options: argparse.Namespace) -> Use | None:
    """Returns the use for a run: what its rows need; without a scene, everything."""
    columns = None
    if options.record is not None:
        columns = tuple("".join(name.split()) for name in options.record.split(","))
    name = options.scene or OPTIONS
    off = switched_off(options.no_reduce) if options.scene else EVERY - {EXACT}
    if options.diagnose:
        off |= {APART}
    if diagnostics.of_whole(options.diagnose):
        # Normal modes need an equilibrium, and cyclic coordinates do not rest: these are removed.
        off |= {*REDUCTIONS} - ({"cyclic"} if options.diagnose == "modes" else set())
    asked = Overrides(
        columns=columns,
        event=options.at,
        run_time=_run_time(options),
        off=off,
        method=options.method or "",
        apart=options.ensemble is None,
        rtol=_number(options.rtol),
        steps=options.step is not None,
        several=options.ensemble is not None,
    )
    use = replace(_use(name, asked), declared=with_options(options, columns or ()))

    def kernels(used: Model, made: tuple | None) -> frozenset[str] | None:
        """Returns the kernels of the run; None for diagnostics and trials of methods: all."""
        scene = _chosen(used, name, asked)
        own = (options.method, options.step, options.rtol, options.atol)
        if options.diagnose or (scene.accuracy is not None and not any(own)):
            return None
        return _of_method(used, scene, asked, made) | _of_driver(used, scene, asked, made)

    return replace(use, kernels=kernels)


def _number(text: str | None) -> float | None:
    """Parses an option; returns None for an error, which is reported elsewhere."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


def _of_method(model: Model, scene: Scene, asked: Overrides, made: tuple | None) -> frozenset[str]:
    """Returns the kernels of the run's method, or of its default before parameters are known."""
    method, rtol = asked.method or scene.method, asked.rtol
    if rtol is None and scene.rtol is not None:
        with suppress(WrongValue):  # a parameter: the default is valid, maybe with more kernels
            rtol = Values(model, {}).number("rtol", scene.rtol)
    steps = asked.steps or scene.step is not None
    at = asked.event_of(scene)
    several = asked.several or scene.swarm is not None
    if not method and made is not None:
        exact = rtol is None and not steps and not several and EXACT not in asked.off
        method = default_method(*made, rtol or 0.0, exact)
    of = known(model.methods).get(method)
    found = called(of) if of else called("gauss") | {"mass", LINEAR_OF_FEW}
    watched = at or any(event.stop for event in model.events) or scene_model.events(scene)
    if watched:
        found -= {"advance"}  # its many steps in one call would miss events
    if several and (made is None or _side_by_side(*made, of)):
        found |= {"members"}
    return found


def _of_driver(model: Model, scene: Scene, asked: Overrides, made: tuple | None) -> frozenset[str]:
    """Returns the other kernels of a run: for drifts of constants, and for a check of M."""
    found = {"canonical", "conserve"}
    columns = asked.columns or scene_model.columns(scene)
    whole = asked.columns is None and scene.record is None
    structure = made[1] if made else None
    several = asked.several or scene.swarm is not None
    watched = structure is None or structure.conservative
    if whole or watched or "energy" in {*columns, *scene_model.needed(scene)}:
        found |= {"energy"}
    definite = structure and getattr(structure, "definite", True)
    solved = made and getattr(made[0], "constraints", ())  # constrained motion uses the inertia
    needed = not definite or not (several or solved or structure.mass_diagonal)
    if needed and not (made and _without_mass(made[0])):
        found |= {"mass"}
    return frozenset(found)


def _without_mass(e: object) -> bool:
    """Whether a tree of bodies has accelerations without M, whose code would be longer."""
    return isinstance(e, Equations) and e.acceleration is not None and looped(e.graph, e.mass)


def _side_by_side(equations: Equations, structure: Structure, method: Method | None) -> bool:
    """Whether members run in lanes (src/ensemble/adaptive_lanes.c); not if kept as loops."""
    if not isinstance(equations, Equations) or equations.constraints:
        return False
    return in_lanes(method, structure)


def whole(options: argparse.Namespace) -> Use | None:
    """Returns the use for charts and maps: all parameters, all coordinates that are not held."""
    return _of_options(options, None)


def enclosed(options: argparse.Namespace) -> Use | None:
    """Returns the use for rigorous bounds: everything, with a scene's settings as exact numbers."""
    columns = None
    if options.record is not None:
        columns = tuple("".join(name.split()) for name in options.record.split(","))
    return _of_options(options, columns, EVERY - {FOLD})


def _of_options(
    options: argparse.Namespace, columns: tuple[str, ...] | None, off: frozenset[str] = EVERY
) -> Use | None:
    """Returns the use of a model with a scene, columns or input motions of options; else None."""
    if options.scene is None and columns is None and not any(map(is_motion, options.set)):
        return None
    asked = Overrides(columns=columns, run_time=_run_time(options), off=off)
    use = _use(options.scene or OPTIONS, asked, swarm=False)
    return replace(use, declared=with_options(options, columns or ()))


def _run_time(options: argparse.Namespace) -> frozenset[str]:
    """Returns the parameters and inputs that --set sets to numbers, at run time."""
    numbers = (text for text in options.set if not is_motion(text))
    return frozenset(text.partition("=")[0].strip() for text in numbers)


def as_written(name: str) -> Use:
    """Returns the use for checks of a scene without options; no C is made of it."""
    use = _use(name, Overrides(apart=True))
    return Use(use.model, use.needs, lambda *_: ENOUGH)


def of_compile(options: argparse.Namespace) -> Use | None:
    """Returns the use for writing the C of a scene; None without a scene."""
    if options.scene is None:
        return None
    more = frozenset({"canonical"}) if options.canonical else frozenset()  # momenta at the start
    return of_scene(options.scene, switched_off(options.no_reduce), more)


def of_scene(
    name: str, off: frozenset[str] = frozenset(), more: frozenset[str] = frozenset()
) -> Use:
    """Returns the use for embedded C: named after model and scene, with only the kernels of the
    scene's method and columns, and `more`."""
    asked = Overrides(off=off, apart=True, judged=False)
    use = _use(name, asked, swarm=True)

    def named(declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        model, lines = use.model(declared)
        return replace(model, name=f"{model.name}_{name}"), lines

    def kernels(used: Model, made: tuple | None) -> frozenset[str]:
        scene = _chosen(used, name, asked)
        return _of_method(used, scene, asked, made) | shown(used, scene) | more

    return Use(named, use.needs, kernels, use.reads)


def shown(model: Model, scene: Scene) -> frozenset[str]:
    """Returns the kernels of the scene's recorded columns; by default all columns."""
    if scene.record is None:
        return frozenset({"energy", "conserve"})
    return frozenset({"energy"} & set(scene_model.columns(scene)))


def _divided(model: Model, scene: Scene, columns: Iterable[str]) -> bool:
    """Whether blocks may be separate: an accuracy cannot be promised block by block for columns or
    expectations that may combine several blocks."""
    coordinates = {item.name for item in model.coordinates}
    plain = all(column.rstrip("'").split("[")[0] in coordinates for column in columns)
    return scene.accuracy is None or (plain and not scene.expects)


def switched_off(text: str | None) -> frozenset[str]:
    """Parses `--no-reduce` (all) or `--no-reduce=cyclic,fold`. Raises UsageError."""
    if text is None:
        return frozenset()
    names = frozenset(name.strip() for name in text.split(","))
    if names == {"all"}:
        return EVERY
    for name in sorted(names - EVERY):
        raise UsageError(unknown("--no-reduce", name, sorted(EVERY), "reduction"))
    return names


def _chosen(model: Model, name: str, asked: Overrides) -> Scene:
    scene = scenes.chosen(model, name)
    return scene if asked.judged else replace(scene, expects=())


def _use(name: str, asked: Overrides, swarm: bool = True) -> Use:
    def model(declared: Model) -> tuple[Model, tuple[ReportLine, ...]]:
        scene = _chosen(declared, name, asked)
        if scene.swarm is not None and not swarm:
            place = declared.source.place(scene.swarm.span)
            raise UsageError(f"{place}: a swarm is many motions: 'pkgen run' runs it")
        if asked.columns is not None:
            columns = scene_model.written_out(declared, asked.columns, scene)
            scene = scene_model.recording(declared, scene, columns)
        used, lines = scene_model.used(declared, scene, asked.run_time), []
        if FOLD not in asked.off:
            used, lines = folded(used, scene, asked.run_time)
        asked_events = scene_model.events(scene) | {asked.event_of(scene)}
        used, of_holds = held(used, scene, asked_events)
        return used, (*lines, *of_holds)

    def needs(used: Model) -> Needs | None:
        scene = _chosen(used, name, asked)
        columns = asked.columns and scene_model.written_out(used, asked.columns)
        if columns is None and scene.record is not None:
            columns = tuple(scene_model.columns(scene))
        if columns is None or frozenset(REDUCTIONS) <= asked.off:
            return None
        method = known(used.methods).get(asked.method or scene.method)
        if method is not None and "fast" in method.requires:
            return None
        return Needs(
            frozenset(columns) | scene_model.needed(scene),
            scene_model.events(scene) | {asked.event_of(scene)},
            () if method is None else method.requires,
            asked.apart and scene.swarm is None and _divided(used, scene, columns),
            asked.off,
        )

    def reads(used: Model) -> frozenset[str] | None:
        if UNREAD in asked.off or asked.several:
            return None
        return scene_model.reads(used, scenes.chosen(used, name))

    return Use(model, needs, reads=reads)
