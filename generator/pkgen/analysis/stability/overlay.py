"""Draws predictions over a map: labelled lines, and marks at the measured step sizes."""

from __future__ import annotations

import matplotlib.patheffects as effects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from ...plot.style import Look
from ...record import record
from .map import StabilityMap
from .measure import Row
from .method import PAIRS
from .predict import RESONANCES

# Kind of a prediction -> line style, label, text in the legend. The legend has one text for kinds
# with the same line style.
LINES = {
    "limit": ("-", "limit", "predicted limit"),
    "branch": ((0, (6, 2)), "branch", "branch: predicted loss of the solution"),
    "1:3": ("--", "1:3", "step resonance 1:3, 2:3"),
    "2:3": ("--", "2:3", "step resonance 1:3, 2:3"),
    "1:4": ("-.", "1:4", "step resonance 1:4, 3:4"),
    "3:4": ("-.", "3:4", "step resonance 1:4, 3:4"),
    "1:2": (":", "1:2 {slow}, {fast}", "step resonance of two modes"),
    "1+2": (":", "{fast} + 2{slow}", "step resonance of two modes"),
    "2+1": (":", "2{fast} + {slow}", "step resonance of two modes"),
    "cycle": ((0, (8, 2, 2, 2)), "cycle lost", "predicted loss of the cycle"),
    "local": ((0, (1, 3)), "scale", "scale: resolves the fastest motion"),
}
APART = 0.09  # least distance of two stars, relative to the lengths of the axes
GHOSTS = {"ghost": "ghost that keeps a run", "ghost that repels": "ghost that repels"}
SILENT, SILENT_DARK = "#708090", "#8FA3B5"  # colours of a resonance without a response
SIZE = 6.0  # font size of a label, in points
DOWN = 24  # number of positions along a line that are tried for its label
# The cost of a label that covers another line. To move a label from the upper end of its line to
# the lower end costs 1.
COVERED = 0.3


@record(eq=False)
class Marked:
    """A line and the text of its label, which label() places."""

    text: str
    h: np.ndarray
    x: np.ndarray
    rank: int  # priority of the label; 0 is the highest


def _curves(rows: tuple[Row, ...], name: str) -> dict[tuple, list[tuple[float, float]]]:
    """Returns the points (x, h) of each predicted line of a method: the predicted step size h in
    the row with the value x of the varied quantity. The key identifies the line."""
    found: dict[tuple, list[tuple[float, float]]] = {}
    for row in rows:
        for p in row.predictions:
            if p.method == name and p.h:
                primary = p.equilibrium is not None and p.equilibrium == row.primary
                key = (p.kind, p.mode, p.other, primary, None if primary else p.equilibrium)
                found.setdefault(key, []).append((row.x, p.h))
    return found


def lines(
    axes: plt.Axes, made: StabilityMap, name: str, look: Look
) -> tuple[set[str], list[Marked]]:
    """Draws the lines. Returns the kinds drawn, with "silent" for resonances without a response,
    and the lines to be labelled."""
    drawn: set[str] = set()
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    labels: list[Marked] = []
    seen: set[tuple[str, int]] = set()
    silent = [m.prediction for m in made.measured if m.prediction.method == name and m.silent]
    silent = {(p.kind, p.mode, p.other) for p in silent}
    for (kind, mode, other, primary, _), line in _curves(made.rows, name).items():
        hs = np.array([h for _, h in line])
        if not ((hs > low) & (hs < high)).any():
            continue
        mark = (kind, round(1e4 * hs[-1] / (high - low)))
        if mark in seen:
            continue  # a mirror image of the equilibrium has the same line
        seen.add(mark)
        xs = np.array([row.x for row in made.rows])
        at = dict(line)
        hs = np.array([at.get(x, np.nan) for x in xs])  # NaN interrupts the line
        if len(at) == len(xs):
            xs = np.concatenate([[bottom], xs, [top]])
            hs = np.concatenate([hs[:1], hs, hs[-1:]])
        dashes, word, _ = LINES[kind]
        quiet = (kind, mode, other) in silent
        drawn |= {kind, "silent"} if quiet else {kind}
        colour = _silent(look) if quiet else look.ink
        width = 1.3 if kind == "limit" and primary else 0.7 if quiet else 1.0
        halo = [effects.withStroke(linewidth=width + 1, foreground=look.ground)]
        behind = {"path_effects": None if quiet else halo, "zorder": 2 if quiet else 3}
        axes.plot(hs, xs, ls=dashes, color=colour, lw=width, **behind)
        several = primary and len(made.rest.equilibria[made.primary].oscillating) > 1
        if kind in RESONANCES and several:
            word = f"{word} {omega(mode)}"
        elif kind in PAIRS:
            word = word.format(fast=omega(mode), slow=omega(other))
        elif kind == "limit" and not primary:
            word = "limit elsewhere"
        rank = 2 if quiet else 0 if kind == "limit" and primary else 1
        labels.append(Marked(word, hs, xs, rank))
    return drawn, labels


