"""Runs that fail or are cut short: what is said, and the exit code."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from conftest import ROOT

DOUBLE = ROOT / "models/double_pendulum.lag"
HOOP = ROOT / "models/bead_on_hoop.lag"


def test_a_method_that_does_not_apply_is_refused(pkgen) -> None:
    done = pkgen("run", DOUBLE, "--method", "verlet", "--step", "0.01")
    assert done.returncode == 4
    assert "separable" in done.stderr and done.stdout.count("\n") <= 2


FALL = """model fall
param a = 1
coord x
kinetic x'^2/2
potential a*sqrt(x)
start x = 1
"""


def test_numerical_failure_says_when(pkgen, tmp_path: Path) -> None:
    (tmp_path / "fall.lag").write_text(FALL)  # reaches x < 0, where sqrt(x) is not a number
    done = pkgen("run", tmp_path / "fall.lag", "--until", "10", "--json")
    assert done.returncode == 4
    report = json.loads(done.stdout)["report"]
    assert report["status"] != "PK_DONE" and 1 < report["t"] < 2
    assert all(x == x for row in json.loads(done.stdout)["rows"] for x in row)


def test_what_is_met_of_a_run_that_failed_is_met_so_far(pkgen, tmp_path: Path) -> None:
    scene = "scene s\nuntil 10\nrecord x every 0.1\nexpect x < 2\nend\n"
    (tmp_path / "fall.lag").write_text(FALL + scene)
    done = pkgen("run", tmp_path / "fall.lag", "--scene", "s")
    assert done.returncode == 4 and done.stderr.endswith(
        "expected: 1 of 1 met, as far as it came\n"
    )
    done = pkgen("run", tmp_path / "fall.lag", "--scene", "s", "--until", "1")
    assert done.returncode == 0 and done.stderr.endswith("expected: 1 of 1 met\n")


def test_a_size_that_the_model_has_not(pkgen) -> None:
    done = pkgen("check", DOUBLE, "--size", "N=3")
    assert done.returncode == 1 and "no size 'N'" in done.stderr


def test_missing_file(pkgen, tmp_path: Path) -> None:
    for path in (tmp_path / "none.lag", tmp_path):
        done = pkgen("check", path)
        assert done.returncode == 2 and "Traceback" not in done.stderr


def test_broken_compiler(pkgen, tmp_path: Path) -> None:
    env = {**os.environ, "CC": "false", "PKGEN_CACHE": str(tmp_path)}
    done = pkgen("run", HOOP, "--until", "1", env=env)
    assert done.returncode == 3, done.stderr
    done = pkgen("run", HOOP, "--until", "1", env={**env, "CC": "no-such-compiler"})
    assert done.returncode == 3 and "no-such-compiler" in done.stderr


def test_a_reader_that_goes_away(tmp_path: Path) -> None:
    command = f"{sys.executable} -m pkgen run {DOUBLE} --until 100 --every 0.001 | head -n 1"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("t,theta1") and "Traceback" not in done.stderr


def test_interrupt(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    command = [sys.executable, "-m", "pkgen", "run", str(DOUBLE), "--method", "gauss4"]
    child = subprocess.Popen(
        [*command, "--step", "1e-4", "--until", "1e6", "--every", "0.1", "-o", str(out)],
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (out.exists() and out.stat().st_size):
        assert child.poll() is None, child.stderr.read()
        time.sleep(0.05)
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    assert child.wait(timeout=20) == 130
    assert "Traceback" not in child.stderr.read()
    names, *table = csv.reader(out.read_text().splitlines())
    assert len(table) >= 1 and all(len(row) == len(names) for row in table)


def test_what_is_no_number_has_no_sign(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "root.lag"
    model = "model root\ncoord x\nkinetic x'^2/2\npotential x^2/2\n"
    path.write_text(model + "observe root = sqrt(x)\nstart x = 1\n")
    done = pkgen("run", path, "--until", "3", "--every", "0.5")
    assert done.returncode == 4 and "root is not finite" in done.stderr
    cells = [row.split(",")[3] for row in done.stdout.splitlines()]
    assert cells[0] == "root" and cells[1] == "1" and cells[-1] == "nan"
