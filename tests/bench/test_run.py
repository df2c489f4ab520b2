"""The bench end to end, quickly: pkgen's own methods, no peers, one model. No time is asserted."""

import csv
import json
import os
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

from bench import models

ROOT = Path(__file__).resolve().parents[2]
MODEL = "bead_on_hoop"


@pytest.fixture(scope="module")
def measured(tmp_path_factory) -> tuple[str, Path]:
    output = tmp_path_factory.mktemp("bench")
    done = subprocess.run(
        [sys.executable, "-m", "bench", "--own", "--models", MODEL],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "BENCH_OUTPUT": str(output)},
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, output


def test_errors_fall_as_tolerances_do(measured) -> None:
    _, output = measured
    errors = defaultdict(dict)
    with (output / "points.csv").open() as file:
        for row in csv.DictReader(file):
            assert row["model"] == MODEL and float(row["seconds"]) > 0
            if row["round"] == "0":
                errors[row["contender"]][float(row["setting"])] = float(row["error"])
    tolerances = errors["pkgen dop853"]
    assert tolerances[1e-4] > 1e-6 > tolerances[1e-10] > 0
    coarse, fine = (errors["pkgen rk4"][20 * 0.5**k] for k in (12, 13))
    assert coarse / fine > 10 and fine > 1e-12  # order 4: about 16


def test_flags_and_verdicts_are_printed(measured) -> None:
    text, output = measured
    assert "-ffp-contract=" in text and "pkgen dop853" in text
    assert "to 1e-10 against pkgen's own C DOP853" in text
    lines = [line for line in text.splitlines() if "against CVODE" in line]
    assert len(lines) == 1 and "no peer" in lines[0] and "not reached" in lines[0]
    builds = (output / "builds.csv").read_text()
    assert builds.count("True") >= 2


def test_the_lagrangians_of_the_peers_are_those_of_the_models(pkgen) -> None:
    """The accelerations that peers get are those that pkgen's model has, at its start."""

    for name in models.LAGRANGIANS:
        model = models.model(name)
        parameters = dict(zip(model.parameters, model.values, strict=True))
        state = dict(zip((*model.q, *model.v), model.start, strict=True))
        theirs = [
            float(a.subs({**parameters, **state})) for a in models.equations(name).acceleration
        ]
        arguments = ["run", ROOT / "models" / f"{name}.lag", "--json", "--method", "dop853"]
        for parameter, value in models.REFERENCES[name]["params"].items():
            arguments += ["--set", f"{parameter}={value}"]
        h = 1e-4
        done = pkgen(*arguments, "--rtol", "1e-13", "--until", h, "--every", h)
        rows = json.loads(done.stdout)["rows"]
        n = model.n
        rates = [(b - a) / h for a, b in zip(rows[0][1 + n :], rows[-1][1 + n :], strict=False)][:n]
        for mine, other in zip(rates, theirs, strict=True):
            assert abs(mine - other) < 0.02 * max(1.0, abs(other)), name
