"""Chains (F1, S1, S3) and Henon and Heiles' model (H1, H2)."""

from functools import cache
from math import inf, nan, pi, sin, sqrt

import numpy as np

from .prediction import BOUNDARY, CLOSED, MEASURED, Prediction
from .probe import Failed, Probe
from .shown import around, listed

# --- Frenkel and Kontorova's kink ----------------------------------------------------------


@cache
def at_rest(sites: int, d: float) -> tuple[np.ndarray, float]:
    """The kink between two sites (an even number of them) or on one (odd), come to rest by
    friction. That on a site is a saddle, but its symmetry keeps it there for long enough."""
    probe = Probe("kink_chain", "gauss", size={"N": sites}, set={"d": d, "c": 1.0}, tolerance=1e-15)
    q = probe.at([70.0])[0, 1 : 1 + sites]
    return q, probe.energy(q, np.zeros(sites))


def barrier(d: float, sites: int) -> float:
    return at_rest(sites + 1, d)[1] - at_rest(sites, d)[1]


def kink_frequency(
    d: float, sites: int, span: float, method: str = "gauss", h: float = 0.0
) -> float:
    """Of small swings of the kink about its rest between two sites: pushed by 1e-3 of a site, and
    timed over `span` by a fit to its middle. Frequencies from one swing in all that time to a
    swing in ten samples are tried: nothing is known of it."""
    rest, _ = at_rest(sites, d)
    shape = np.gradient(rest)
    start = {f"q[{i + 1}]": rest[i] + 1e-3 * shape[i] for i in range(sites)}
    probe = Probe("kink_chain", method, h, size={"N": sites}, set={"d": d}, start=start,
                  tolerance=1e-12)  # fmt: skip
    try:
        rows = probe.at(np.linspace(0, span, 400)[1:])
    except Failed:
        return inf
    place, t = (rows[:, 1 : 1 + sites] - rest) @ shape, rows[:, 0]

    def misfit(w: float) -> float:
        basis = np.stack([np.cos(w * t), np.sin(w * t)], axis=1)
        return float(np.linalg.lstsq(basis, place, rcond=None)[1][0])

    step = 2 * pi / span / 20
    trial = np.arange(20, 800) * step
    k = int(np.argmin([misfit(w) for w in trial]))
    fine = trial[k] + step * np.linspace(-1, 1, 401)
    found = int(np.argmin([misfit(w) for w in fine]))
    return float(fine[found]) if 0 < k < len(trial) - 1 and 0 < found < len(fine) - 1 else nan


# --- FPUT -------------------------------------------------------------------------------------


@cache
def recurrence(method: str, h: float) -> tuple[float, float]:
    """When the first mode has most of its energy again, in its periods, and the share."""
    period = pi / sin(pi / 64)
    probe = Probe("chains/fput", method, h, size={"N": 31}, tolerance=1e-13)
    mode = np.sin(pi * np.arange(1, 32) / 32) * sqrt(2 / 32)
    times = np.arange(140 * period, 153 * period, period / 100)
    rows = probe.at(times)
    q, v = rows[:, 1:32] @ mode, rows[:, 32:63] @ mode
    share = (v * v + (2 * pi / period) ** 2 * q * q) / 2 / rows[:, -1]
    k = int(np.argmax(share))
    return rows[k, 0] / period, share[k]


def fput_energy() -> float:
    probe = Probe("chains/fput", "gauss", size={"N": 31})
    return probe.now[-1]


def first_period(amplitude: float, method: str = "gauss", h: float = 0.0) -> float:
    """Of the first mode, in a small motion."""
    start = {f"q[{i}]": amplitude * sin(pi * i / 32) for i in range(1, 32)}
    probe = Probe("chains/fput", method, h, size={"N": 31}, start=start)
    x = probe.at(np.arange(1, 800) * 1.0)[:, 1:32] @ np.sin(pi * np.arange(1, 32) / 32)
    return float(2 * pi / np.arccos((x[1:-1] @ (x[2:] + x[:-2])) / (2 * x[1:-1] @ x[1:-1])))


# --- Henon and Heiles ---------------------------------------------------------------------


def starts(energy: float, count: int, seed: int = 2385) -> list[tuple[float, float, float]]:
    """y, x', y' spread evenly over the section x = 0 at this energy, in the well alone."""
    random, found = np.random.default_rng(seed), []
    while len(found) < count:
        y, v = random.uniform(-0.6, 1.0), random.uniform(-0.7, 0.7)
        rest = 2 * energy - v * v - y * y + 2 * y**3 / 3
        if rest > 0:
            found.append((y, sqrt(rest), v))
    return found


@cache
def regular_fraction(
    energy: float, count: int = 1500, until: float = 5000, method: str = "yoshida4"
) -> float:
    """Share of starts whose tangent grows by less than exp(.005 t): on a torus it grows like t,
    to some .0018 t here, and at E = 1/12 nearly all stay below. At E = 1/8 and 1/6 the share
    changes by less than .01 from there to t = 10,000. A tangent that overflows is chaotic's."""
    regular, h = 0, 0.1
    for y, x1, y1 in starts(energy, count):
        probe = Probe("henon_heiles", method, h, start={"y": y, "x'": x1, "y'": y1, "u": 1.0})
        row = probe.steps(round(until / h), round(until / h), strict=False)
        regular += len(row) == 1 and np.log(np.abs(row[0, [3, 4, 7, 8]]).max()) < 0.005 * until
    return regular / count


