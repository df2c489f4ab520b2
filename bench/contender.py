"""What takes part: something that integrates a model to its end and says how long it took.

A contender written in C is a program of its own around c/harness.c, kept running and asked by
lines, so that every one has its own compiler and flags and all can take turns; it times itself.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from .builds import Broken, Build, each_build
from .models import Model

# Relative tolerance, the absolute one the same, from loose to what double precision allows.
TOLERANCES = tuple(10.0**-k for k in range(2, 15))
COARSE_TOLERANCES = tuple(10.0**-k for k in range(3, 14, 2))
# Steps as fractions of the time to the end, for methods of fixed step.
HALVINGS = tuple(0.5**k for k in range(6, 19))


class Failed(Exception):
    """An integration that did not reach its end."""


class Inapplicable(Failed):
    """One that the method says it is not for."""


class Session(Protocol):
    """A contender that is ready: compiled, warm, with one model."""

    flags: str

    def integrate(
        self, setting: float, y0: Sequence[float], t_end: float, seconds: float
    ) -> tuple[float, list[float]]:
        """Seconds of one integration, and the final state: q, then q'."""

    def close(self) -> None: ...


@dataclass(frozen=True)
class Contender:
    """`open` gives the sessions to choose from: the fastest build is what takes part."""

    name: str
    group: str  # "pkgen", "C" or "Python"
    fixed_step: bool
    open: Callable[[Model, tuple[Build, ...]], list[Session]]
    ladder: tuple[float, ...] = TOLERANCES
    slow: bool = False  # measured once a round, whatever the time asked for

    def settings(self, model: Model) -> list[float]:
        return [x * model.t_end for x in self.ladder] if self.fixed_step else list(self.ladder)


class Program:
    """A session with a program around c/harness.c."""

    def __init__(self, program: Path, arguments: Sequence[str], flags: str):
        command = [str(program), *arguments]
        self.flags = flags
        self._child = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        answer = self._child.stdout.readline().strip()
        if answer != "ready":
            self.close()
            raise Broken(answer.removeprefix("failed ") or "the program does not start")

    def integrate(self, setting, y0, t_end, seconds):
        numbers = (setting, t_end, seconds, *y0)
        self._child.stdin.write(" ".join(float(x).hex() for x in numbers) + "\n")
        self._child.stdin.flush()
        answer = self._child.stdout.readline().split()
        if not answer:
            raise Failed("the program ended")
        if answer[:2] == ["failed", "refused:"]:
            raise Inapplicable(" ".join(answer[2:]))
        if answer[0] == "failed":
            raise Failed(" ".join(answer[1:]))
        return float(answer[0]), [float(x) for x in answer[1:]]

    def close(self) -> None:
        self._child.stdin.close()
        self._child.wait()
        self._child.stdout.close()


def programs(
    builds: Sequence[Build],
    make: Callable[[Build], Path],
    arguments: Sequence[str] = (),
    note: str = "",
) -> list[Program]:
    """A session for each build; `note` is said with its flags."""
    paths = each_build(tuple(builds), make)
    return [
        Program(path, arguments, f"{build}{note}")
        for path, build in zip(paths, builds, strict=True)
    ]


class Callback:
    """A session with a function of this process: `run(setting, y0, t_end)` gives a final state
    and the seconds that it took."""

    def __init__(self, run: Callable, flags: str):
        self.flags = flags
        self._run = run

    def integrate(self, setting, y0, t_end, seconds):
        total, runs = 0.0, 0
        while total < seconds or not runs:
            took, state = self._run(setting, y0, t_end)
            total += took
            runs += 1
        return total / runs, [float(x) for x in state]

    def close(self) -> None:
        pass
