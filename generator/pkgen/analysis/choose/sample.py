"""Makes the choice for an ensemble or a swarm from a few members, each tried as a separate run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ...run.ensemble import Ensemble
from ...run.settings import Settings
from ...system.exits import UsageError
from .choice import Choice
from .prepared import Prepared

MOST = 5  # most members that are tried
SPARE = 0.3  # tried members keep SPARE times the accuracy, as errors of other members may be larger
# For each kind of column in a table of members: the field of Settings that has its value.
FIELDS = {"p": "parameters", "i": "inputs", "q": "start_q", "v": "start_v"}


def of_members(prepared: Prepared, settings: Settings, ensemble: Ensemble) -> Choice:
    """Returns the method of the member that takes longest, at the tightest setting of all tried
    members, with a margin for other members."""
    # If no time between rows is set, a member has two rows, start and end, and so must its trials.
    settings = replace(settings, every=settings.every or settings.until)
    accuracy = SPARE * settings.accuracy
    pairs = _tried(prepared, settings, ensemble, accuracy)
    tried = [c for _, c in pairs]
    longest = max(tried, key=lambda c: c.run_seconds)
    only = prepared.only(longest.method)
    same = [c if c.method == longest.method else only.choose(one, accuracy) for one, c in pairs]
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
        sampled=len(pairs),
    )


def _tried(
    prepared: Prepared, settings: Settings, ensemble: Ensemble, accuracy: float
) -> list[tuple[Settings, Choice]]:
    """Returns the tried members and their choices. A member that is refused, such as one out of
    bounds, is replaced by another. Raises UsageError if all are refused."""
    pairs: list[tuple[Settings, Choice]] = []
    refused: UsageError | None = None
    for one in members(settings, ensemble):
        try:
            pairs.append((one, prepared.choose(one, accuracy)))
        except UsageError as error:
            refused = refused or error
        if len(pairs) == MOST:
            break
    if refused and not pairs:
        raise refused
    return pairs


def members(settings: Settings, ensemble: Ensemble) -> Iterator[Settings]:
    """Yields the settings of all members, starting with evenly spaced members."""
    count = len(ensemble.lines)
    share = max(1, min(MOST, count) - 1)
    which = sorted({round(k * (count - 1) / share) for k in range(min(MOST, count))})
    width = len(ensemble.columns)
    flat = memoryview(ensemble.values).cast("B").cast("d") if width else []
    for k in (*which, *(k for k in range(count) if k not in which)):
        yield _one(settings, ensemble, flat[k * width : (k + 1) * width])


def _one(settings: Settings, ensemble: Ensemble, row: Sequence[float]) -> Settings:
    given: dict[str, tuple] = {}
    for column, x in zip(ensemble.columns, row, strict=True):
        field = FIELDS[column.kind[0]]
        before = given.get(field, getattr(settings, field))
        given[field] = (*before, (column.index, float(x)))
    return replace(settings, **given)
