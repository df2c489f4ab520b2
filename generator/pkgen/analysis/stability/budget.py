"""What a map may take: time of the processor, so that what else the machine does changes no map.

They are seconds that pass on an idle machine: what is done one after the other counts whole, what
threads do together by their number. A probe of some points tells what all of them would take; then
fewer are asked for, and what is left over for predictions is theirs.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ...record import record

QUICK, FULL = 12.0, 54.0  # seconds; compiling and drawing come on top
SERIAL, ROWS = 0.3, 0.65  # parts of it by the end of which what is serial is done, and the rows
PROBES = (0.2, 0.5, 0.9)  # of the steps of a map
LEAST_UP, LEAST_ACROSS = 4, 6  # values and steps: a method that is too dear for these is left out


@dataclass
class Clock:
    seconds: float
    cores: int
    began: float = field(default_factory=time.process_time)
    serial: float | None = None  # what was used up before threads began

    def threads(self) -> None:
        """They begin."""
        self.serial = time.process_time() - self.began

    def left(self, part: float = 1.0) -> float:
        """Of a part of the time."""
        used = time.process_time() - self.began
        if self.serial is None:
            return part * self.seconds - used
        return part * self.seconds - self.serial - (used - self.serial) / self.cores


@record
class Cut:
    """How much is asked for."""

    up: int
    across: int
    methods: tuple[str, ...]


def cost(point: Callable[[str, float], object], steps: dict[str, tuple[float, ...]], most: float):
    """Seconds of a point of each method, the mean of PROBES, or of fewer where these take more."""
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
    """What fits: fewer methods, the dearest first, if need be; then fewer values and steps."""
    methods = dict(costs)
    least = min(up, LEAST_UP) * min(across, LEAST_ACROSS)
    while len(methods) > 1 and least * sum(methods.values()) > seconds:
        del methods[max(methods, key=lambda name: methods[name])]
    part = math.sqrt(min(1.0, max(seconds, 0.0) / max(up * across * sum(methods.values()), 1e-9)))
    fewer = (max(min(n, low), int(part * n)) for n, low in ((up, LEAST_UP), (across, LEAST_ACROSS)))
    return Cut(*fewer, tuple(methods))


def told(before: Cut, after: Cut, seconds: float) -> list[str]:
    """What was reduced, and how to ask for more."""
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
    """So many of them, evenly, the last among them."""
    n = len(values)
    return tuple(values[round((k + 1) * n / count) - 1] for k in range(count))
