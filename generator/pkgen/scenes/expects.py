"""Converts `expect` statements of a scene to outputs of the model and settings of the runtime.

The runtime checks relations between columns (runtime/run/observers/expect.c). Relations of drift(X)
and time(EVENT), which need the whole motion, are checked after the run (`scenes/judge.py`).
"""

from __future__ import annotations

from collections.abc import Callable

from ..front.check.expects import OF_RUN, calls
from ..middle.quantities import indexed
from ..model import Expect, Scene
from ..run.settings import Compared, Shown, Watched
from ..source import Source, Span
from ..tree import Expr, Name, Number, Prime


def outputs(
    scene: Scene, has: Callable[[str], bool] = lambda _: False
) -> dict[str, tuple[Expr, Span]]:
    """Returns the additional outputs that expectations need, by name. `has(name)` tells whether a
    column exists already."""
    found = {}
    for i, item in enumerate(scene.expects, 1):
        for k, call in enumerate(calls(item, "drift"), 1):
            if not _is_energy(call.arguments[0]):
                found[f"{i}_drift_{k}"] = (call.arguments[0], item.span)
        if not of_run(item):
            for side in ("a", "b", "within"):
                value = getattr(item, side)
                if value is not None and not has(column(value)):
                    found[f"{i}_{side}"] = (value, item.span)
    return found


def columns(scene: Scene) -> frozenset[str]:
    """Returns the names of the columns that expectations compare."""
    sides = (side for item in scene.expects if not of_run(item) for side in (item.a, item.b))
    return frozenset(map(column, sides)) - {""}


def drifting(scene: Scene) -> frozenset[str]:
    """Returns the names of columns whose drift occurs in an expectation."""
    drifts = (call for item in scene.expects for call in calls(item, "drift"))
    return frozenset(column(call.arguments[0]) for call in drifts) - {""}


def column(expr: Expr) -> str:
    """Returns the column that an expression names, such as x, x', q[2], or "" if it names none."""
    if isinstance(expr, Prime):
        of = column(expr.of)
        return of and of + "'"
    if not isinstance(expr, Name) or not isinstance(expr.index, Number | None):
        return ""
    return indexed(expr.id, None if expr.index is None else int(expr.index.value))


def events(scene: Scene) -> frozenset[str]:
    """Returns the events at which a relation is expected, or whose time occurs in a relation."""
    times = (call for item in scene.expects for call in calls(item, "time"))
    names = {item.event for item in scene.expects if item.event}
    return frozenset(names | {call.arguments[0].id for call in times})


def written(source: Source, item: Expect) -> str:
    """Returns the text of an expectation in the model's file, on one line."""
    text = source.written(item.span)
    return f"{text} ({item.component})" if item.component else text


def watched(
    source: Source,
    scene: Scene,
    observed: list[str],
    events: list[str],
    times: tuple[float | None, ...],
    shown: Callable[[str], Shown],
) -> Watched:
    """Returns the settings with which a run checks the scene's expectations. `observed` has the
    names of the outputs and `events` those of the events in the compiled model. `times` has for
    each expectation the time at which it is checked, or None. `shown` returns the column of a name.
    """
    index = {name: k for k, name in enumerate(observed)}
    compared, drifts = [], []

    def side(number: int, name: str, value: Expr) -> Shown:
        own = f"{number}_{name}"
        return shown(own if own in index else column(value))

    for i, item in enumerate(scene.expects, 1):
        for k, call in enumerate(calls(item, "drift"), 1):
            energy = _is_energy(call.arguments[0])
            drifts.append(None if energy else index[f"{i}_drift_{k}"])
        if not of_run(item):
            allowed = None if item.within is None else side(i, "within", item.within)
            event = events.index(item.event) if item.event else None
            sides = side(i, "a", item.a), side(i, "b", item.b), allowed
            text = written(source, item)
            compared.append(Compared(text, item.relation, *sides, times[i - 1], event))
    hidden = tuple(index[name] for name in outputs(scene) if name in index)
    return Watched(tuple(compared), tuple(drifts), hidden)


def of_run(item: Expect) -> bool:
    return any(calls(item, name) for name in OF_RUN)


def _is_energy(expr: Expr) -> bool:
    return isinstance(expr, Name) and expr.id == "energy"
