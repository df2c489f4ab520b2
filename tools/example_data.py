"""Writes the data of two models: a road of class C (ISO 8608) and the record of a shaken pivot.

Both are sums of cosines with random phases. Usage: python tools/example_data.py
"""

import csv
from pathlib import Path

import numpy as np

MODELS = Path(__file__).resolve().parent.parent / "models"


def road(draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Heights in mm each 10 cm over 100 m. The spectral density is 256e-6 m^3 (n/n_0)^-2, where
    n_0 = 0.1/m: the middle of class C."""
    x = np.round(np.arange(1001) * 0.1, 1)
    n = np.arange(0.02, 2.5, 0.01)
    height = np.sqrt(2 * 256e-6 * (n / 0.1) ** -2 * 0.01)
    phase = draw.uniform(0, 2 * np.pi, n.size)
    return x, np.round(1e3 * height @ np.cos(2 * np.pi * np.outer(n, x) + phase[:, None]), 3)


def shaking(draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Places in mm each 10 ms over 40 s, around 1.5 Hz, that rise and fade as an earthquake."""
    t = np.round(np.arange(4000) * 0.01, 2)
    f = np.arange(0.2, 6, 0.025)
    size = np.exp(-(np.log(f / 1.5) ** 2) / 0.5)
    phase = draw.uniform(0, 2 * np.pi, f.size)
    sums = size @ np.cos(2 * np.pi * np.outer(f, t) + phase[:, None])
    return t, np.round(8 * sums * (t / 8) ** 2 * np.exp(2 - t / 4), 3)


def write(path: Path, titles: tuple[str, str], columns: tuple[np.ndarray, np.ndarray]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(titles)
        writer.writerows(zip(*(c.tolist() for c in columns), strict=True))


if __name__ == "__main__":
    draw = np.random.default_rng(8608)
    write(MODELS / "bodies/quarter_car_road.csv", ("x [m]", "y [mm]"), road(draw))
    write(MODELS / "pendulums/shaken_pivot.csv", ("t [s]", "x [mm]"), shaking(draw))
