"""Computes the settings of a run from command-line options. Every error is a UsageError."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from ..compiler import Compilation
from ..defaults import THREADS_MOST
from ..indices import hidden
from ..middle.quantities import indexed
from ..model import Scene
from ..plan import DEFAULT, DEFAULTS
from ..run import diagnostics, named, rows
from ..run.settings import PartSettings, Settings, Shown
from ..run.values import Values, assignment
from ..system.exits import UsageError
from ..system.files import ROWS
from ..system.near import unknown
from . import compile_plan as scene_use
from . import model as scene_model
from . import options as scene_options
from . import scene


def _once(option: str, names: Iterable[str]) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise UsageError(f"{option} {name}: it is given twice")
        seen.add(name)


def kernels(text: str | None, known: Iterable[str]) -> frozenset[str] | None:
    """Returns the kernels in a list such as "mass,force"; None if there is no list."""
    if text is None:
        return None
    wanted = [name.strip() for name in text.split(",")]
    for name in wanted:
        if name not in known:
            raise UsageError(unknown("--kernels", name, list(known), "kernel"))
    return frozenset(wanted)


def output(path: str | None) -> Path | None:
    if path is None or path == "-":
        return None
    if not path.endswith(ROWS):
        raise UsageError(f"-o {path}: the file's name must end in .csv or .npy")
    return Path(path)


def directory(path: str) -> Path:
    if path == "-":
        raise UsageError("-o -: give a directory; several files are written")
    return Path(path)


def settings(
    options: argparse.Namespace,
    compilation: Compilation,
    members: int | None = None,
    chosen: Scene | None = None,
) -> Settings:
    """Returns the settings of `pkgen run` in SI units. Options override the scene, the scene
    overrides defaults. `members` is the size of an ensemble, None for one trajectory."""
    values, plan = Values(compilation), scene_use.planned(options, compilation)
    start_q, start_v, start_parameters = values.starts(options.start)
    sets = [assignment("--set", text) for text in scene_options.numbers(options)]
    _once("--set", (values.flat_name("--set", name) for name, _ in sets))
    lefts = (assignment("--start", text)[0] for text in options.start)
    _once("--start", (values.flat_name("--start", left) for left in lefts))
    parameters, inputs = named.parameters(compilation), named.inputs(compilation)
    parameters_set, inputs_set = values.assigned(sets)
    said = scene.Numbers()
    if chosen is not None:
        at_run = named.by_key(parameters, parameters_set)
        said = scene.numbers(compilation.declared, chosen, at_run)
        of_scene = {
            parameters[indexed(name, index)][0]: x
            for (name, index), x in said.parameters.items()
            if indexed(name, index) in parameters  # the others became constants
        }
        parameters_set = {**of_scene, **parameters_set}
        of_scene = {inputs[n][0]: x for n, x in said.inputs.items() if n in inputs}
        inputs_set = {**of_scene, **inputs_set}
    parameters_set |= start_parameters
    single, of_families = _places(compilation, parameters, tuple(parameters_set.items()))
    of = plan.numbers.else_of(said).else_of(DEFAULTS)
    every = of.every
    show, at = _recorded(options, values, chosen)
    numbers = len(show) + 1
    if not show:
        outputs = named.outputs(compilation).declared
        observed = sum(x.count for x in outputs if not hidden(x.quantity.name))
        numbers = values.coordinates.count + values.rates.count + observed + 2
    if every is None and members is None and at is None:
        every = rows.interval(of.until, of.step, numbers)
    count = of.until / every + 1 if every else 1
    rows.refuse_too_many(options, compilation.declared, chosen, count, numbers, members)
    return Settings(
        method=plan.method,
        **{**asdict(of), "every": every},
        iteration=options.iteration,
        max_steps=_count("--max-steps", options.max_steps),
        parameters=single,
        members=of_families,
        inputs=tuple(inputs_set.items()),
        tables=tuple((k, x.data) for k, x in enumerate(compilation.model.tables) if x.long),
        start_q=tuple(start_q.items()),
        start_v=tuple(start_v.items()),
        show=show,
        at=at,
        units=options.units,
        seed=_seed(options, compilation),
        watch="none" if options.watch == "none" else "",
        diagnose=diagnostics.asked(options.diagnose),
        accuracy=said.accuracy if chosen and scene_use.promised(plan, chosen) else None,
        parts=tuple(
            PartSettings(part.plan.method, of.step, of.rtol)
            for part in compilation.parts
            if plan.source == DEFAULT
        ),
    )


def _seed(options: argparse.Namespace, compilation: Compilation) -> int:
    """Returns the seed of the noise."""
    if options.seed is None:
        return 0
    if not compilation.model.noises:
        raise UsageError(f"--seed {options.seed}: the model has no noise")
    if not 0 <= options.seed < 2**64:
        raise UsageError(f"--seed {options.seed}: from 0 to 2^64 - 1")
    return options.seed


def unread(options: argparse.Namespace, compilation: Compilation) -> list[str]:
    """Returns the names of parameters that --set sets without effect."""
    values, sets = Values(compilation), scene_options.numbers(options)
    names = (values.flat_name("--set", assignment("--set", text)[0]) for text in sets)
    return [name for name in names if values.unread(name) is not None]


def _recorded(
    options: argparse.Namespace, values: Values, chosen: Scene | None
) -> tuple[tuple[Shown, ...], int | None]:
    """Returns the columns to record (empty: all), and the index of the event at which rows are
    written, or None."""
    compilation = values.compilation
    show = at = None
    if chosen is not None and chosen.record is not None:
        at = chosen.record.at or None
    columns, declared = scene_options.record_columns(options), compilation.declared
    if columns is not None:
        name = options.scene or scene_options.OPTIONS
        own = next((s for s in declared.scenes if s.name == name), None)
        names = scene_model.written_out(declared, columns, own)
        show = [values.shown(values.flat_name("--record", name)) for name in names]
        _once("--record", (column.name for column in show))
    elif chosen is not None and chosen.record is not None:
        show = [values.shown(name) for name in scene_model.columns(chosen)]
    if not show and getattr(compilation.equations, "attitudes", ()):
        show = values.standard()
    if options.at is not None:
        at = options.at
    events = named.events(compilation)
    if at is not None and at not in events:
        raise UsageError(unknown("--at", at, events, "event"))
    return tuple(show or ()), None if at is None else events.index(at)


def threads(options: argparse.Namespace, several: bool) -> int | None:
    """Returns the number of threads of an ensemble; None means one for each processor."""
    if options.threads is None:
        return None
    if not several:
        raise UsageError("--threads is for --ensemble and swarms: one trajectory has one thread")
    if options.threads > THREADS_MOST:
        raise UsageError(f"--threads {options.threads}: {THREADS_MOST} at most")
    return _count("--threads", options.threads)


def _places(
    compilation: Compilation, parameters: named.Named, values: tuple[tuple[int, float], ...]
) -> tuple[tuple[tuple[int, float], ...], tuple[tuple[int, int, float], ...]]:
    """Converts flat indices of parameters to indices of the runtime: (index, value) of a single
    parameter, (index, member, value) of a member of a family that is kept as a loop."""
    single, members = [], []
    for flat, x in values:
        k, member = parameters.place(flat)
        if parameters.declared[k].lo is None:
            single.append((k, x))
        else:
            members.append((k, member, x))
    return tuple(single), tuple(members)


def _count(option: str, value: int) -> int:
    if value <= 0:
        raise UsageError(f"{option} {value}: must be positive")
    return value
