"""The README's picture: one motion of the double pendulum, and how each method keeps its energy.

.venv/bin/python tools/picture.py        writes docs/pictures/double_pendulum.svg
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from pkgen.plot.style import BLUE, FILES, GREEN, PURPLE, RED, encoded

ROOT = Path(__file__).resolve().parent.parent
MODEL = ROOT / "models" / "double_pendulum.lag"
TARGET = ROOT / "docs" / "pictures" / "double_pendulum.svg"
DURATION = 5000.0
STEP = 0.01
METHODS = {"rk4": RED, "gauss1": BLUE, "gauss2": GREEN, "gauss4": PURPLE}  # each labelled directly


def run(method: str, until: float, every: float) -> np.ndarray:
    """Rows t, theta1, theta2, theta1', theta2', energy."""
    command = [sys.executable, "-m", "pkgen", "run", str(MODEL), "--json"]
    command += ["--method", method, "--until", str(until), "--every", str(every)]
    command += ["--rtol", "1e-12"] if method == "dop853" else ["--step", str(STEP)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return np.array(json.loads(done.stdout)["rows"])


def draw_motion(axes: plt.Axes) -> None:
    rows = run("dop853", 10.0, 0.01)
    x = np.sin(rows[:, 1]) + np.sin(rows[:, 2])
    y = -np.cos(rows[:, 1]) - np.cos(rows[:, 2])
    axes.plot(x, y, color=BLUE, lw=0.9)
    for k, label, offset in ((0, "start", (8, -3)), (-1, "after 10 s", (8, -12))):
        xs = [0, np.sin(rows[k, 1]), x[k]]
        ys = [0, -np.cos(rows[k, 1]), y[k]]
        axes.plot(xs, ys, "o-", color="#999999" if k == 0 else "black", ms=5, lw=1.5)
        place = {"textcoords": "offset points", "bbox": {"fc": "white", "ec": "none", "pad": 0.5}}
        axes.annotate(label, (xs[2], ys[2]), offset, **place)
    axes.set_aspect("equal")
    axes.set(xlabel="x [m]", ylabel="y [m]", title="Path of the lower bob")


def draw_drift(axes: plt.Axes) -> None:
    for method, colour in METHODS.items():
        rows = run(method, DURATION, 0.5)
        energy = rows[:, -1]
        error = np.maximum.accumulate(np.abs(energy / energy[0] - 1))
        axes.loglog(rows[1:, 0], np.maximum(error[1:], 1e-17), color=colour, lw=1.5)
        axes.annotate(
            method, (DURATION, error[-1]), (4, -3), textcoords="offset points", color=colour
        )
    axes.set(
        xlabel="t [s]",
        ylabel="largest relative energy error so far",
        title=f"Energy at a step of {STEP} s",
        xlim=(0.5, DURATION * 2.6),
    )
    axes.grid(alpha=0.25)


def main() -> None:
    plt.rcParams.update({**FILES, "font.size": 9})
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), width_ratios=(1, 1.4))
    draw_motion(left)
    draw_drift(right)
    figure.suptitle("double_pendulum.lag: m1 = m2 = 1 kg, l1 = l2 = 1 m, from its default start")
    figure.tight_layout()
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    TARGET.write_bytes(encoded(figure, "svg"))
    figure.savefig(ROOT / "build" / "double_pendulum.png", dpi=110)


if __name__ == "__main__":
    main()
