"""What is predicted, drawn over a map: lines with their labels, and where it was measured."""

from __future__ import annotations

import matplotlib.patheffects as effects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from .map import StabilityMap
from .measure import Row
from .method import PAIRS
from .predict import RESONANCES

# Kind of a prediction -> line, text.
LINES = {
    "limit": ("-", "limit"),
    "branch": ((0, (6, 2)), "branch"),
    "1:3": ("--", "1:3"),
    "1:4": ("-.", "1:4"),
    "2:3": ("--", "2:3"),
    "3:4": ("-.", "3:4"),
    **dict.fromkeys(PAIRS, (":", "")),
}
PAIR_WORDS = {"1:2": "1:2 {slow}, {fast}", "1+2": "{fast} + 2{slow}", "2+1": "2{fast} + {slow}"}
SILENT = "#8090A0"  # a resonance that nothing answers
BOX = {"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.85}
HALO = [effects.withStroke(linewidth=2.6, foreground="white")]


def _curves(rows: tuple[Row, ...], name: str) -> dict[tuple, list[tuple[float, float]]]:
    """A prediction's step in each row where it is made, by what identifies it."""
    found: dict[tuple, list[tuple[float, float]]] = {}
    for row in rows:
        for p in row.predictions:
            if p.method == name and p.h:
                primary = p.equilibrium == row.primary
                key = (p.kind, p.mode, p.other, primary, None if primary else p.equilibrium)
                found.setdefault(key, []).append((row.x, p.h))
    return found


def lines(axes: plt.Axes, made: StabilityMap, name: str) -> set[str]:
    """Which kinds of predictions are on the map, "silent" among them."""
    drawn: set[str] = set()
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    labels: list[tuple[float, str, str]] = []
    seen: set[tuple[str, int]] = set()
    silent = [m.prediction for m in made.measured if m.prediction.method == name and m.silent]
    silent = {(p.kind, p.mode, p.other) for p in silent}
    for (kind, mode, other, primary, _), line in _curves(made.rows, name).items():
        hs = np.array([h for _, h in line])
        if not ((hs > low) & (hs < high)).any():
            continue
        mark = (kind, round(1e4 * hs[-1] / (high - low)))
        if mark in seen:
            continue  # the mirror image of an equilibrium has the same
        seen.add(mark)
        xs = np.array([x for x, _ in line])
        if len(xs) == len(made.rows):
            xs = np.concatenate([[bottom], xs, [top]])
            hs = np.concatenate([hs[:1], hs, hs[-1:]])
        style, word = LINES[kind]
        quiet = (kind, mode, other) in silent
        drawn |= {kind, "silent"} if quiet else {kind}
        colour = SILENT if quiet else "black" if primary or kind == "branch" else "#555555"
        width = 1.5 if kind == "limit" and primary else 0.9 if quiet else 1.2
        behind = {"path_effects": None if quiet else HALO, "zorder": 2 if quiet else 3}
        axes.plot(hs, xs, ls=style, color=colour, lw=width, **behind)
        several = primary and len(made.rest.equilibria[made.primary].oscillating) > 1
        if kind in RESONANCES and several:
            word = f"{word} {omega(mode)}"
        elif kind in PAIRS:
            word = PAIR_WORDS[kind].format(fast=omega(mode), slow=omega(other))
        elif kind == "limit" and not primary:
            word = "limit elsewhere"
        labels.append((float(hs[-1]), word, colour))
    _label(axes, sorted(labels))
    return drawn


def omega(mode: int) -> str:
    """The name of a mode's frequency."""
    return "ω" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(mode + 1))


def _label(axes: plt.Axes, labels: list[tuple[float, str, str]]) -> None:
    """Upright texts along the lines' upper ends; where lines are close, one below the other, those
    that matter first."""
    low, high = axes.get_xlim()
    ends: list[tuple[float, float]] = []  # place, and how far down its text reaches
    for h, text, colour in sorted(labels, key=lambda label: (label[2] == SILENT, label[0])):
        near = [end for at, end in ends if abs(at - h) < 0.05 * (high - low)]
        down = max([0.02, *near])
        reach = down + 0.032 * len(text) + 0.03
        if low < h < high and reach < 1:
            at = {"transform": axes.transAxes, "rotation": 90, "ha": "center", "va": "top"}
            look = {"fontsize": 6.5, "color": colour, "bbox": BOX, "zorder": 4}
            axes.text((h - low) / (high - low), 1 - down, text, **at, **look)
            ends.append((h, reach))


def measured(axes: plt.Axes, made: StabilityMap, name: str) -> bool:
    """Triangles on the lower edge, where small motions were measured to fail; if there are any."""
    low, high = axes.get_xlim()
    own = [m for m in made.measured if m.prediction.method == name and m.h]
    failing = [m.h for m in own if m.prediction.kind in ("limit", "branch")]
    places = [h for h in failing if low < h < high]
    if not places:
        return False  # an empty line that is not clipped has no size that a layout could use
    look = {"marker": "^", "ls": "", "ms": 6, "color": "black", "mec": "white", "mew": 0.6}
    at = {"clip_on": False, "transform": axes.get_xaxis_transform(), "zorder": 5}
    axes.plot(places, [0.0] * len(places), **look, **at)
    return True


def handles(drawn: set[str]) -> list[Line2D]:
    """For the legend, of what lines() and measured() drew."""
    words = {
        "limit": "predicted limit",
        "branch": "predicted loss of the solution",
        "1:3": "step resonance 1:3, 2:3",
        "1:4": "step resonance 1:4, 3:4",
        "1:2": "step resonance of two modes",
    }
    same = {"2:3": "1:3", "3:4": "1:4", **dict.fromkeys(PAIRS, "1:2")}
    shown = {same.get(kind, kind) for kind in drawn}
    found = [
        Line2D([], [], color="black", ls=LINES[kind][0], lw=1.2, label=words[kind])
        for kind in words
        if kind in shown
    ]
    if "silent" in shown:
        found.append(Line2D([], [], color=SILENT, lw=1.2, label="resonance that nothing answers"))
    if "measured" in shown:
        found.append(
            Line2D([], [], color="black", marker="^", ls="", ms=5, label="measured, small motion")
        )
    return found
