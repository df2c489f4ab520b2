"""The driver as it measures points of one model (runtime/run/chart.c): a request a line, an
answer a line."""

from __future__ import annotations

import contextlib
import json
import math
import subprocess
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import TracebackType

from ...run.settings import Settings
from ...system import children
from ...system.exits import USAGE, NumericsFailed, UsageError
from ...system.files import scratch
from .points import Method, Point


class Exact(list):
    """A state of more digits than a double's: a fraction for each coordinate, then each rate and
    each first-order variable."""

    coordinates = 0  # how many of the former

    @staticmethod
    def of(state: dict[str, list]) -> Exact:
        pairs = [*state["q"], *state["v"]]
        if any(x is None for pair in pairs for x in pair):
            raise NumericsFailed("a state is not finite")
        exact = Exact(Fraction(high) + Fraction(low) for high, low in pairs)
        exact.coordinates = len(state["q"])
        return exact


def difference(one: Exact, other: Exact, scales: list[float]) -> float:
    """The largest difference of a coordinate or rate, relative to its scale."""
    return max(float(abs(a - b)) / s for a, b, s in zip(one, other, scales, strict=True))


class Program:
    """One model in one precision, with settings that stay; a context manager."""

    mode = "--chart"  # of the driver

    def __init__(self, path: Path, settings: Settings):
        self.path = path
        self.settings = settings

    def __enter__(self) -> Program:
        self._scratch = scratch()
        lines = self._scratch.__enter__() / "settings"
        lines.write_text("\n".join(self.settings.lines()) + "\n", encoding="utf-8")
        self._child = subprocess.Popen(
            [self.path, self.mode, lines],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            **children.group(),
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._child.kill()
        with contextlib.suppress(BrokenPipeError):
            self._child.communicate()
        self._scratch.__exit__(None, None, None)

    def ask(self, *words: object) -> dict:
        assert self._child.stdin is not None and self._child.stdout is not None
        said = [word.hex() if isinstance(word, float) else str(word) for word in words]
        with contextlib.suppress(BrokenPipeError):
            self._child.stdin.write(" ".join(said) + "\n")
            self._child.stdin.flush()
        line = self._child.stdout.readline()
        if not line:
            assert self._child.stderr is not None
            message = self._child.stderr.read().strip()
            code = self._child.wait()
            if code == USAGE:
                raise UsageError(message.removeprefix("run: "))
            raise NumericsFailed(message or f"the driver ended with code {code}")
        return json.loads(line)

    def given(self) -> Settings:
        """The settings with every parameter and start written out, as doubles."""
        found = self.ask("given")
        return replace(
            self.settings,
            parameters=tuple(enumerate(map(float, found["parameters"]))),
            start_q=tuple(enumerate(map(float, found["q"]))),
            start_v=tuple(enumerate(map(float, found["v"]))),
        )

    def point(
        self,
        method: Method,
        setting: float,
        seconds: float,
        cap: float,
        exact: Exact,
        scales: list[float],
    ) -> Point:
        """One integration and laps of it, compared with the exact final state. A step is made a
        whole part of the time to go, as the driver makes it: a run by it is the one measured."""
        if method.fixed:
            setting = self.settings.until / max(
                1, math.ceil(self.settings.until / setting * (1 - 1e-12))
            )
        found = self.ask("point", method.name, setting, seconds, cap)
        error = None
        if found["status"] == "PK_DONE" and not found["slow"]:
            error = difference(Exact.of(found), exact, scales)
        return Point(
            method=method.name,
            setting=setting,
            status=found["status"],
            reason=found["reason"],
            slow=found["slow"],
            t=found["t"],
            error=error,
            seconds=found["seconds"],
            steps=found["steps"],
            rejections=found["rejections"],
            evaluations=found["evaluations"],
            jacobians=found["jacobians"],
            work=found["evaluations"] + len(exact) * found["jacobians"],
            took=found["took"],
            drifts={d["name"]: d["max"] for d in found["drifts"] if d["max"] is not None},
        )
