"""Settings of a run from options of the command line, for a model. Every error is a UsageError."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from ..compiler import Compilation
from ..front.check.scene_numbers import ROUND_OFF
from ..indices import hidden
from ..methods import Own, known
from ..middle.quantities import indexed
from ..model import Scene
from ..run import diagnostics, named, rows
from ..run.default_method import default_method
from ..run.settings import PartSettings, Settings, Shown
from ..run.values import Values, assignment
from ..system.exits import UsageError
from ..system.near import unknown
from . import compile_plan as scene_use
from . import model as scene_model
from . import options as scene_options
from . import scene

UNTIL = 10.0
RTOL = 1e-10
THREADS_MOST = 1024  # a system may refuse to start more, which would abort the program


def _once(option: str, names: Iterable[str]) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise UsageError(f"{option} {name}: it is given twice")
        seen.add(name)


def kernels(text: str | None, known: Iterable[str]) -> frozenset[str] | None:
    """Parses `--kernels mass,force`."""
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
    if not path.endswith((".csv", ".npy")):
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
    """Returns the settings of `pkgen run` in SI units: from options, else from the scene, else
    defaults. `members`: the size of an ensemble or swarm; None: one trajectory."""
    values = Values(compilation)
    rtol = values.positive("--rtol", options.rtol, "")
    starts, start_parameters = values.starts(options.start)
    sets = [assignment("--set", text) for text in scene_options.numbers(options)]
    _once("--set", (values.flat_name("--set", name) for name, _ in sets))
    lefts = (assignment("--start", text)[0] for text in options.start)
    _once("--start", (values.flat_name("--start", left) for left in lefts))
    sets, _ = values.read(sets)
    parameters, inputs = named.parameters(compilation), named.inputs(compilation)
    parameters_set = dict(values.assigned("--set", sets, parameters, inputs))
    inputs_set = dict(values.assigned("--set", sets, inputs, parameters))
    said = scene.Numbers({}, {})
    if chosen is not None:
        given = values.by_key(parameters, parameters_set)
        said = scene.numbers(compilation.declared, chosen, given)
        of_scene = {
            parameters[indexed(name, index)][0]: x
            for (name, index), x in said.parameters.items()
            if indexed(name, index) in parameters  # others were replaced by constants
        }
        parameters_set = {**of_scene, **parameters_set}
        of_scene = {inputs[n][0]: x for n, x in said.inputs.items() if n in inputs}
        inputs_set = {**of_scene, **inputs_set}
    parameters_set |= start_parameters
    single, of_families = _places(compilation, parameters, tuple(parameters_set.items()))
    least = ROUND_OFF
    if rtol is not None and rtol < least and options.atol is None:
        raise UsageError(
            f"--rtol {options.rtol}: no double is that exact; the smallest is {least:.1e}"
        )
    rtol = rtol or said.rtol or RTOL
    step = values.positive("--step", options.step, values.time) or said.step
    until = values.positive("--until", options.until, values.time) or said.until or UNTIL
    every = values.positive("--every", options.every, values.time) or said.every
    show, at = _recorded(options, values, chosen)
    numbers = len(show) + 1
    if not show:
        outputs = named.outputs(compilation).declared
        observed = sum(x.count for x in outputs if not hidden(x.quantity.name))
        numbers = values.coordinates.count + values.rates.count + observed + 2
    if every is None and members is None and at is None:
        every = rows.interval(until, step, numbers)
    count = until / every + 1 if every else 1
    rows.refuse_too_many(options, compilation.declared, chosen, count, numbers, members)
    method = _method(options, said.method, compilation.model.methods)
    # The exact method is chosen only if no tolerance or step size is set.
    free = options.rtol is None and said.rtol is None and step is None
    exact = free and members is None and not options.diagnose
    exact = exact and scene_use.EXACT not in scene_use.switched_off(options.no_reduce)
    return Settings(
        method=method or default_method(compilation.equations, compilation.structure, rtol, exact),
        until=until,
        every=every,
        step=step,
        rtol=rtol,
        atol=values.positive("--atol", options.atol, ""),
        iteration=options.iteration,
        max_steps=_count("--max-steps", options.max_steps),
        max_step=values.positive("--max-step", options.max_step, values.time),
        parameters=single,
        members=of_families,
        inputs=tuple(inputs_set.items()),
        start_q=tuple((s.index, s.value) for s in starts if not s.order),
        start_v=tuple((s.index, s.value) for s in starts if s.order),
        show=show,
        at=at,
        units=options.units,
        watch="none" if getattr(options, "watch", None) == "none" else "",
        diagnose=diagnostics.asked(options.diagnose),
        accuracy=None if _author_chooses(options) else said.accuracy,
        parts=()
        if method
        else tuple(
            PartSettings(
                default_method(compilation.equations, part.structure, rtol, exact), step, rtol
            )
            for part in compilation.parts
        ),
    )


def unread(options: argparse.Namespace, compilation: Compilation) -> str:
    """Returns a message about parameters that are set but that the scene does not read, or ""."""
    values = Values(compilation)
    _, names = values.read([assignment("--set", text) for text in scene_options.numbers(options)])
    if not names:
        return ""
    scene = options.scene
    return f"--set {', '.join(names)}: no effect: nothing that scene '{scene}' needs reads it"


def _author_chooses(options: argparse.Namespace) -> bool:
    """Whether the command line sets a method, a step size or a tolerance."""
    return any(x is not None for x in (options.method, options.step, options.rtol, options.atol))


def _recorded(
    options: argparse.Namespace, values: Values, chosen: Scene | None
) -> tuple[tuple[Shown, ...], int | None]:
    """Returns the columns of rows (empty: all), and the index of the event whose occurrences are
    rows, or None."""
    compilation = values.compilation
    show = at = None
    if chosen is not None and chosen.record is not None:
        at = chosen.record.at or None
    if options.record is not None:
        columns = scene_options.columns_of(options, compilation.declared)
        show = [values.shown(values.flat_name("--record", text.strip())) for text in columns]
        _once("--record", (column.name for column in show))
    elif chosen is not None and chosen.record is not None:
        show = [values.shown(name) for name in scene_model.columns(chosen)]
    if not show and named.with_attitudes(compilation):
        show = values.standard()
    if options.at is not None:
        at = options.at
    events = named.events(compilation)
    if at is not None and at not in events:
        raise UsageError(unknown("--at", at, events, "event"))
    return tuple(show or ()), None if at is None else events.index(at)


def _method(options: argparse.Namespace, of_scene: str, own: tuple[Own, ...]) -> str:
    """Returns the requested method, or "". Raises UsageError for options that do not fit it."""
    methods = known(own)
    if options.method is not None and options.method not in methods:
        raise UsageError(unknown("--method", options.method, methods, "method"))
    name = options.method or of_scene
    if name and "adaptive" not in methods[name].traits:
        inner = "fast" in methods[name].requires  # max_step bounds its inner steps
        for option in ("rtol", "atol", *(() if inner else ("max_step",))):
            if getattr(options, option) is not None:
                shown = "--" + option.replace("_", "-")
                raise UsageError(f"{shown} is for adaptive methods, which {name} is not")
    return name


def threads(options: argparse.Namespace, several: bool) -> int | None:
    """Returns the number of threads of an ensemble; None: all processors."""
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
    """Converts flat indices of parameters to those of the runtime: (index, value) of single ones,
    (index, member, value) of members of families kept as loops."""
    if not compilation.looped:
        return values, ()
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