def label(axes: plt.Axes, labels: list[Marked], look: Look) -> None:
    """Writes upright labels on the lines, the most important label first. A label does not cover
    other labels, avoids other lines if possible, and is as high on its line as possible. A label
    without a free position is omitted. Letters have a halo instead of a box, so that the cells of
    the map stay visible. Call this function after the layout of the figure."""
    renderer = axes.figure.canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    gap = axes.figure.dpi / 72
    taken: list[Bbox] = []
    lines = [np.column_stack([one.h, one.x])[np.isfinite(one.h)] for one in labels]
    courses = [axes.transData.transform(line) for line in lines]
    places = sorted(zip(labels, courses, strict=True), key=lambda p: (p[0].rank, p[1][-1][0]))
    for one, course in places:
        halo = [effects.withStroke(linewidth=1.6, foreground=look.ground)]
        at = {"rotation": 90, "ha": "center", "va": "center", "zorder": 4, "clip_on": True}
        text = axes.text(0, 0, one.text, fontsize=SIZE, color=look.ink, path_effects=halo, **at)
        text.set_in_layout(False)
        size = text.get_window_extent(renderer)
        best, least = None, np.inf
        room = frame.height - size.height - 6 * gap
        for k in range(DOWN):
            y = frame.y1 - 3 * gap - size.height / 2 - k * room / DOWN
            x = float(np.interp(y, course[:, 1], course[:, 0]))
            if not frame.x0 <= x <= frame.x1:
                continue
            half = size.width / 2 + 2 * gap
            x = min(max(x, frame.x0 + half), frame.x1 - half)  # keeps labels inside the map
            here = Bbox.from_bounds(
                x - size.width / 2 - gap, y - size.height / 2 - 2 * gap, size.width + 2 * gap,
                size.height + 4 * gap,
            )  # fmt: skip
            inside = course[0, 1] <= y <= course[-1, 1]
            if not inside or any(here.overlaps(other) for other in taken):
                continue
            crossed = sum(
                here.x0 < np.interp(y, other[:, 1], other[:, 0]) < here.x1
                for other in courses
                if other is not course
            )
            if k / DOWN + COVERED * crossed < least:
                best, least = here, k / DOWN + COVERED * crossed
        if best is None:
            text.remove()
            continue
        taken.append(best)
        middle = ((best.x0 + best.x1) / 2, (best.y0 + best.y1) / 2)
        text.set_position(axes.transData.inverted().transform(middle))


def _silent(look: Look) -> str:
    return SILENT_DARK if look.dark else SILENT


def omega(mode: int) -> str:
    """Returns the symbol of a mode's frequency, such as ω₁ for mode 0."""
    return "ω" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(mode + 1))


def measured(axes: plt.Axes, made: StabilityMap, name: str, look: Look) -> bool:
    """Draws triangles on the lower edge of a map, at the step sizes of measured limits. Returns
    whether any triangle is drawn."""
    low, high = axes.get_xlim()
    own = [m for m in made.measured if m.prediction.method == name and m.h]
    failing = [m.h for m in own if m.prediction.kind in ("limit", "branch", "cycle")]
    places = [h for h in failing if low < h < high]
    if not places:
        return False  # matplotlib's layout fails with an empty unclipped line
    how = {"marker": "^", "ls": "", "ms": 4.5, "color": look.ink, "mec": look.ground, "mew": 0.5}
    at = {"clip_on": False, "transform": axes.get_xaxis_transform(), "zorder": 5}
    axes.plot(places, [0.0] * len(places), **how, **at)
    return True


def ghosts(axes: plt.Axes, made: StabilityMap, name: str, look: Look) -> set[str]:
    """Draws stars at the step sizes and states of ghosts, filled if a run stays there. Stars too
    close together are omitted, empty ones first. Returns the kinds drawn."""
    (low, high), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    places: dict[str, list[tuple[float, float]]] = {}
    taken: list[tuple[float, float]] = []
    for ghost in sorted((g for g in made.ghosts if g.method == name), key=lambda g: not g.stays):
        for orbit in ghost.orbits:
            for x in sorted({round(made.place(state), 9) for state in orbit.states}):
                at = (orbit.h - low) / (high - low), (x - bottom) / (top - bottom)
                if not (0 < at[0] < 1 and 0 < at[1] < 1):
                    continue
                if all(max(abs(at[0] - a), abs(at[1] - b)) > APART for a, b in taken):
                    taken.append(at)
                    kind = "ghost" if ghost.stays else "ghost that repels"
                    places.setdefault(kind, []).append((orbit.h, x))
    for kind, some in places.items():
        axes.plot(*zip(*some, strict=True), **_star(kind, look), zorder=4)
    return set(places)


def _star(kind: str, look: Look) -> dict[str, object]:
    fill = look.ink if kind == "ghost" else look.ground
    return {"ls": "", "marker": "*", "ms": 6.0, "mec": look.ink, "mew": 0.5, "color": fill}


def handles(drawn: set[str], look: Look) -> list[tuple[Line2D, str]]:
    """Returns legend entries for everything drawn by lines(), measured() and ghosts()."""
    shown = {words: dashes for kind, (dashes, _, words) in LINES.items() if kind in drawn}
    found = [(Line2D([], [], color=look.ink, ls=ls, lw=1.0), words) for words, ls in shown.items()]
    if "silent" in drawn:
        line = Line2D([], [], color=_silent(look), ls="--", lw=1.0)
        found.append((line, "resonance that nothing answers"))
    for kind, words in GHOSTS.items():
        if kind in drawn:
            found.append((Line2D([], [], **_star(kind, look)), words))
    if "measured" in drawn:
        mark = Line2D([], [], color=look.ink, marker="^", ls="", ms=4)
        found.append((mark, "measured, small motion"))
    return found
