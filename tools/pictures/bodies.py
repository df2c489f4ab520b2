"""Pictures of bodies that turn and roll.

tumbling     a free body turns over, beside its middle axis
nutation     a heavy top's axis: cusps, loops, waves
rattleback   its spin, begun in one sense and in the other
disk         Euler's disk settles; where a rolling disk touched the table
"""

from __future__ import annotations

from math import pi

import numpy as np
from matplotlib.patheffects import withStroke
from rows import Rows, panels

from pkgen.plot.style import BLUE, GREEN, GREY, INK, RED


class Sphere:
    """A unit sphere seen from a direction; what is behind it is drawn pale."""

    def __init__(self, axis, azimuth: float, height: float):
        """Angles in degrees: round the third axis from the first, and above the other two."""
        a, e = np.radians((azimuth, height))
        self.axis = axis
        self.to_us = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
        self.right = np.array([-np.sin(a), np.cos(a), 0])
        self.up = np.cross(self.to_us, self.right)
        turn = np.linspace(0, 2 * pi, 200)
        axis.plot(np.cos(turn), np.sin(turn), color=GREY, lw=0.8)
        axis.set(xlim=(-1.2, 1.2), ylim=(-1.25, 1.25))
        axis.set_aspect("equal")
        axis.set_axis_off()

    def seen(self, points: np.ndarray):
        """Places on paper of points, a row each."""
        return points @ self.right, points @ self.up

    def line(self, points: np.ndarray, **style) -> None:
        x, y = self.seen(points)
        behind = points @ self.to_us < 0
        self.axis.plot(np.where(behind, np.nan, x), np.where(behind, np.nan, y), **style)
        pale = {**style, "alpha": 0.25, "lw": 0.6 * style.get("lw", 1)}
        self.axis.plot(np.where(behind, x, np.nan), np.where(behind, y, np.nan), **pale)

    def circle(self, polar: float) -> None:
        """Of latitude, at this angle from the third axis."""
        turn = np.linspace(0, 2 * pi, 200)
        ring = [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn)]
        self.line(np.stack([*ring, np.full(200, np.cos(polar))], 1), color=GREY, lw=0.5, ls=":")

    def label(self, point, text: str) -> None:
        x, y = self.seen(1.17 * np.array([point]))
        halo = [withStroke(linewidth=2, foreground="white")]
        how = {"ha": "center", "va": "center", "fontsize": 8, "path_effects": halo}
        self.axis.text(x[0], y[0], text, **how)


MOMENTS = np.array([1, 2, 3])  # the model's


def tumbling():
    """Body rates; the angular momentum seen from the body, of many starts; the axis in space."""
    figure, (rates, sphere, space) = panels(3, 4, 3.6)
    long = ("--until", 60, "--every", 0.05)
    turning = Rows("bodies/free_body.lag", "--scene", "beside_the_middle", *long)
    for name, colour in zip("xyz", (BLUE, RED, GREEN), strict=True):
        rates.plot(turning["t"], turning[f"w.{name}"], color=colour, lw=1.1, label=f"ω{name}")
    rates.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.0))
    rates.set(ylim=(-1.35, 1.75), xlabel="t", ylabel="body rates (without unit)")
    rates.set_title("begun with ω = (0.01, 1, 0)")
    body = Sphere(sphere, 50, 25)
    for start in starts():
        rows = Rows("bodies/free_body.lag", "--scene", "beside_the_middle", "--until", 25,
                    "--every", 0.05, *start)  # fmt: skip
        body.line(_momentum(rows), color=BLUE, lw=0.8)
    body.line(_momentum(turning), color=RED, lw=1.4)
    for k, name in enumerate(("axis 1", "axis 2", "axis 3")):
        body.label(np.eye(3)[k], name)
    sphere.set_title("L, seen from the body")
    trace = Sphere(space, 60, 15)
    beside = ("--start", "omega(R).x=0.01", "--start", "omega(R).y=1", "--start", "omega(R).z=0")
    turned = Rows("bodies/free_body.lag", "--scene", "one_period", *beside, *long)
    first, third = (np.stack([turned[f"{n}.{a}"] for a in "xyz"], 1) for n in ("nose", "top"))
    middle = np.cross(third, first)[:, [2, 0, 1]]  # y, along which L is, upwards
    trace.line(middle, color=RED, lw=0.9)
    trace.label([0, 0, 1], "L")
    space.set_title("axis 2, seen from space")
    return figure


def starts() -> list[list[str]]:
    """Momenta of one length, round axes 1 and 3."""
    found = []
    for axis, angles in ((0, (13, 26, 39, 51)), (2, (9, 18, 27))):
        for degrees in angles:
            for sign in (1, -1):
                lean = np.radians(degrees)
                momentum = np.zeros(3)
                momentum[axis], momentum[1] = sign * np.cos(lean), np.sin(lean)
                rate = 2 * momentum / MOMENTS
                names = ("omega(R).x", "omega(R).y", "omega(R).z")
                pairs = zip(names, rate, strict=True)
                found.append([w for n, x in pairs for w in ("--start", f"{n}={x:.17g}")])
    return found


