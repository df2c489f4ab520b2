"""The time budget of a map, in CPU time, so that other load on the machine does not change the map.

The budget is in seconds on an idle machine. The CPU time of serial work counts in full, that of
parallel work is divided by the number of cores. Some points of the map are timed. Then the number
of points is reduced so that the map fits in the budget. The remaining time is spent on the
predictions.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ...record import record

QUICK, FULL = 12.0, 54.0  # seconds of a quick and a full map, without compiling and drawing
# Serial work must end within the fraction SERIAL of the budget, the rows of the map within ROWS.
SERIAL, ROWS = 0.3, 0.65
PROBES = (0.2, 0.5, 0.9)  # step sizes of timed points, as fractions of the range
# A map keeps at least these numbers of rows and columns; methods are dropped instead.
LEAST_UP, LEAST_ACROSS = 4, 6


@dataclass
class Clock:
    seconds: float
    cores: int
    began: float = field(default_factory=time.process_time)
    serial: float | None = None  # CPU seconds used before threads started

    def threads(self) -> None:
        """Marks the end of serial work: from now on the CPU time counts as that of all cores."""
        self.serial = time.process_time() - self.began

    def left(self, part: float = 1.0) -> float:
        """Returns the seconds until the fraction `part` of the budget is used."""
        used = time.process_time() - self.began
        if self.serial is None:
            return part * self.seconds - used
        return part * self.seconds - self.serial - (used - self.serial) / self.cores


@record
class Cut:
    """The size of a map: the number `up` of values of the varied quantity (rows), the number
    `across` of step sizes (columns), and the methods."""

    up: int
    across: int
    methods: tuple[str, ...]


def cost(point: Callable[[str, float], object], steps: dict[str, tuple[float, ...]], most: float):
    """Returns the mean seconds per point of each method, from up to len(PROBES) points, in about
    `most` seconds."""
    found = {}
    for name, hs in steps.items():
        began, count = time.thread_time(), 0
        for part in PROBES:
            point(name, hs[int(part * (len(hs) - 1))])
            count += 1
            if time.thread_time() - began > most / (2 * len(steps)):
                break
        found[name] = (time.thread_time() - began) / count
    return found


def cut(costs: dict[str, float], up: int, across: int, seconds: float) -> Cut:
    """Returns the map size that fits in `seconds`: drops the costliest methods, then reduces the
    numbers of values and steps."""
    methods = dict(costs)
    least = min(up, LEAST_UP) * min(across, LEAST_ACROSS)
    while len(methods) > 1 and least * sum(methods.values()) > seconds:
        del methods[max(methods, key=lambda name: methods[name])]
    part = math.sqrt(min(1.0, max(seconds, 0.0) / max(up * across * sum(methods.values()), 1e-9)))
    fewer = (max(min(n, low), int(part * n)) for n, low in ((up, LEAST_UP), (across, LEAST_ACROSS)))
    return Cut(*fewer, tuple(methods))


def told(before: Cut, after: Cut, seconds: float) -> list[str]:
    """Describes how the map was reduced, and the option that allows more time."""
    said = []
    if (after.up, after.across) != (before.up, before.across):
        said.append(f"{after.across}x{after.up} points in place of {before.across}x{before.up}")
    gone = [name for name in before.methods if name not in after.methods]
    if gone:
        said.append(f"without {', '.join(gone)}, whose points take longest")
    more = f"; --seconds {10 * seconds:.0f} allows for more"
    return said and [f"to be done in {seconds:.3g} s the map has {' and is '.join(said)}{more}"]


def fewer(values: tuple[float, ...], count: int) -> tuple[float, ...]:
    """Returns `count` elements of `values`, evenly spaced. The last element is among them."""
    n = len(values)
    return tuple(values[round((k + 1) * n / count) - 1] for k in range(count))
