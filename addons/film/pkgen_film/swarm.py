"""Draws a swarm as a cloud of points in the plane of a coordinate and its rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy

from pkgen.compiler import Compilation
from pkgen.plot.names import label
from pkgen.plot.style import BLUE, GREY
from pkgen.record import record
from pkgen.run import named
from pkgen.run.ensemble import Ensemble
from pkgen.run.library import load
from pkgen.run.settings import NOTHING, Settings, Shown
from pkgen.run.simulate import Outcome, outcome
from pkgen.system import children
from pkgen.system.exits import UsageError

from .raster import Label
from .tracks import Track

# Most members of a swarm that are drawn, in raster and in vector formats.
MOST, MOST_OF_VECTORS = 4000, 150
# Left, lower, right and upper end of the axes, as fractions of the picture.
EDGE = (0.09, 0.12, 0.97, 0.87)
TICKS = 6


@record(eq=False)
class Cloud:
    """The drawn members of a swarm. `t` has a time per frame; `places`, of shape (frames, members,
    2), has the coordinate and the rate of each member."""

    t: numpy.ndarray
    places: numpy.ndarray
    names: tuple[str, str]
    outcome: Outcome


def moved(
    compilation: Compilation,
    library: Path,
    settings: Settings,
    ensemble: Ensemble,
    frames: int,
    most: int,
    on_progress: Callable[[float], None],
) -> Cloud:
    """Integrates an evenly spaced selection of the members, at most `most`."""
    if not named.coordinates(compilation).count:
        raise UsageError("the scene leaves no coordinate to show")
    q, v = (next(iter(_columns(compilation, rates=rates))) for rates in (False, True))
    every = settings.until / (frames - 1)
    show = (Shown("q", 0, q.name), Shown("v", 0, v.name))
    own = replace(settings, every=every, at=None, show=show, watched=NOTHING, watch="", diagnose=())
    part = -(-len(ensemble.lines) // most)
    values = numpy.reshape(ensemble.values, (-1, len(ensemble.columns)))[::part]
    few = replace(
        ensemble, lines=ensemble.lines[::part], values=numpy.ascontiguousarray(values, float)
    )
    with children.stopping() as stopped:

        def poll(part: float) -> bool:
            on_progress(part)
            return stopped()

        done = load(library).run(own, poll, few)
    rows = done.rows()
    made = numpy.full((frames, len(few.lines), 2), numpy.nan)
    at = numpy.rint(rows[:, 1] / every).astype(int)
    # Index of the member, counted from the first drawn one.
    member = (rows[:, 0] - few.lines[0]).astype(int)
    good = (at < frames) & (member < len(few.lines))
    made[at[good], member[good]] = rows[good, 2:4]
    names = label(q.name, q.unit), label(v.name, v.unit)
    told = outcome(compilation, own, done, few)
    return Cloud(numpy.arange(frames) * every, made, names, told)


def _columns(compilation: Compilation, rates: bool):
    return named.coordinates(compilation, rates=rates).columns(10**9)


def tracks(cloud: Cloud, size: tuple[int, int], vectors: bool) -> tuple[list[Track], list[Label]]:
    """Returns the tracks of the axes and of the cloud, and the labels of the axes."""
    unit = min(size) / 720
    left, low, right, high = (x * s for x, s in zip(EDGE, (*size, *size), strict=True))
    flat = cloud.places.reshape(-1, 2)
    flat = flat[numpy.isfinite(flat).all(axis=1)]
    spans = [(float(x.min()), float(x.max())) if len(x) else (0.0, 1.0) for x in flat.T]
    pads = [0.04 * ((b - a) or 1.0) for a, b in spans]
    (x0, x1), (y0, y1) = ((a - p, b + p) for (a, b), p in zip(spans, pads, strict=True))
    scale = numpy.array([(right - left) / (x1 - x0), (high - low) / (y1 - y0)])
    origin = numpy.array([left, low]) - scale * (x0, y0)
    depth = numpy.zeros(len(cloud.t))
    found, labels = [], []

    def line(points: list[list[float]], colour: str, wide: float) -> Track:
        every = numpy.broadcast_to(numpy.array(points), (len(depth), len(points), 2))
        return Track("path", every, depth, colour, wide * unit)

    for x in _ticks(x0, x1):
        at = float(origin[0] + scale[0] * x)
        found.append(line([[at, low], [at, high]], "#D2D2D2", 1.2))
        labels.append((f"{x:g}", at - 8 * unit, low - 26 * unit))
    for y in _ticks(y0, y1):
        at = float(origin[1] + scale[1] * y)
        found.append(line([[left, at], [right, at]], "#D2D2D2", 1.2))
        labels.append((f"{y:g}", left - 52 * unit, at - 7 * unit))
    found.append(line([[left, high], [left, low], [right, low]], GREY, 1.4))
    labels += [(cloud.names[0], right - 90 * unit, low - 56 * unit)]
    labels += [(cloud.names[1], left + 10 * unit, high + 6 * unit)]
    places = origin + scale * cloud.places
    near = depth + 1
    radius = (2.0 if cloud.places.shape[1] > 500 else 3.0) * unit
    if not vectors:
        found.append(Track("cloud", places, near, BLUE, radius=radius, alpha=0.7))
    else:
        for k in range(places.shape[1]):
            one = places[:, k : k + 1]
            found.append(Track("disc", one, near, "", 0.0, BLUE, radius=2 * radius))
    return found, labels


def _ticks(a: float, b: float) -> list[float]:
    """Returns round numbers between a and b, for an axis."""
    step = 10 ** numpy.floor(numpy.log10((b - a) / TICKS))
    step *= next(k for k in (1, 2, 5, 10) if (b - a) / (k * step) <= TICKS)
    first, last = numpy.ceil(a / step), numpy.floor(b / step)
    return [float(round(k * step, 12)) for k in numpy.arange(first, last + 1)]
