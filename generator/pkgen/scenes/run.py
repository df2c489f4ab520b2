"""Functions of `pkgen run` for scenes: parameters, members of a swarm, expectations."""

from __future__ import annotations

import argparse
import re

from ..compiler import Compilation
from ..front.check.check import check_text
from ..front.check.expects import calls
from ..front.check.scene_numbers import Values, WrongValue, has_row
from ..front.read import read
from ..indices import integer
from ..middle.quantities import sizes
from ..model import Model, Scene
from ..run import diagnostics, named
from ..run import values as option_values
from ..run.ensemble import Ensemble, Settable
from ..run.settings import Settings
from ..run.values import assignment
from ..system.exits import UsageError
from . import expects, lengths
from . import scene as scenes
from .judge import Judge, Verdict

_SWARM = re.compile(r"^\s*swarm\b", re.MULTILINE)


def is_swarm(options: argparse.Namespace) -> bool:
    """Whether the scene that --scene names has a swarm, an ensemble defined in the scene."""
    if options.scene is None:
        return False
    source = read(options.model)
    if not _SWARM.search(source.text):
        return False
    model, _ = check_text(source, lengths.given(options.size))
    return any(s.name == options.scene and s.swarm is not None for s in model.scenes)


def refuse_swarm(options: argparse.Namespace, model: Model, scene: Scene) -> None:
    """Raises UsageError for options that cannot be combined with a swarm."""
    at = model.source.place(scene.swarm.span)
    if options.ensemble is not None:
        raise UsageError(f"--ensemble {options.ensemble}: {at}: the scene has a swarm already")
    if options.diagnose is not None:
        diagnostics.refuse_several(diagnostics.asked(options.diagnose), f"for a swarm ({at})")


def count(model: Model, scene: Scene) -> int:
    """Returns the number of members of the scene's swarm."""
    lo, hi = (integer(end, sizes(model)) for end in (scene.swarm.lo, scene.swarm.hi))
    return hi - lo + 1


def values(compilation: Compilation, scene: Scene, settings: Settings) -> Values:
    """Returns the values of parameters and constants in a run of the scene."""
    parameters = named.parameters(compilation)
    given = {parameters.declared[k].first: x for k, x in settings.parameters}
    given |= {parameters.declared[k].first + j: x for k, j, x in settings.members}
    return scenes.values(compilation.declared, scene, named.by_key(parameters, given))


def members(
    options: argparse.Namespace, compilation: Compilation, scene: Scene, settings: Settings
) -> Ensemble:
    from .swarm import members

    names = option_values.Values(compilation)
    given = {names.flat_name("--start", assignment("--start", text)[0]) for text in options.start}
    found = values(compilation, scene, settings)
    return members(compilation.declared, scene, found, Settable(compilation), given)


def watched(
    compilation: Compilation, scene: Scene, settings: Settings, several: bool
) -> expects.Watched:
    """Returns the settings by which a run checks the scene's expectations. Raises UsageError."""
    found = values(compilation, scene, settings)
    try:
        times = tuple(found.not_negative("at", item.at) for item in scene.expects)
    except WrongValue as error:
        raise scenes.wrong(compilation.declared, scene, error.span, error) from None
    for item, at in zip(scene.expects if several else (), times, strict=several):
        if at is not None and not has_row(at, settings.every, settings.until):
            why = f"members have no row at t = {at:.12g}: expect it at a recorded time"
            raise scenes.wrong(compilation.declared, scene, item.span, why)
    observed = [quantity.name for quantity in named.observed(compilation)]
    shown = option_values.Values(compilation).shown
    events, source = named.events(compilation), compilation.declared.source
    return expects.watched(source, scene, observed, events, times, shown)


def watch(compilation: Compilation, scene: Scene | None, settings: Settings) -> str:
    """Returns the value of Settings.watch for an ensemble: "times" if members report the first
    times of events, "events" if they detect events without times, else ""."""
    if scene is not None and any(calls(item, "time") for item in scene.expects):
        return "times"
    stops = any(event.stop for event in compilation.model.events)
    expected = scene is not None and any(item.event for item in scene.expects)
    return "events" if stops or expected or settings.at is not None else ""


def verdicts(
    compilation: Compilation,
    scene: Scene,
    settings: Settings,
    report: dict,
    ensemble: Ensemble | None,
) -> list[Verdict]:
    """Returns the verdicts on expectations; [] if the run has no report."""
    if not scene.expects or "expects" not in report:
        return []
    member = ensemble.named if ensemble else None
    found = values(compilation, scene, settings)
    return Judge(compilation.declared, scene, found, report, member).verdicts()
