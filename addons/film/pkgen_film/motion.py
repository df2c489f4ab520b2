"""Integrates a described model, and evaluates its drawing at equidistant times."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy

from pkgen.compiler import Compilation
from pkgen.record import record
from pkgen.run import named
from pkgen.run.library import Run, load
from pkgen.run.settings import NOTHING, Settings, Shown
from pkgen.run.simulate import Outcome, outcome
from pkgen.system import children

FINE = 120.0  # fewest samples per second of the film, for smooth trails


@record(eq=False)
class Motion:
    """A motion. `q`, `v` and `outputs` have a row per sample; the drawing is evaluated from
    `outputs`. Every `fine`-th sample is a frame of the film."""

    t: numpy.ndarray
    q: numpy.ndarray
    v: numpy.ndarray
    outputs: numpy.ndarray
    fine: int
    idle: Run  # a run that evaluates outputs for contours and does not integrate
    outcome: Outcome
    beside: numpy.ndarray | None = None  # shape (samples,): the column that a graph shows

    def number(self, entry: float | dict[str, int]) -> numpy.ndarray:
        """Evaluates a number of the drawing; returns shape (samples,)."""
        if isinstance(entry, dict):
            return self.outputs[:, entry["output"]]
        return numpy.full(len(self.t), float(entry))

    def point(self, entries: list) -> numpy.ndarray:
        """Evaluates a point of the drawing; returns shape (samples, 3)."""
        return numpy.stack([self.number(entry) for entry in entries], axis=1)


def moved(
    compilation: Compilation,
    library: Path,
    settings: Settings,
    frames: int,
    fps: float,
    on_progress: Callable[[float], None] | None = None,
    beside: Shown | None = None,
) -> Motion:
    """Integrates to the end, or until the integration fails: see `outcome`. The first frame is the
    start, the last frame the end."""
    fine = max(1, math.ceil(FINE / fps))
    places = named.coordinates(compilation).columns(10**9)
    rates = named.coordinates(compilation, rates=True).columns(10**9)
    show = [Shown("q", k, c.name) for k, c in enumerate(places)]
    show += [Shown("v", k, c.name) for k, c in enumerate(rates)]
    show += [beside] if beside else []
    every = settings.until / ((frames - 1) * fine)
    own = replace(
        settings, every=every, at=None, show=tuple(show), watched=NOTHING, diagnose=(), parts=()
    )
    with children.stopping() as stopped:

        def poll(part: float) -> bool:
            if on_progress:
                on_progress(part)
            return stopped()

        done = load(library).run(own, poll)
    rows = done.rows()
    of_state = rows[:, 1 : 1 + len(places) + len(rates)]
    t, q, v = rows[:, 0], of_state[:, : len(places)], of_state[:, len(places) :]
    idle: Run = load(library).run(replace(own, every=None, show=()), bare=True, idle=True)
    found: Any = idle.evaluate("outputs", t, q, v) if len(t) else numpy.zeros((0, 0))
    graph = rows[:, -1] if beside else None
    return Motion(t, q, v, found, fine, idle, outcome(compilation, settings, done), graph)
