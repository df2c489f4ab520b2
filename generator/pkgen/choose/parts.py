"""A choice for each block of coordinates that is integrated apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..build import build_program
from ..chart.chart import methods as all_methods
from ..compiler import Compilation, CompiledPart
from ..ensemble import Ensemble
from ..expects import NOTHING
from ..simulate import PartSettings, Settings, Shown
from .candidates import candidates
from .choose import Choice, choose, for_scene
from .trials import LAND


def chosen(
    compilation: Compilation, settings: Settings, ensemble: Ensemble | None
) -> tuple[Choice, ...]:
    """The choice for a scene, one for each part, or none where nothing is promised."""
    if settings.accuracy is not None and compilation.parts:
        return tuple(_of_part(compilation, part, settings) for part in compilation.parts)
    one = for_scene(compilation, settings, ensemble)
    return () if one is None else (one,)


def with_choices(given: Settings, choices: Sequence[Choice]) -> Settings:
    """The settings of what is run."""
    if len(choices) < 2:
        return choices[0].settings(given) if choices else given
    parts = []
    for choice in choices:
        atol = choice.check.small * choice.setting
        step = choice.setting if choice.fixed else None
        parts.append(PartSettings(choice.method, step, choice.setting, atol))
    return replace(given, method=choices[0].method, parts=tuple(parts))


def _of_part(compilation: Compilation, part: CompiledPart, settings: Settings) -> Choice:
    """By trials of the part alone, of what is recorded of it; parts land on rows."""
    able = [c for c in candidates(part.structure, all_methods(None)) if c.rows == LAND]
    names = dict.fromkeys(c.name for c in able)
    program = build_program(compilation.files, part.name, *names)
    found = choose(
        program, _alone(compilation, part, settings), part.structure, able, settings.accuracy
    )
    return replace(found, of=tuple(q.name for q in part.equations.coordinates))


def _alone(compilation: Compilation, part: CompiledPart, settings: Settings) -> Settings:
    """The settings by the part's own numbers of coordinates; parameters have those of the whole."""
    place = {whole: k for k, whole in enumerate(part.coordinates)}

    def mine(starts: tuple[tuple[int, float], ...]) -> tuple[tuple[int, float], ...]:
        return tuple((place[i], x) for i, x in starts if i in place)

    angles = [q.name for q in part.equations.quadrature_names]
    show = []
    for column in settings.show:
        if column.kind in "qv" and column.index in place:
            show.append(Shown(column.kind, place[column.index], column.name))
        elif column.kind == "z" and column.name in angles:
            show.append(Shown("z", angles.index(column.name), column.name))
    if not show:  # something is expected of it, and nothing recorded
        show = [Shown("q", k, q.name) for k, q in enumerate(part.equations.coordinates)]
    return replace(
        settings,
        start_q=mine(settings.start_q),
        start_v=mine(settings.start_v),
        show=tuple(show),
        watched=NOTHING,
        parts=(),
    )