@cache
def escaped(energy: float, count: int = 1000, method: str = "yoshida4", h: float = 0.05) -> float:
    """Share of starts that leave the well by t = 500."""
    gone = 0
    for y, x1, y1 in starts(energy, count):
        probe = Probe("henon_heiles", method, h, start={"y": y, "x'": x1, "y'": y1})
        rows = probe.steps(round(500 / h), 20, strict=False)
        gone += len(rows) < 500 / h / 20 or np.hypot(rows[:, 1], rows[:, 2]).max() > 1.5
    return gone / count


PREDICTIONS = [
    Prediction(
        "F1a", "FPUT-alpha, 32 springs, first mode, amplitude 1", "energy", 0.07704437, 1e-6,
        fput_energy, "amplitude 1.01", lambda: 1.01**2 * fput_energy(),
        no_method="the energy of a start; nothing is integrated",
    ),
    Prediction(
        "F1b", "FPUT-alpha, first mode, amplitude 1e-6, gauss", "period pi / sin(pi/64)",
        pi / sin(pi / 64), 1e-7, lambda: first_period(1e-6),
        "verlet, h = .1", lambda: first_period(1e-6, "verlet", 0.1),
    ),
    Prediction(
        "F1c", "FPUT-alpha, amplitude 1, gauss", "the first mode's energy recurs, after so many T1",
        146.447, 1e-4, lambda: recurrence("gauss", 0.0)[0],
        "verlet, h = .5", lambda: recurrence("verlet", 0.5)[0],
    ),
    Prediction(
        "F1d", "FPUT-alpha, amplitude 1, gauss", "share of the energy that recurs",
        0.98127, 1e-4, lambda: recurrence("gauss", 0.0)[1],
        "verlet, h = .5", lambda: recurrence("verlet", 0.5)[1],
    ),
    *(
        Prediction(
            id, f"kink, d = {d}, come to rest by gauss", "Peierls and Nabarro's barrier",
            predicted, CLOSED, lambda d=d, n=n: barrier(d, n),
            f"d = {1.1 * d:g}", lambda d=d, n=n: barrier(1.1 * d, n),
            no_method="energies of two shapes at rest: any method that comes to rest comes there",
        )
        for id, d, n, predicted in (("S1a", 0.5, 80, 3.1260e-6), ("S1c", 1.0, 40, 0.02536415557))
    ),
    *(
        Prediction(
            id, f"kink, d = {d}, gauss", "frequency about its rest",
            predicted, CLOSED, lambda d=d, n=n, t=span: kink_frequency(d, n, t),
            "euler, h = .2", lambda d=d, n=n, t=span: kink_frequency(d, n, t, "euler", 0.2),
        )
        for id, d, n, predicted, span in (
            ("S1b", 0.5, 80, 5.524376e-3, 4500.0), ("S1d", 1.0, 40, 0.24583955, 100.0),
        )
    ),
    listed(
        "S3", "ring of 40 sites, d = 1, verlet", "limit 2 / sqrt(1 + 4/d^2)",
        2 / sqrt(5), BOUNDARY,
        f"for h in {around(2 / sqrt(5))}; do pkgen run chain.lag --method verlet --step $h "
        "--until 400*$h --every 50*$h; done", "edge of h: not max(abs(q_1_)) < 1e-3",
        "--method yoshida4",
    ),
    *(
        Prediction(
            id, f"Henon-Heiles, E = {text}, yoshida4, h = .1, 1500 starts, t = 5000",
            "share of tangents that grow by less than exp(.005 t)", band, 0,
            lambda e=energy: regular_fraction(e),
            "euler", lambda e=energy: regular_fraction(e, method="euler"), long=True,
        )
        for id, text, energy, band in (
            ("H1a", "1/12", 1 / 12, (0.99, 1.0)), ("H1b", "1/8", 1 / 8, (0.40, 0.44)),
            ("H1c", "1/6", 1 / 6, (0.024, 0.036)),
        )
    ),
    *(
        Prediction(
            id, f"Henon-Heiles, E = {energy:.4g}, yoshida4, h = .05, 1000 starts",
            "share that escapes by t = 500", predicted, MEASURED,
            lambda e=energy: escaped(e),
            f"{method}, h = {h}", lambda e=energy, m=method, h=h: escaped(e, method=m, h=h),
            long=True,
        )
        # Euler's method heats, so that all escape; rk3 at a long step cools.
        for id, energy, predicted, method, h in (
            ("H2a", 0.166, (0.0, 0.0), "euler", 0.05), ("H2b", 0.17, 0.58, "euler", 0.05),
            ("H2c", 0.18, 0.95, "rk3", 0.5), ("H2d", 0.2, (0.995, 1.0), "rk3", 0.5),
        )
    ),
]  # fmt: skip
