"""Draws one work-precision diagram: error (or drift) to the right, cost upwards, both logarithmic,
as in Hairer, Norsett and Wanner (Solving Ordinary Differential Equations I, II.10). Points at the
lower left are best.

Failed runs are crosses in a strip at the right. The height of a cross is the cost of the run, or an
estimate if the cost is unknown. A dotted line starts at the point of the curve whose step is the
predicted stability limit, and ends in the strip. Crosses below the dotted line are failures of
steps beyond the limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from ...plot.style import PALE
from ...record import record
from .chart import Chart
from .labels import Label, place
from .points import Point, Track

LEAST, MOST = 1e-16, 2.0  # range of errors that a panel can show
STRIP = 100.0  # right end of the strip of failures, whose left end is MOST
OTHER = 0.3  # opacity of points that are not on the curve
LETTER, GAP = 0.68, 12.0  # width of a bold letter, in font sizes; space beside a name, in points
FAILED = "#8a3a10"
UNITS = {
    "seconds": "time of one integration",
    "work": "evaluations (a Jacobian: 2n of them)",
    "steps": "steps",
}


@record
class Style:
    colour: str
    marker: str | None
    strong: bool
    named: bool = True
    size: float = 4.0  # size of a strong marker, in points


BEHIND = Style(PALE, None, False, False)


@record
class Curve:
    """The points of a method. `measure` returns the error or drift of a point, the x coordinate;
    `axis` is the measure of cost; `limit` is the method's largest stable step size."""

    track: Track
    axis: str
    measure: Callable[[Point], float | None]
    limit: float | None

    @property
    def name(self) -> str:
        return self.track.method.name

    def good(self) -> list[tuple[float, float, Point]]:
        """Returns the points from the loosest setting to the one after the most accurate point. The
        errors of later points are round-off."""
        good = self.track.good
        errors = [p.error or 0.0 for p in good]
        found = []
        for point in good[: errors.index(min(errors)) + 2 if errors else 0]:
            value, cost = self.measure(point), point.cost(self.axis)
            if value is not None and cost:
                found.append((min(max(value, 1.5 * LEAST), 1.0), cost, point))
        return found

    def best(self) -> list[tuple[float, float]]:
        """Returns the points of the curve: those that no other point beats in both error and cost,
        without lucky ones (Point.lucky)."""
        found: list[tuple[float, float]] = []
        for value, cost, point in sorted(self.good(), key=lambda g: g[:2]):
            if not point.lucky and (not found or cost < found[-1][1]):
                found.append((value, cost))
        return found[::-1]

    def failures(self) -> list[float]:
        """Returns the costs of the failed runs. If a cost is unknown, it is estimated from the step
        size."""
        good, found = self.good(), []
        for point in (p for p in self.track.points if p.failed):
            cost = point.cost(self.axis)
            if point.arrived and cost:
                found.append(cost)
            elif good:
                fewer = good[0][2].setting / point.setting if self.track.method.fixed else 1.0
                found.append(good[0][1] * fewer)
        return found

    def cliff(self) -> tuple[float, float] | None:
        """Returns the error (at most 1) and the cost of the method at its stability limit, or None
        if no such point is known."""
        good = self.good()
        if self.limit is None or not good:
            return None
        nearest = min(good, key=lambda g: abs(math.log(g[2].setting / self.limit)))
        return nearest[0], nearest[1] * nearest[2].setting / self.limit


