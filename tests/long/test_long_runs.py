"""What takes longer: a million steps of each model, and every model for ten hash seeds.

`make test-long`; with PKGEN_UPDATE=1 the figures are written to docs/long-runs.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import MODELS
from page import write_section

pytestmark = pytest.mark.long

STEPS, STEP = 1_000_000, 0.005
TITLE = "A million steps"
INTRODUCTION = f"""\
Drift of each model's constants over {STEPS:,} steps of {STEP} s, from its own start: the largest,
and in brackets what a straight line through it gains over the run. Written by `make test-long`
(`PKGEN_UPDATE=1 make test-long`), which demands that gauss4 stays below 1e-12, that the energy
error of gauss2 does not grow by more than a twentieth of its size, and that rk4 fails both.

| model | constant | gauss4 | gauss2 | rk4 |
|---|---|---|---|---|
"""


def drifts(pkgen, model: Path, method: str, out: Path) -> dict[str, tuple[float, float]]:
    """Of each constant: its largest drift, and the slope times the duration."""
    until = STEPS * STEP
    done = pkgen(
        *("run", model, "--method", method, "--step", STEP, "--until", until),
        *("--every", until / 1000, "--json", "-o", out),
    )
    assert done.returncode == 0, done.stderr
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
    methods = ("gauss4", "gauss2", "rk4")
    found = {method: drifts(pkgen, model, method, tmp_path / "rows.csv") for method in methods}
    for name in found["rk4"]:
        cells = [f"{found[m][name][0]:.1e} ({found[m][name][1]:+.0e})" for m in methods]
        page.append(f"| {model.stem} | {name} | {' | '.join(cells)} |")
        assert 0 < found["gauss4"][name][0] < 1e-12
    largest, gained = found["gauss2"]["energy"]
    # Below 1e-14 both are round-off: the linear model, whose quadratic energy Gauss keeps exactly.
    assert abs(gained) < largest / 20 or largest < 1e-14
    largest, gained = found["rk4"]["energy"]
    assert largest > 1e-12 and abs(gained) > largest / 20


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_every_model_to_the_byte_for_ten_hash_seeds(model: Path, tmp_path: Path) -> None:
    texts = set()
    for seed in range(10):
        out = tmp_path / str(seed)
        env = {**os.environ, "PYTHONHASHSEED": str(seed)}
        command = [sys.executable, "-m", "pkgen", str(model), "-o", str(out), "--self-test"]
        subprocess.run(command, env=env, check=True)
        texts.add(tuple((p.name, p.read_bytes()) for p in sorted(out.iterdir())))
    assert len(texts) == 1 and len(next(iter(texts))) == 3
