"""Draws branches over their parameter: solid where they are stable, dashed where they are not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pkgen.plot import style
from pkgen.system.exits import UsageError
from pkgen.system.files import replace
from pkgen.system.near import unknown

from .branches import Branch, Branches, parts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKS = {
    "fold": "o",
    "pitchfork": "D",
    "branch point": "s",
    "hopf": "^",
    "period doubling": "v",
    "torus": "P",
    "Krein collision": "X",
}
HEIGHT = 0.62  # the height of a picture, in widths


def _lines(branch: Branch, show: str) -> list[list[float]]:
    """Returns the ordinates of the lines of a branch: of an orbit its largest and least value."""
    if show == "period":
        return [[point.period for point in branch.points]]
    if branch.kind == "orbits" and all(show in point.extents for point in branch.points):
        return [[point.extents[show][k] for point in branch.points] for k in (0, 1)]
    return [[point.state[show] for point in branch.points]]


def figure(made: Branches, show: str | None = None) -> Figure:
    """Returns the picture. Raises UsageError."""
    import matplotlib.pyplot as plt

    names = [*made.branches[0].points[0].state] if made.branches else []
    timed = made.branches and all(b.points[0].period is not None for b in made.branches)
    names += ["period"] if timed else []
    show = show or names[0]
    if show not in names:
        raise UsageError(unknown("--show", show, names, "state"))
    drawn, axes = plt.subplots(figsize=(style.COLUMN * 1.3, style.COLUMN * 1.3 * HEIGHT))
    seen = set()
    for k, branch in enumerate(made.branches):
        x = [point.value for point in branch.points]
        for y in _lines(branch, show):
            for is_stable, first, last in parts(branch.points):
                how = {"color": style.colour(k), "linestyle": "-" if is_stable else (0, (3, 1.5))}
                axes.plot(x[first : last + 1], y[first : last + 1], **how)
            for i, point in enumerate(branch.points):
                if point.kind:
                    label = None if point.kind in seen else point.kind
                    seen.add(point.kind)
                    how = {"markersize": 4, "color": style.INK, "label": label, "zorder": 3}
                    axes.plot(x[i], y[i], MARKS[point.kind], **how)
    axes.set_xlabel(made.name + (f" [{made.unit}]" if made.unit else ""))
    axes.set_ylabel(show)
    if seen:
        axes.legend(frameon=False)
    drawn.tight_layout()
    return drawn


def written(made: Branches, path: Path, show: str | None) -> Path:
    """Writes the picture. Raises UsageError."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with pyplot.rc_context(style.LOOK):
        drawn = figure(made, show)
        replace({path: style.encoded(drawn, path.suffix[1:])})
        pyplot.close(drawn)
    return path