def draw(
    axes, curves: list[Curve], styles: Mapping[str, Style], chart: Chart, failures: bool
) -> Callable[[], None]:
    """Draws the curves. Returns a function that writes the names of the curves; it must be called
    after the layout of the figure."""
    drawn, labels = [], []
    for curve in sorted(curves, key=lambda c: styles.get(c.name, BEHIND).strong):
        style = styles.get(curve.name, BEHIND)
        x, y = [g[0] for g in curve.best()], [g[1] for g in curve.best()]
        if x:
            _line(axes, x, y, style)
            _others(axes, curve, style)
        if x and style is not BEHIND:
            drawn.append((x, y))
        if x and style.named:
            size = 8.5 if style.strong else 6.3
            labels.append(Label(curve.name, x[-1], y[-1], style.colour, size, style.strong))
        if failures and style.named:
            _failures(axes, curve, style)
    least = min((x[-1] for x, _ in drawn), default=LEAST)
    _scales(axes, curves[0].axis if curves else "")
    if failures:
        axes.axvspan(MOST, STRIP, color="#f6ebe6", zorder=0, lw=0)
        look = {"ha": "right", "va": "top", "size": 7.5, "color": FAILED}
        axes.text(0.99, 0.99, "failed", transform=axes.transAxes, **look)
        if chart.reference.error > 2 * LEAST:
            axes.axvspan(LEAST**2, chart.reference.error, color="#eeeeee", zorder=0, lw=0)
    labels.reverse()  # strong curves first

    def names() -> None:
        _room(axes, labels, least, STRIP if failures else MOST)
        place(axes, labels, drawn)

    return names


def _room(axes, labels: list[Label], least: float, most: float) -> None:
    """Sets the x limits so that the errors from `least` to `most` and the names of the curves fit.
    The layout of the figure must be final."""
    from matplotlib.ticker import FixedLocator

    width = axes.get_window_extent().width * 72 / axes.figure.dpi
    right, lefts = math.log10(most), [math.log10(least / 2)]
    for label in labels:
        part = min(0.5, (LETTER * label.size * len(label.text) + GAP) / width)
        lefts.append((math.log10(label.x) - part * right) / (1 - part))
    axes.set_xlim(10 ** min(lefts), most)
    decades = math.ceil(-math.log10(least))
    apart = 3 if decades > 6 else 1
    axes.xaxis.set_major_locator(FixedLocator([10.0**-k for k in range(0, decades + 1, apart)]))


def _others(axes, curve: Curve, style: Style) -> None:
    """Draws in pale colour the points that are not on the curve, since another point of the method
    beats them, or since they are lucky (Point.lucky)."""
    best = {*curve.best()}
    rest = [g[:2] for g in curve.good() if g[:2] not in best]
    if rest and style is not BEHIND and style.strong:
        look = {"ms": 0.6 * style.size, "color": style.colour, "alpha": OTHER, "mew": 0}
        axes.plot(*zip(*rest, strict=True), "o", ls="", zorder=2, **look)


def _line(axes, x: list[float], y: list[float], style: Style) -> None:
    size = style.size * (1.0 if style.strong else 0.6) * (1.5 if style.marker == "*" else 1.0)
    alpha = 1.0 if style.strong or style is BEHIND else 0.65 if style.named else 0.4
    order = 4 if style.strong else 2 if style is BEHIND else 3
    point = {"marker": style.marker if style.named else None, "ms": size}
    line = {"color": style.colour, "lw": 0.47 * style.size if style.strong else 0.8, "alpha": alpha}
    axes.plot(x, y, **point, **line, zorder=order)


def _scales(axes, axis: str) -> None:
    from matplotlib.ticker import EngFormatter, LogLocator, NullLocator

    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_locator(NullLocator())
    if axis == "seconds":
        axes.yaxis.set_major_formatter(EngFormatter("s"))
    axes.grid(True, which="major", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _failures(axes, curve: Curve, style: Style) -> None:
    costs, strong = curve.failures(), style.strong
    middle = math.sqrt(STRIP * MOST)
    width = 1.3 if strong else 0.8
    at = {"color": style.colour, "zorder": 5 if strong else 3}
    axes.plot([middle] * len(costs), costs, "x", ms=5 if strong else 3.2, mew=width, **at)
    cliff = curve.cliff()
    if cliff is None:
        return
    error, cost = cliff
    axes.plot([MOST, error], [cost, cost], ":", lw=width, **at)
    axes.plot([MOST], [cost], "_", ms=10, mew=2 * width, **at)
