"""Pictures of docs/dev/results/models.md.

kepler       the ellipse of a perturbed sun turns
sections     Poincare sections of Henon and Heiles' well at three energies
swarm        a loop of pendulums in phase space, which keeps its area
fput         energies of normal modes, and their recurrence
kinks        a kink and an antikink go through each other
foucault     the rosettes of Foucault's pendulum
"""

from __future__ import annotations

import numpy as np
from rows import Rows, panels

from pkgen.plot.names import amount
from pkgen.plot.style import BLUE, DIVERGING, GREEN, ORANGE, PURPLE, RED, SEQUENTIAL


def orbit(axis, x, y, title: str, named: str) -> None:
    axis.plot(x, y, lw=0.6, color=BLUE)
    axis.set_aspect("equal")
    axis.set(title=title, xlabel=named.format("x"), ylabel=named.format("y"))


def kepler():
    """Both perturbations that the model has, over a dozen turns."""
    figure, axes = panels(2)
    cases = {"− μ/r + γ/r³, γ = −0.01": ["gamma=-0.01"], "− μ/r + κ/r², κ = 0.02": ["kappa=0.02"]}
    for axis, (title, given) in zip(axes, cases.items(), strict=True):
        words = [w for x in (*given, "e=0.6") for w in ("--set", x)]
        rows = Rows("particles/kepler_perturbed.lag", *words, "--until", 50, "--every", 0.02)
        x, y = rows["r"] * np.cos(rows["phi"]), rows["r"] * np.sin(rows["phi"])
        orbit(axis, x, y, title, "{}/a")
        axis.plot([0], [0], "o", color=ORANGE, ms=6)
    return figure


def sections():
    """y and y' where x = 0 is crossed upwards."""
    figure, axes = panels(3)
    for axis, (energy, name) in zip(
        axes, ((1 / 12, "1/12"), (1 / 8, "1/8"), (1 / 6, "1/6")), strict=True
    ):
        rows = Rows("particles/henon_heiles.lag", "--scene", "sections", "--set", f"E={energy!r}")
        shown = axis.scatter(rows["y"], rows["y'"], s=0.9, lw=0, c=rows["k"], cmap=SEQUENTIAL)
        axis.set_title(f"E = {name}")
        axis.set_xlabel("y")
    axes[0].set_ylabel("y′ where x = 0, x′ > 0")
    figure.colorbar(shown, ax=axes[-1], label="member k")
    return figure


def swarm():
    """The loop at four times; its area is that of the diagnostic."""
    rows = Rows("pendulums/pendulum.lag", "--scene", "loop")
    shown = np.unique(rows["t"])
    figure, axes = panels(len(shown), 3.4, 3.4)
    for axis, t in zip(axes, shown, strict=True):
        now = rows["t"] == t
        axis.plot(rows["theta"][now], rows["theta'"][now], lw=0.5, color=BLUE)
        axis.set(xlim=(-3, 3), ylim=(-2.2, 2.2), xlabel="θ [rad]")
        axis.set_title(f"t = {amount(f'{t:g}', 's')}")
    axes[0].set_ylabel("θ′ [rad/s]")
    return figure


def fput():
    """Energies of the first modes of the alpha chain, over a super-period and more."""
    n = 31
    rows = Rows(
        "chains/fput.lag", "--until", 11000, "--every", 20, "--method", "kahan_li8", "--step", 0.2
    )
    i = np.arange(1, n + 1)
    figure, (axis,) = panels(1, 8, 4)
    for k, colour in zip((1, 2, 3, 4), (BLUE, RED, GREEN, PURPLE), strict=True):
        shape = np.sqrt(2 / (n + 1)) * np.sin(np.pi * i * k / (n + 1))
        frequency = 2 * np.sin(np.pi * k / (2 * (n + 1)))
        place, rate = rows.family("q")[:, :n] @ shape, rows.family("q")[:, n:] @ shape
        energy = (rate**2 + (frequency * place) ** 2) / 2
        axis.plot(rows["t"] / 64.0257093, energy, color=colour, lw=1, label=f"mode {k}")
    axis.set_xlabel("t [periods of the first mode]")
    axis.set_ylabel("energy of a mode (without unit)")
    axis.legend(frameon=False, loc="upper center", ncols=4)
    return figure


def kinks():
    """q(x, t) of the collision, and a breather."""
    figure, axes = panels(2, 5, 4)
    for axis, (scene, until) in zip(axes, (("collision", 40), ("breather", 40)), strict=True):
        rows = Rows(
            "chains/sine_gordon.lag", "--scene", scene, "--until", until, "--every", 0.25,
            "--record", ",".join(f"q[{i}]" for i in range(1, 400, 2)),
        )  # fmt: skip
        q = rows.family("q")
        shown = axis.imshow(
            q, origin="lower", aspect="auto", cmap=DIVERGING, vmin=-2 * np.pi, vmax=2 * np.pi,
            extent=(-20, 20, 0, until),
        )  # fmt: skip
        axis.set_title(scene)
        axis.set_xlabel("x")
    axes[0].set_ylabel("t")
    figure.colorbar(shown, ax=axes[1], label="q")
    return figure


def foucault():
    """On an earth that turns 400 times as fast, so that the petals part."""
    figure, axes = panels(2)
    turn = ("--set", "turn=0.03", "--until", 139, "--every", 0.2)  # half a turn
    cases = {
        "released at rest beside the earth: cusps": (),
        "at rest beside the stars: through the middle": ("--scene", "rosette"),
    }
    for axis, (title, words) in zip(axes, cases.items(), strict=True):
        rows = Rows("pendulums/foucault.lag", *words, *turn, "--record", "x,y")
        orbit(axis, rows["x"], rows["y"], title, "{} [m]")
    return figure


PICTURES = (kepler, sections, swarm, fput, kinks, foucault)
