"""Measures points of a model in this process: runs of a method at one setting, and their time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from ...methods import Own, known
from ...run.library import Run, load
from ...run.settings import Settings, Shown
from ...system.exits import USAGE, UsageError
from .errors import Measure
from .points import ChartedMethod, Point
from .rows import rows_of
from .scale import divided

AS_REPORTED = ("status", "slow", "t", "steps", "rejections", "evaluations", "jacobians")

# The signature of Program.point, which methods of other packages implement too.
Measured = Callable[[ChartedMethod, float, float, float, Measure], Point]


class Program:
    """The library of a model, compiled with one scalar type, and the settings of all its runs."""

    def __init__(self, path: Path, settings: Settings, own: tuple[Own, ...] = ()):
        self.known = known(own)
        self.library = load(path)
        self.settings = settings
        self.peers: dict[str, Measured] = {}  # replaces point(), by method of another package

    def run(self, method: str, setting: float, **more: object) -> Run:
        """Runs a method at a step or rtol. Raises UsageError for wrong settings."""
        fixed = self.known[method].fixed or self.known[method].exact
        given = replace(self.settings, method=method, **more.pop("but", {}))
        if fixed:
            given = replace(given, step=setting)
        else:
            given = replace(given, step=None, rtol=setting, atol=None)
        done = self.library.run(given, **more)
        if done.code == USAGE and not done.report:
            raise UsageError(done.messages.strip())
        return done

    @cached_property
    def start(self) -> dict[str, list[float]]:
        """Returns the parameters and the initial state, as the runtime reads them."""
        return self.run("rk4", self.settings.until, bare=1).given()

    def given(self) -> Settings:
        """Returns settings that contain every parameter and initial value, as doubles."""
        found = self.start
        numbers = map(float, found["parameters"])
        lengths = [int(n) for n in found["families"]]  # lengths of families; 0: not a family
        given = [[(i, k, next(numbers)) for k in range(max(n, 1))] for i, n in enumerate(lengths)]
        return replace(
            self.settings,
            parameters=tuple((i, x) for [(i, _, x), *_] in given if not lengths[i]),
            members=tuple(x for of in given for x in of if lengths[x[0]]),
            start_q=tuple(enumerate(map(float, found["q"]))),
            start_v=tuple(enumerate(map(float, found["v"]))),
        )

    @cached_property
    def state(self) -> tuple[Shown, ...]:
        """Returns the columns of coordinates, rates and first-order variables."""
        kinds = (("q", self.start["q"]), ("v", self.start["v"]))
        return tuple(Shown(kind, i, "") for kind, xs in kinds for i in range(len(xs)))

    def path(self, method: str, tolerance: float, count: int, cap: float) -> Run:
        """Runs an adaptive method. The run divides its duration into `count` equal intervals and
        writes the state, a row of output, at the end of each."""
        until = self.settings.until
        but = {"every": until / count, "show": self.state, "rows": "land"}
        return self.run(method, tolerance, but=but, bare=1, cap=cap)

    def point(
        self, method: ChartedMethod, setting: float, seconds: float, cap: float, measure: Measure
    ) -> Point:
        """Measures the error of one integration against the reference, and its time by repetitions.
        A step size is reduced to divide the duration, as in a run."""
        if method.name in self.peers:
            return self.peers[method.name](method, setting, seconds, cap, measure)
        until = self.settings.until
        if method.fixed:
            setting = divided(until, setting)
        began = time.process_time()
        but = {"every": None, "show": self.state}
        done = self.run(method.name, setting, but=but, bare=1, cap=cap)
        error = fastest = None
        if self._arrived(done):
            seen = done
            if measure.kind.path:
                every = until / (len(measure.exact.t) - 1)
                but = {"every": every, "show": self.state, "rows": "dense"}
                seen = self.run(method.name, setting, but=but, bare=1, cap=cap)
            if self._arrived(seen):
                error = measure.of(rows_of(seen), seen.report)
                fastest = done.laps(seconds)
            else:  # the run with output rows failed: the point describes this run
                done = seen
        found = done.report
        return Point(
            method=method.name,
            setting=setting,
            reason=found["reason"] if found["status"] != "PK_DONE" else "",
            error=error,
            seconds=fastest,
            work=found["evaluations"] + len(self.state) * found["jacobians"],
            took=time.process_time() - began,
            drifts={d["name"]: d["max"] for d in found["drifts"] if d["max"] is not None},
            **{name: found[name] for name in AS_REPORTED},
        )

    @staticmethod
    def _arrived(done: Run) -> bool:
        return done.report["status"] == "PK_DONE" and not done.report["slow"]
