"""The number of rows that a run writes: the default, the limit, and messages about them."""

from __future__ import annotations

import argparse
import math

from ..compiler import Compilation
from ..front.check.scene_numbers import too_much
from ..model import Model, Scene
from ..system.exits import UsageError
from . import named
from .settings import Settings

ROWS = 1000
NUMBERS = 10_000_000  # most numbers in all rows without --every: 200 MB of CSV


def interval(until: float, step: float | None, numbers: int, most: int = ROWS) -> float:
    """Returns the default time between rows, for `most` rows, or fewer if a row has many `numbers`.
    With a fixed step size it is a multiple of the step."""
    rows = max(1, min(most, NUMBERS // numbers))
    return step * math.ceil(until / (rows * step)) if step else until / rows


def refuse_too_many(
    options: argparse.Namespace,
    model: Model,
    scene: Scene | None,
    rows: float,
    numbers: int,
    members: int | None,
) -> None:
    """Raises UsageError if a run would write more rows than a disk may hold. `members` is the
    number of members of an ensemble."""
    said = too_much(rows, numbers, members)
    if not said:
        return
    if options.every is not None:
        what, advice = f"--every {options.every}", "take a longer interval"
    elif options.ensemble is not None:
        what, advice = f"--ensemble {options.ensemble}", "take fewer members"
    elif scene is not None and scene.swarm is not None:
        what = f"{model.source.place(scene.swarm.span)}: scene '{scene.name}'"
        advice = "take fewer members"
    elif scene is not None and scene.record is not None and scene.record.every is not None:
        what = f"{model.source.place(scene.record.span)}: scene '{scene.name}'"
        advice = "take a longer interval"
    else:
        what, advice = "--size", "take smaller families"
    raise UsageError(f"{what}: {said}; {advice}")


def note(settings: Settings, compilation: Compilation) -> str:
    """Returns a note if long rows reduced the default number of rows, else ""."""
    numbers = sum(named.coordinates(compilation, rates=rates).count for rates in (False, True))
    given = compilation.plan.numbers.every
    if settings.every is None or given is not None or numbers * ROWS <= NUMBERS:
        return ""
    rows = math.ceil(settings.until / settings.every) + 1
    return (
        f"{rows} rows of {numbers:,} numbers, one every {settings.every:.6g}; "
        "choose by --every how often, and how much, is written"
    )