def _momentum(rows: Rows) -> np.ndarray:
    vector = np.stack([rows[f"w.{a}"] for a in "xyz"], 1) * MOMENTS
    return vector / np.linalg.norm(vector, axis=1)[:, None]


def nutation():
    """The trace of the axis; dotted, between which tilts it goes."""
    figure, axes = panels(3, 3.4, 3.6)
    cases = {"let go: cusps": 0, "thrown backwards: loops": -0.4, "thrown forwards: waves": 0.2}
    for axis, (title, precession) in zip(axes, cases.items(), strict=True):
        rows = Rows("bodies/heavy_top_rotation.lag", "--scene", "cusps", "--set",
                    f"precession={precession}", "--until", 9.5)  # fmt: skip
        sphere = Sphere(axis, -5, 40)
        tilt = np.arccos(rows["top.z"])
        sphere.circle(tilt.min())
        sphere.circle(tilt.max())
        path = np.stack([rows[f"top.{a}"] for a in "xyz"], 1)
        sphere.line(path, color=BLUE, lw=1.2)
        x, y = sphere.seen(np.array([[0, 0, 0], path[0]]))
        sphere.line(np.array([[0, 0, 0], [0, 0, 1]]), color=GREY, lw=0.8)
        axis.plot(x, y, color=INK, lw=1.2)
        axis.plot(x[1:], y[1:], "o", color=INK, ms=4)
        axis.set_title(title, y=0.93)
    return figure


def rattleback():
    """Its spin, with the air's drag and without."""
    figure, axes = panels(2, 5, 3.4)
    cases = {
        "with a drag of the air": ("reverses", "keeps"),
        "without any": ("undamped", "undamped_other_sense"),
    }
    for axis, (title, scenes) in zip(axes, cases.items(), strict=True):
        for scene, colour in zip(scenes, (RED, BLUE), strict=True):
            rows = Rows("constrained/rattleback.lag", "--scene", scene, "--until", 20)
            begun = "−5\u00a0rad/s" if scene == scenes[0] else "+5\u00a0rad/s"
            axis.plot(rows["t"], rows["spin"], color=colour, lw=0.9, label=f"begun with {begun}")
        axis.axhline(0, color=GREY, lw=0.6)
        axis.set(xlabel="t [s]", ylim=(-5.8, 7.2))
        axis.set_title(title)
        axis.legend(frameon=False, loc="upper right")
    axes[0].set_ylabel("spin about the vertical [rad/s]")
    return figure


def disk():
    """Euler's disk by three laws of friction; and the contact of a disk that wobbles on its way."""
    figure, (tilts, rates, track) = panels(3, 4, 3.6)
    cases = {
        "settles": "θ′ = −k/θ",
        "air": "−k/θ², the air",
        "friction": "−k/√θ, rolling",
    }
    for (scene, title), colour in zip(cases.items(), (BLUE, RED, GREEN), strict=True):
        rows = Rows("bodies/euler_disk.lag", "--scene", scene, "--record", "theta,phi'")
        end = rows["t"][-1]
        tilts.plot(rows["t"] / end, rows["theta"], color=colour, lw=1.2, label=title)
        rates.semilogy(rows["t"] / end, rows["phi'"], color=colour, lw=1.2)
    tilts.set(xlabel="t / time of the end", ylabel="tilt θ [rad]", ylim=(0, 0.21))
    tilts.set_title("Euler's disk: tilt")
    tilts.legend(frameon=False, loc="lower left")
    rates.set(xlabel="t / time of the end", ylabel="φ′ [rad/s]")
    rates.set_title("rate of its contact")
    rows = Rows("constrained/rolling_disk.lag", "--scene", "goes_round", "--set", "nod=6",
                "--until", 15, "--every", 0.005)  # fmt: skip
    x, y = contact(rows)
    track.plot(100 * rows["x"], 100 * rows["y"], color=GREY, lw=0.7, label="centre")
    track.plot(100 * x, 100 * y, color=BLUE, lw=0.9, label="contact")
    track.set_aspect("equal")
    track.set(xlabel="x [cm]", ylabel="y [cm]")
    track.set_title("a rolling disk's way")
    track.legend(frameon=False, loc="center")
    return figure


def contact(rows: Rows, radius: float = 0.0375):
    """The lowest point of the rim: from the centre down the steepest line of the disk's plane."""
    axis = np.stack([rows[f"axis.{a}"] for a in "xyz"], 1)
    down = axis[:, 2:] * axis - np.array([0, 0, 1])
    down /= np.linalg.norm(down, axis=1)[:, None]
    return rows["x"] + radius * down[:, 0], rows["y"] + radius * down[:, 1]


PICTURES = (tumbling, nutation, rattleback, disk)
