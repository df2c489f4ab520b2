"""The chart: time against final error, a panel a model, and the kernels.

Lines are labelled where they end, not in a legend; colours are those of Okabe and Ito, which
readers with any usual colour vision tell apart, and markers differ as well.
"""

from __future__ import annotations

import math
import statistics
from pathlib import Path

from .kernels import Timing
from .machine import Machine
from .measure import Comparison

# name: (label, colour, marker, line width)
SHOWN = {
    "pkgen gauss": ("pkgen gauss", "#0072B2", "o", 2.4),
    "pkgen dop853": ("pkgen DOP853", "#56B4E9", "s", 1.4),
    "GSL rk8pd": ("GSL rk8pd", "#009E73", "^", 1.2),
    "heyoka": ("heyoka", "#D55E00", "D", 1.6),
    "CVODE Adams": ("CVODE Adams", "#CC79A7", "v", 1.2),
    "mechanicsdsl-core RK4": ("mechanicsdsl RK4", "#999999", "P", 1.2),
    "physicskit RK4": ("physicskit RK4", "#666666", "x", 1.2),
    "SciPy DOP853": ("SciPy DOP853", "#000000", "*", 1.2),
}
BEST, WORST = 1e-13, 1e-1
LABEL_STEP = 0.06  # of the panel's height


def draw(
    comparisons: list[Comparison], timings: dict[str, Timing], machine: Machine, path: Path
) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 3, figsize=(15, 9), layout="constrained")
    panels = list(axes.flat)
    for panel, comparison in zip(panels, comparisons, strict=False):
        _curves(panel, comparison)
    for panel in panels[len(comparisons) :]:
        panel.axis("off")
    if timings and len(comparisons) < len(panels):
        panels[len(comparisons)].axis("on")
        _bars(panels[len(comparisons)], timings)
    figure.suptitle(
        "Time of one integration against its final error (lower and further right is better)"
    )
    figure.supxlabel("\n".join(machine.lines()), fontsize=8)
    for suffix in (".png", ".svg"):
        figure.savefig(path.with_suffix(suffix), dpi=110)
    pyplot.close(figure)


def _curves(panel, comparison: Comparison) -> None:
    ends = []
    for track in comparison.tracks:
        if track.name not in SHOWN:
            continue
        label, colour, marker, width = SHOWN[track.name]
        points = [p for p in track.curve() if BEST <= p.error <= WORST]
        if not points:
            continue
        x, y = [p.error for p in points], [1e6 * p.seconds for p in points]
        panel.plot(x, y, color=colour, marker=marker, linewidth=width, markersize=4)
        ends.append((x[-1], y[-1], label, colour))
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(WORST, BEST / 3e4)
    panel.set_xticks([10.0**-k for k in range(1, 14, 3)])
    panel.set_title(comparison.model.name.replace("_", " "))
    panel.set_xlabel("relative error of the final state")
    panel.set_ylabel("time (µs)")
    panel.grid(True, which="major", color="#dddddd", linewidth=0.6)
    panel.spines[["top", "right"]].set_visible(False)
    _labels(panel, ends)


def _labels(panel, ends: list[tuple]) -> None:
    """Right of the ends of the lines, pushed apart where they would overlap."""
    low, high = (math.log10(v) for v in panel.get_ylim())
    last = -math.inf
    for x, y, label, colour in sorted(ends, key=lambda e: e[1]):
        height = max((math.log10(y) - low) / (high - low), last + LABEL_STEP)
        last = height
        panel.annotate(
            label,
            xy=(x, y),
            xytext=(0.74, height),
            textcoords="axes fraction",
            color=colour,
            fontsize=8.5,
            va="center",
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.5, "shrinkA": 0},
        )


def _bars(panel, timings: dict[str, Timing]) -> None:
    rows = list(timings.values())[::-1]
    values = [statistics.median(t.rounds) for t in rows]
    own = [t.kernel.name.startswith("own") for t in rows]
    colours = ["#0072B2" if o else "#999999" for o in own]
    panel.barh(range(len(rows)), values, height=0.4, color=colours)
    panel.set_yticks([])
    for i, (value, timing) in enumerate(zip(values, rows, strict=True)):
        panel.text(value, i, f" {value:.1f}", va="center", fontsize=8.5)
        panel.text(0, i + 0.25, timing.kernel.title, va="bottom", fontsize=8.5)
    panel.set_ylim(-0.5, len(rows))
    panel.set_xlim(0, 1.15 * max(values))  # room for the longest number
    panel.set_title("double-pendulum acceleration")
    panel.set_xlabel("time of one evaluation (ns)")
    panel.spines[["top", "right"]].set_visible(False)
