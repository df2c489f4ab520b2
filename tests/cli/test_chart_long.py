"""`pkgen chart --long`, beside what is known of the harmonic oscillator.

Of x'' = -x from x = 1, v = 0: Verlet's energy drifts by h^2/8 at most, for ever; explicit Euler's
grows by 1 + h^2 a step, which ends; radau5 damps, its energy falls as t.
"""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

from conftest import case, ran, written

MODEL = case("oscillator")
METHODS = "verlet,euler,radau5,gauss2"
STEP = 0.1


def test_drifts_over_decades(tmp_path: Path) -> None:
    model = written(tmp_path, MODEL)
    words = ("--long", "--step", STEP, "--methods", METHODS, "--seconds", 6, "-o", tmp_path)
    done = ran("chart", model, *words, "--json", "--format", "png,pdf")
    told = json.loads(done.stdout)
    found = {m["method"]: m for m in told["methods"]}
    assert list(found) == METHODS.split(",") and told["step"] == STEP
    for one in found.values():
        steps = [d["steps"] for d in one["decades"]]
        assert steps == [10 ** (k + 1) for k in range(len(steps))] and len(steps) > 2
    verlet = found["verlet"]
    assert len(verlet["decades"]) > 4 and verlet["growth"]["energy"] == "bounded"
    for decade in verlet["decades"][1:]:
        # Of the largest of L and v p, 3/2.
        assert math.isclose(decade["drifts"]["energy"], STEP**2 / 12, rel_tol=0.02)
        assert math.isclose(decade["t"], decade["steps"] * STEP, rel_tol=1e-12)
    euler = found["euler"]["decades"]
    assert euler[-1]["status"] == "PK_NOT_FINITE" or euler[-1]["drifts"]["energy"] is None
    radau = found["radau5"]
    assert 0.9 < radau["exponents"]["energy"] < 1.1 or radau["decades"][-1]["steps"] < 1e4
    assert found["gauss2"]["decades"][-1]["drifts"]["energy"] < 1e-12
    with (tmp_path / "oscillator_long.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(m["decades"]) for m in told["methods"])
    for kind, begins in (("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")):
        assert (tmp_path / f"oscillator_long.{kind}").read_bytes().startswith(begins)
