"""The time budget of a map: CPU time, so that other load on the machine changes no map.

Seconds are those of an idle machine: serial work counts in full, parallel work is divided by the
number of cores. Some points are timed; then the number of points is reduced to fit, and the time
left over is for the predictions.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ...record import record

QUICK, FULL = 12.0, 54.0  # seconds; compiling and drawing come on top
SERIAL, ROWS = 0.3, 0.65  # parts of the time by which serial work, and the rows, must end
PROBES = (0.2, 0.5, 0.9)  # timed points: positions in the range of steps
LEAST_UP, LEAST_ACROSS = 4, 6  # least values, step sizes; methods too costly for them are dropped


@dataclass
class Clock:
    seconds: float
    cores: int
    began: float = field(default_factory=time.process_time)
    serial: float | None = None  # CPU seconds used before threads started

    def threads(self) -> None:
        """Marks the start of parallel work."""
        self.serial = time.process_time() - self.began

    def left(self, part: float = 1.0) -> float:
        """Returns the seconds left of a part of the budget."""
        used = time.process_time() - self.began
        if self.serial is None:
            return part * self.seconds - used
        return part * self.seconds - self.serial - (used - self.serial) / self.cores


@record
class Cut:
    """The size of a map: values, step sizes, methods."""

    up: int
    across: int
    methods: tuple[str, ...]


def cost(point: Callable[[str, float], object], steps: dict[str, tuple[float, ...]], most: float):
    """Returns the mean seconds of a point of each method, over PROBES or fewer within `most`
    seconds."""
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
    """Returns what fits in the time: first drops the costliest methods, then reduces values and
    steps."""
    methods = dict(costs)
    least = min(up, LEAST_UP) * min(across, LEAST_ACROSS)
    while len(methods) > 1 and least * sum(methods.values()) > seconds:
        del methods[max(methods, key=lambda name: methods[name])]
    part = math.sqrt(min(1.0, max(seconds, 0.0) / max(up * across * sum(methods.values()), 1e-9)))
    fewer = (max(min(n, low), int(part * n)) for n, low in ((up, LEAST_UP), (across, LEAST_ACROSS)))
    return Cut(*fewer, tuple(methods))


def told(before: Cut, after: Cut, seconds: float) -> list[str]:
    """Describes the reduction, and the option for more."""
    said = []
    if (after.up, after.across) != (before.up, before.across):
        said.append(f"{after.across}x{after.up} points in place of {before.across}x{before.up}")
    gone = [name for name in before.methods if name not in after.methods]
    if gone:
        said.append(f"without {', '.join(gone)}, whose points take longest")
    more = f"; --seconds {10 * seconds:.0f} allows for more"
    return (
        [f"to be done in {seconds:.3g} s the map has {' and is '.join(said)}{more}"] if said else []
    )


def fewer(values: tuple[float, ...], count: int) -> tuple[float, ...]:
    """Returns `count` evenly spaced values, with the last one."""
    n = len(values)
    return tuple(values[round((k + 1) * n / count) - 1] for k in range(count))
