"""A million steps of bodies that turn, of constraints and of rolling: constants and residuals.

`make test-long`; with PKGEN_UPDATE=1 the figures are written to docs/dev/long-runs.md.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, sin
from pathlib import Path

import pytest
from page import write_section

from conftest import ROOT, ran

pytestmark = pytest.mark.long

STEPS = 1_000_000
TITLE = "A million steps of bodies"
INTRODUCTION = f"""\
Drifts over {STEPS:,} steps from each model's own start: of the energy, in brackets what a straight
line through it gains over the run, and the largest of the other constants; and the largest residual
of the constraints, or of unit length, beside the largest coordinate, in 1,000 rows. The test
demands that what a method keeps stays below 1e-11, that energies that it does not keep gain less
than their error and grow slower than t^0.45 (the joint of the dumbbell moves them about for 1e5
steps on end), residuals below 1e-13, and that rk4 misses the first. The skate turns
by 24,000 rad, to whose last digit its direction is known.

| model | method | step | energy | others | residual |
|---|---|---|---|---|---|
"""
Row = dict[str, float]
PLACES = {"x", "y", "z", "alpha", "beta", "theta"}


def rod(row: Row) -> float:
    return max(
        abs(row["x"] ** 2 + row["y"] ** 2 - 1),
        abs(row["x"] * row["x'"] + row["y"] * row["y'"]),
    )


def rods(row: Row) -> float:
    upper = hypot(row["x1"], row["y1"]) - 1
    return max(abs(upper), abs(hypot(row["x2"] - row["x1"], row["y2"] - row["y1"]) - 1))


def axis(row: Row, name: str = "R") -> tuple[float, float, float]:
    w, x, y, z = (row[f"{name}.{c}"] for c in "wxyz")
    return 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)


def rings(row: Row) -> float:
    a, b = row["alpha"], row["beta"]
    held = (sin(a) * sin(b), -cos(a) * sin(b), cos(b))
    return max(abs(x - y) for x, y in zip(axis(row), held, strict=True))


def joint(row: Row) -> float:
    ends = zip("xyz", axis(row, "R1"), axis(row, "R2"), strict=True)
    return max(abs(row[f"{c}1"] - a / 2 - row[f"{c}2"] - b / 2) for c, a, b in ends)


def blade(row: Row) -> float:
    return abs(row["y'"] * cos(row["theta"]) - row["x'"] * sin(row["theta"]))


def length(row: Row) -> float:
    return abs(sum(row[f"R.{c}"] ** 2 for c in "wxyz") - 1)


@dataclass(frozen=True)
class Case:
    path: str
    method: str
    step: float
    residual: Callable[[Row], float]
    keeps: tuple[str, ...]
    bounded: tuple[str, ...] = ()


BODY, TOP = "bodies/free_body", "bodies/heavy_top_rotation"
ROD, RODS = "constrained/pendulum_rod", "constrained/double_pendulum_rods"
ABOUT, IN_SPACE = ("about_axis", "about_vertical"), ("square", "momentum.x", "momentum.z")
CASES = [
    Case(BODY, "gauss2", 0.1, length, ("energy", "square")),
    Case(BODY, "lie_midpoint", 0.1, length, IN_SPACE, ("energy",)),
    Case(TOP, "gauss4", 0.02, length, ("energy", *ABOUT)),
    Case(TOP, "lie_midpoint", 0.01, length, ABOUT, ("energy",)),
    Case(ROD, "gauss4", 0.02, rod, ("energy",)),
    Case(ROD, "rattle", 0.02, rod, (), ("energy",)),
    Case(RODS, "gauss4", 0.005, rods, ("energy",)),
    Case(RODS, "rattle", 0.005, rods, (), ("energy",)),
    Case("constrained/gimbals", "lie_midpoint", 0.002, rings, (), ("energy",)),
    Case("constrained/dumbbell", "lie_midpoint", 0.01, joint, ("momentum.x",), ("energy",)),
    Case("constrained/chaplygin_sleigh", "gauss4", 0.02, blade, ("energy",)),
    Case("constrained/skate", "gauss4", 0.02, blade, ("turning",)),
    Case("constrained/rolling_disk", "gauss4", 0.005, length, ("energy",)),
]


def drifts(pkgen, case: Case, method: str, steps: int, out: Path) -> tuple[dict, float]:
    """Of each constant its largest drift and what a line gains; and the largest residual."""
    until = steps * case.step
    done = ran(
        *("run", ROOT / "models" / f"{case.path}.lag", "--method", method, "--step", case.step),
        *("--until", until, "--every", until / 1000, "--json", "-o", out),
    )
    report = json.loads(done.stdout)["report"]
    assert report["steps"] == steps
    head, *lines = out.read_text(encoding="utf-8").splitlines()
    rows = (dict(zip(head.split(","), map(float, x.split(",")), strict=True)) for x in lines)
    found = {
        d["name"]: (d["max"], d["slope"] * until, d["exponent"] or 0) for d in report["drifts"]
    }
    return found, max(case.residual(row) / max([1, *map(abs, places(row))]) for row in rows)


def places(row: Row) -> list[float]:
    return [x for name, x in row.items() if name.rstrip("12") in PLACES]


@pytest.fixture(scope="module")
def page():
    lines: list[str] = []
    yield lines
    write_section(TITLE, INTRODUCTION + "\n".join(lines))


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{Path(c.path).stem}-{c.method}")
def test_a_million_steps(pkgen, case: Case, page: list[str], tmp_path: Path) -> None:
    found, residual = drifts(pkgen, case, case.method, STEPS, tmp_path / "rows.csv")
    largest, gained, _ = found["energy"]
    others = [found[name][0] for name in case.keeps if name != "energy"]
    said = f"{max(others):.1e}" if others else "–"
    page.append(
        f"| {Path(case.path).stem} | {case.method} | {case.step} | {largest:.1e} ({gained:+.0e}) |"
        f" {said} | {residual:.1e} |"
    )
    for name in case.keeps:
        assert found[name][0] < 1e-11, name
    for name in case.bounded:
        most, line, exponent = found[name]
        assert 1e-7 < most < 1e-2 and abs(line) < most and exponent < 0.45, found[name]
    assert residual < 1e-13
    if "energy" in case.keeps:
        worse, _ = drifts(pkgen, case, "rk4", STEPS // 100, tmp_path / "rows.csv")
        assert worse["energy"][0] > 1e-11
