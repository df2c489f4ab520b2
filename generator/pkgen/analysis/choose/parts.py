"""Makes the choice for a scene, or for each block of coordinates that is integrated separately."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace

from ...compiler import Compilation, CompiledPart
from ...run import named
from ...run.ensemble import Ensemble
from ...run.named import columns
from ...run.settings import Settings, Shown
from ...run.values import Values
from .choice import Choice
from .prepared import Prepared
from .sample import of_members


def chosen(
    compilation: Compilation, settings: Settings, ensemble: Ensemble | None
) -> tuple[Choice, ...]:
    """Returns the choice for a scene, or one for each block."""
    if compilation.parts:
        return tuple(_of_part(compilation, part, settings) for part in compilation.parts)
    return (_of_all(compilation, settings, ensemble),)


def with_choices(given: Settings, choices: Sequence[Choice]) -> Settings:
    """Returns the settings of the run according to the choices."""
    if len(choices) < 2:
        return choices[0].settings(given) if choices else given
    return replace(given, method=choices[0].method, parts=tuple(c.of_part() for c in choices))


def _of_all(compilation: Compilation, settings: Settings, ensemble: Ensemble | None) -> Choice:
    system = compilation.files, compilation.model.name, compilation.structure
    events = bool(named.events(compilation))
    prepared = Prepared.of(*system, land=ensemble is not None, events=events)
    settings = _with_expected(compilation, settings)
    if ensemble is None:
        found = prepared.choose(settings, settings.accuracy)
        found = replace(found, compiled_for=prepared.methods)
    else:
        found = of_members(prepared, settings, ensemble)
    left_out = _named(compilation, settings, found.check.ignored)
    unsure = _named(compilation, settings, found.check.unsure)
    return replace(found, left_out=left_out, unsure=unsure)


def _named(compilation: Compilation, settings: Settings, which: Sequence[int]) -> tuple[str, ...]:
    names = [c.name for c in settings.show or columns(compilation)[1:]]
    return tuple(dict.fromkeys(names[i] for i in which))


def _with_expected(compilation: Compilation, settings: Settings) -> Settings:
    """Returns settings that also show the quantities of expectations, as the last columns."""
    expected, shown = settings.watched.columns(), settings.show
    if not expected:
        return settings
    if not shown:  # all columns that rows can have, also every member of a large family
        named_as = Values(compilation).shown
        shown = [named_as(c.name) for c in columns(compilation, listed=sys.maxsize)[1:]]
    return replace(settings, show=(*shown, *expected))


def _of_part(compilation: Compilation, part: CompiledPart, settings: Settings) -> Choice:
    """Returns the choice for a block of coordinates. Trials run the block alone, and are judged by
    those recorded columns that belong to it. Steps of trials must end at the times of rows."""
    prepared = Prepared.of(compilation.files, part.name, part.structure, land=True)
    found = prepared.choose(alone(part, settings), settings.accuracy)
    return replace(found, of=tuple(q.name for q in part.equations.coordinates))


def alone(part: CompiledPart, settings: Settings) -> Settings:
    """Returns the settings of a run of the block alone: indices of coordinates in the model become
    indices in the block. Indices of parameters are the same in both."""
    place = {whole: k for k, whole in enumerate(part.coordinates)}

    def mine(starts: tuple[tuple[int, float], ...]) -> tuple[tuple[int, float], ...]:
        return tuple((place[i], x) for i, x in starts if i in place)

    show = [
        Shown(column.kind, place[column.index], column.name)
        for column in settings.show
        if column.kind in "qv" and column.index in place
    ]
    starts = {"start_q": mine(settings.start_q), "start_v": mine(settings.start_v)}
    return replace(settings, **starts, show=tuple(show), parts=())
