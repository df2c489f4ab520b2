"""An ensemble or a swarm: a few of its members are tried, each as a run of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...run.ensemble import Ensemble
from ...run.settings import Settings
from .choice import Choice
from .prepared import Prepared

MOST = 5  # members that are tried
SPARE = 0.3  # of the accuracy, that they keep: others may need more
# The settings that a kind of column is in.
FIELDS = {"p": "parameters", "i": "inputs", "q": "start_q", "v": "start_v"}


def of_members(prepared: Prepared, settings: Settings, ensemble: Ensemble) -> Choice:
    """The method of the member that takes longest, at the tightest setting that any of them needs,
    with some to spare for those that were not tried."""
    # Without an interval members have two rows, and so have their trials.
    settings = replace(settings, every=settings.every or settings.until)
    some = members(settings, ensemble)
    accuracy = SPARE * settings.accuracy
    tried = [prepared.choose(one, accuracy) for one in some]
    longest = max(tried, key=lambda c: c.run_seconds)
    only = prepared.only(longest.method)
    same = [
        c if c.method == longest.method else only.choose(one, accuracy)
        for one, c in zip(some, tried, strict=True)
    ]
    bounds = [c.max_step for c in same if c.max_step is not None]
    horizons = [c.horizon for c in same if c.horizon is not None]
    again = [c for c in same if c not in tried]
    return replace(
        longest,
        accuracy=settings.accuracy,
        setting=min(c.setting for c in same),
        max_step=min(bounds, default=None),
        expected=max(c.expected for c in same),
        horizon=min(horizons, default=None),
        seconds=sum(c.seconds for c in (*tried, *again)),
        sampled=len(some),
    )


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
