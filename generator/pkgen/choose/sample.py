"""Members of an ensemble or a swarm, each as the settings of a run of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..ensemble import Ensemble
from ..simulate import Settings

MOST = 5  # members that are tried
SPARE = 0.3  # of the accuracy, that they keep: others may need more
# The settings that a kind of column is in.
FIELDS = {"p": "parameters", "i": "inputs", "q": "start_q", "v": "start_v"}


def members(settings: Settings, ensemble: Ensemble) -> list[Settings]:
    """From the first to the last, evenly."""
    count = len(ensemble.lines)
    share = max(1, min(MOST, count) - 1)
    which = sorted({round(k * (count - 1) / share) for k in range(min(MOST, count))})
    width = len(ensemble.columns)
    flat = memoryview(ensemble.values).cast("B").cast("d") if width else []
    return [_one(settings, ensemble, flat[k * width : (k + 1) * width]) for k in which]


def _one(settings: Settings, ensemble: Ensemble, row: Sequence[float]) -> Settings:
    given: dict[str, tuple] = {}
    for column, x in zip(ensemble.columns, row, strict=True):
        field = FIELDS[column.kind[0]]
        before = given.get(field, getattr(settings, field))
        given[field] = (*before, (column.index, float(x)))
    return replace(settings, **given)
