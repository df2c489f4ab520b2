"""Ways to do the same work, taking turns; of each the fastest build counts."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Runner:
    """One build of one way; `run` gives nanoseconds of the unit of work, and what it came to."""

    title: str
    flags: str
    run: Callable[[], tuple[float, list]]
    kind: str = ""


@dataclass(frozen=True)
class Timing:
    title: str
    flags: str
    rounds: list[float]
    result: list

    @property
    def median(self) -> float:
        return statistics.median(self.rounds)


def take_turns(runners: list[Runner], rounds: int, check: Callable[[Runner, list], None]):
    """Timings by title; `check` sees each result once and stops the bench if it is wrong."""
    times: dict[Runner, list[float]] = {r: [] for r in runners}
    results = {}
    for number in range(rounds):
        for runner in runners:
            nanoseconds, result = runner.run()
            times[runner].append(nanoseconds)
            if not number:
                check(runner, result)
                results[runner] = result
    best: dict[str, Timing] = {}
    for runner, taken in times.items():
        timing = Timing(runner.title, runner.flags, taken, results[runner])
        if runner.title not in best or timing.median < best[runner.title].median:
            best[runner.title] = timing
    return best
