"""What takes longer: a million steps of each model, and every model for ten hash seeds.

`make test-long`; with PKGEN_UPDATE=1 the figures are written to docs/dev/long-runs.md.
"""

import json
import math
import os
import statistics
import subprocess
import sys
from pathlib import Path

import pytest
from page import write_section

from conftest import MODELS, ran

pytestmark = pytest.mark.long

STEPS, STEP = 1_000_000, 0.005
KEPLER = """model kepler                       # a planet in the plane, at the nearest point
param mu = 1 in (0, inf)
coord x, y
kinetic (x'^2 + y'^2)/2
potential -mu/sqrt(x^2 + y^2)
start x = {}, y' = {}
"""
ECCENTRICITIES = (0.57, 0.58, 0.585, 0.59, 0.595, 0.605, 0.61, 0.62)
PERIODS, PER_PERIOD = 100_000, 50
ROUND_OFF = """\
Kepler, e = .57 to .62 (eight orbits), gauss8 in {0} steps a period: root mean square of the
relative energy error over the last tenth of so many periods and over the orbits, seen at the
start's phase. A random walk: the error over n periods is fitted by n^{1:.2f}, and single orbits
have both signs. The textbook form of the method, without compensated sums and with h a_ij rounded
on its own, grows like n. (gauss4 in 200 steps a period leaves sqrt(n) after 1e4 periods by
truncation: its phase drifts, and the energy's own wave over a period shows; in 320 steps it does
not.)

| periods | error |
|---|---|
"""
TITLE = "A million steps"
EXACT = 1e-12
INTRODUCTION = f"""\
Drift of each model's constants over {STEPS:,} steps of {STEP} s, from its own start: the largest,
and in brackets what a straight line through it gains over the run. Written by `make test-long`
(`PKGEN_UPDATE=1 make test-long`), which demands that gauss8 and gauss4 stay below {EXACT:.0e}, that
the energy error of gauss2 does not grow by more than a twentieth of its size, and that rk4 fails
both. gauss8 is in the lanes where M is constant and forces depend on q alone; elsewhere Newton's.

| model | constant | gauss8 | gauss4 | gauss2 | rk4 |
|---|---|---|---|---|---|
"""


def drifts(pkgen, model: Path, method: str, out: Path) -> dict[str, tuple[float, float]]:
    """Of each constant: its largest drift, and the slope times the duration."""
    until = STEPS * STEP
    done = ran(
        *("run", model, "--method", method, "--step", STEP, "--until", until),
        *("--every", until / 1000, "--json", "-o", out),
    )
    report = json.loads(done.stdout)["report"]
    assert report["steps"] == STEPS
    return {d["name"]: (d["max"], d["slope"] * until) for d in report["drifts"]}


@pytest.fixture(scope="module")
def page():
    lines: list[str] = []
    yield lines
    write_section(TITLE, INTRODUCTION + "\n".join(sorted(lines)))


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_a_million_steps(pkgen, model: Path, page: list[str], tmp_path: Path) -> None:
    methods = ("gauss8", "gauss4", "gauss2", "rk4")
    found = {method: drifts(pkgen, model, method, tmp_path / "rows.csv") for method in methods}
    for name in found["rk4"]:
        cells = [f"{found[m][name][0]:.1e} ({found[m][name][1]:+.0e})" for m in methods]
        page.append(f"| {model.stem} | {name} | {' | '.join(cells)} |")
        for method in ("gauss8", "gauss4"):
            assert 0 < found[method][name][0] < EXACT
    largest, gained = found["gauss2"]["energy"]
    # Below 1e-14 both are round-off: the linear model, whose quadratic energy Gauss keeps exactly.
    assert abs(gained) < largest / 20 or largest < 1e-14
    largest, gained = found["rk4"]["energy"]
    assert largest > 1e-12 and abs(gained) > largest / 20


def orbit(pkgen, e: float, folder: Path) -> list[float]:
    """The relative energy error after every tenth period."""
    model, out = folder / f"kepler{e}.lag", folder / f"rows{e}.csv"
    model.write_text(KEPLER.format(repr(1 - e), repr(math.sqrt((1 + e) / (1 - e)))))
    period = 2 * math.pi
    ran(
        *("run", model, "--method", "gauss8", "--step", period / PER_PERIOD),
        *("--until", PERIODS * period, "--every", 10 * period, "-o", out),
    )
    lines = out.read_text().splitlines()
    place = lines[0].split(",").index("energy")
    return [(float(line.split(",")[place]) + 0.5) / 0.5 for line in lines[1:]]


def test_round_off_is_a_random_walk(pkgen, tmp_path: Path) -> None:
    """Eight orbits, since the end of a single walk says little."""
    drifts = [orbit(pkgen, e, tmp_path) for e in ECCENTRICITIES]

    def error(periods: int) -> float:
        last = [x for drift in drifts for x in drift[periods // 100 * 9 : periods // 10 + 1]]
        return math.sqrt(sum(x * x for x in last) / len(last))

    ends = [1000 * 10**k for k in range(3)]
    errors = [error(n) for n in ends]
    slope = statistics.linear_regression(*(list(map(math.log, x)) for x in (ends, errors))).slope
    write_section(
        "Round-off over 100,000 periods",
        ROUND_OFF.format(PER_PERIOD, slope)
        + "".join(f"| {n:,} | {e:.1e} |\n" for n, e in zip(ends, errors, strict=True)),
    )
    assert 1e-15 < errors[-1] < 3e-13 and slope < 0.75
    last = [statistics.fmean(drift[-PERIODS // 100 :]) for drift in drifts]
    assert min(last) < 0 < max(last)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_every_model_to_the_byte_for_ten_hash_seeds(model: Path, tmp_path: Path) -> None:
    texts = set()
    for seed in range(10):
        out = tmp_path / str(seed)
        env = {**os.environ, "PYTHONHASHSEED": str(seed)}
        command = [sys.executable, "-m", "pkgen", str(model), "-o", str(out), "--self-test"]
        subprocess.run(command, env=env, check=True)
        texts.add(tuple((p.name, p.read_bytes()) for p in sorted(out.iterdir())))
    assert len(texts) == 1 and len(next(iter(texts))) == 5
