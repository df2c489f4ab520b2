"""Measures integrators of other packages for the same motion, with the same reference solution and
the same error norm as pkgen's methods.

For each package, as for pkgen, the cheapest method that reaches a given accuracy is sought; the
cost is the CPU time only. The best results of pkgen and of the packages are then timed once more,
in turns.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy

from pkgen.analysis.chart import answer, sweep
from pkgen.analysis.chart.answer import Answer, Beside
from pkgen.analysis.chart.errors import Measure
from pkgen.analysis.chart.measure import Program
from pkgen.analysis.chart.points import FOREIGN, ChartedMethod, Point, Track
from pkgen.analysis.chart.rows import Rows
from pkgen.analysis.chart.spectrum import Spectrum
from pkgen.analysis.chart.sweep import Bench, Effort
from pkgen.compiler import Compilation
from pkgen.record import record
from pkgen.system import children
from pkgen.system.progress import Show

from .peers import Integrate, Motion, Peer, Refused, Slow, gsl_methods

# Seconds for measuring all packages, relative to the seconds planned for the whole chart.
SHARE = 0.5
LAP = 1e-3  # Shortest timed repetition in seconds.
# Runs are timed again in ROUNDS rounds, if they take less than LONGEST seconds. MOST is the time
# limit of such a run, relative to LONGEST.
ROUNDS, LONGEST, MOST = 3, 0.3, 30


class Opened:
    """A method of a package, applied to one motion; point() is like Program.point."""

    def __init__(self, peer: Peer, name: str, motion: Motion):
        self.motion = motion
        self.integrate: Integrate = peer.open(motion, name)

    def point(
        self, method: ChartedMethod, setting: float, seconds: float, cap: float, measure: Measure
    ) -> Point:
        motion, error, fastest, slow, reason = self.motion, None, None, False, ""
        times = measure.exact.t.tolist() if measure.kind.path else []
        began = time.process_time()
        motion.late = began + cap
        try:
            with _quiet():
                states = self.integrate(setting, times)
                error = measure.of(_rows(states, times), {})
                motion.late = math.inf
                fastest = self._laps(setting, seconds)
        except Slow:
            slow = True
        except Exception as failure:  # any exception of a package counts as a failed run
            reason = str(failure) or type(failure).__name__
        done = fastest is not None
        return Point(
            method=method.name,
            setting=setting,
            status="PK_DONE" if done else "PK_STOPPED" if slow else "failed",
            reason=reason,
            slow=slow,
            t=motion.until if done else 0.0,
            error=error if done else None,
            seconds=fastest,
            steps=None,
            rejections=None,
            evaluations=motion.count or None,
            jacobians=None,
            work=motion.count or None,
            took=time.process_time() - began,
        )

    def _laps(self, setting: float, seconds: float) -> float:
        """Returns the fastest CPU time of a run, from repetitions for at least `seconds`."""
        best, total, block = math.inf, 0.0, 1
        while best == math.inf or total < seconds:
            began = time.process_time()
            for _ in range(block):
                self.motion.count = 0
                self.integrate(setting, ())
            took = time.process_time() - began
            total += took
            if took < LAP:
                block *= 2
            else:
                best = min(best, took / block)
        return best


def _rows(states: Any, times: Sequence[float]) -> Rows:
    x = numpy.array(states if times else states[-1:], dtype=float)
    return Rows(numpy.array(times), x, numpy.zeros_like(x))


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppresses warnings, and the standard output of compiled code."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def attach_peers(
    peers: Sequence[Peer], compilation: Compilation, starts: list[tuple[Program, Measure]]
) -> dict[str, str]:
    """Adds the methods of other packages to each program of the chart. Returns the reasons of those
    packages that cannot integrate this model."""
    refused: dict[str, str] = {}
    e = compilation.equations
    jolts = [x.name for x in e.impulsive]
    for peer in (p for p in peers if p.open):
        try:
            if jolts:
                raise Refused(f"rates jump where {jolts[0]} is zero, which it does not locate")
            if compilation.declared.samples:
                raise Refused("it runs no sample block: leave it out, the methods of pkgen do")
            for program, measure in starts:
                motion = Motion(compilation, program, measure.scales)
                for method, name in zip(peer.charted(), peer.methods, strict=True):
                    program.peers[method.name] = Opened(peer, name, motion).point
        except Refused as why:
            refused[peer.name] = str(why)
    return refused


@record
class Against:
    """The chosen packages, with the interface that `analysis/chart/chart.py` calls."""

    peers: tuple[Peer, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(peer.name for peer in self.peers)

    @property
    def methods(self) -> list[str]:
        """Methods of other packages that the runtime contains (GSL), if they are chosen."""
        return gsl_methods() if any(peer.open is None for peer in self.peers) else []

    def measure(
        self,
        bench: Bench,
        compilation: Compilation,
        spectrum: Spectrum,
        own: list[Answer],
        tracks: list[Track],
        on_progress: Show,
    ) -> tuple[tuple[Beside, ...], list[Answer], list[Track]]:
        """Returns the cheapest methods of the packages; those of pkgen, timed again in turns with
        them; and the points of all methods in the chart."""
        refused = attach_peers(self.peers, compilation, bench.starts)
        able = [p for p in self.peers if p.name not in refused]
        part = SHARE * bench.effort.seconds / max(1, sum(p.open is not None for p in able))
        found: list[Beside] = [
            _beside(p, why=refused[p.name]) for p in self.peers if p.name in refused
        ]
        for k, peer in enumerate(able):
            on_progress(k / len(able), peer.name)
            effort = Effort(bench.effort.points, bench.effort.lap_seconds, part)
            bench = replace(bench, effort=effort)
            if peer.open is None:
                swept = [t for t in tracks if t.method.family == FOREIGN]
            else:
                swept = sweep.measure(bench, peer.charted(), spectrum, lambda _: None)
            told, swept = answer.answers(bench, swept)
            found.append(_beside(peer, tuple(a for a in told if a.axis == "seconds")))
            if children.ended():
                raise KeyboardInterrupt
            names = {t.method.name for t in swept}
            tracks = [*(t for t in tracks if t.method.name not in names), *swept]
        told = {(a.method.name, a.point.setting): a for b in found for a in b.answers if a.point}
        told |= {
            (a.method.name, a.point.setting): a for a in own if a.point and a.axis == "seconds"
        }
        times = _in_turns(bench, list(told.values()))

        def timed(p: Point | None) -> Point | None:
            if p is None or (p.method, p.setting) not in times:
                return p
            return replace(p, seconds=times[p.method, p.setting])

        def again(answers: Sequence[Answer]) -> list[Answer]:
            return [replace(a, point=timed(a.point)) for a in answers]

        tracks = [replace(t, points=tuple(timed(p) for p in t.points)) for t in tracks]
        beside = tuple(replace(b, answers=tuple(again(b.answers))) for b in found)
        return beside, again(own), tracks


def _beside(peer: Peer, answers: tuple[Answer, ...] = (), why: str = "") -> Beside:
    return Beside(peer.name, peer.version, peer.takes, answers, why)


def _in_turns(bench: Bench, answers: list[Answer]) -> dict[tuple[str, float], float]:
    times: dict[tuple[str, float], float] = {}
    for _ in range(ROUNDS):
        for a in answers:
            least = times.get((a.method.name, a.point.setting), a.point.seconds)
            if a.point.seconds < LONGEST:
                again = bench.point(a.method, a.point.setting, cap=MOST * LONGEST)
                least = min(least, again.seconds or math.inf)
            times[a.method.name, a.point.setting] = least
    return times
