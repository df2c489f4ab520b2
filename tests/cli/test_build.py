"""`pkgen build`: a program of its own, with the options and files of `pkgen run`."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT, ran

DOUBLE = ROOT / "models/double_pendulum.lag"
HOOP = ROOT / "models/bead_on_hoop.lag"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from pkgen.__main__ import main

    path = tmp_path_factory.mktemp("build") / "double"
    assert main(["build", str(DOUBLE), "-o", str(path)]) == 0
    return path


def run(program: Path, *words: object, cwd: Path | None = None) -> subprocess.CompletedProcess:
    command = [str(program), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=60)


def rows(text: str) -> np.ndarray:
    return np.array([line.split(",") for line in text.splitlines()[1:]], float)


MOTION = ["--until", "3", "--every", "0.5", "--method", "dop853", "--rtol", "1e-10"]


def test_rows_are_those_of_run(pkgen, program: Path) -> None:
    more = ["--set", "m1=2 [kg]", "--start", "theta1=0.5", "--start", "theta2'=1 [rad/s]"]
    own, run_ = run(program, *MOTION, *more), pkgen("run", DOUBLE, *MOTION, *more)
    assert own.returncode == 0 and own.stdout.splitlines()[0] == run_.stdout.splitlines()[0]
    assert np.allclose(rows(own.stdout), rows(run_.stdout), rtol=1e-8, atol=1e-9)
    some = run(program, *MOTION, "--record", "theta2,energy").stdout
    assert some.startswith("t,theta2,energy\n")


def test_files_are_those_of_run(program: Path, tmp_path: Path) -> None:
    assert run(program, *MOTION, "-o", "out.csv", cwd=tmp_path).returncode == 0
    beside = json.loads((tmp_path / "out.csv.json").read_text())
    assert beside["report"]["status"] == "PK_DONE" and beside["columns"][1]["unit"] == "rad"
    assert run(program, *MOTION, "-o", "out.npy", cwd=tmp_path).returncode == 0
    array = np.load(tmp_path / "out.npy")
    assert array.dtype.names == tuple(c["name"] for c in beside["columns"])
    text = rows((tmp_path / "out.csv").read_text())
    assert (array["theta2"] == text[:, 2]).all() and not list(tmp_path.glob("*.partial"))
    whole = json.loads(run(program, *MOTION, "--json").stdout)
    assert (np.array(whole["rows"]) == text).all()


def test_an_ensemble_is_that_of_run(pkgen, program: Path, tmp_path: Path) -> None:
    table = tmp_path / "members.csv"
    table.write_text("theta1,m2\n0.1,1\n0.2,2\n0.3,3\n")
    own = run(program, *MOTION, "--ensemble", table)
    there = pkgen("run", DOUBLE, *MOTION, "--ensemble", table)
    assert np.allclose(rows(own.stdout), rows(there.stdout), rtol=1e-8, atol=1e-9)


def test_help_names_what_can_be_set(program: Path) -> None:
    said = run(program, "--help")
    assert said.returncode == 0 and "m1 [kg]" in said.stdout and "theta1' [rad/s]" in said.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "q=1"], "no such name"),
        (["--set", "m1=1 [m]"], "not a number in SI"),
        (["--set", "m1=-1"], "parameter m1 is outside its bounds"),
        (["--until", "nan"], "not a positive number"),
        (["--method", "what"], "no such method: what"),
        (["--record", "theta3"], "no such column"),
        (["--at", "noon"], "no such event"),
        (["--every"], "a value is missing"),
        (["--what", "1"], "no such option"),
        (["-o", "rows.txt"], ".csv or .npy"),
        (["-o", "nowhere/rows.csv"], "nowhere/rows.csv"),
        (["--ensemble", "nowhere.csv"], "cannot read nowhere.csv"),
        (["--method", "gsl_rkf45"], "no such method: gsl_rkf45; this was built without GSL"),
        (["--diagnose", "fortune"], "no such diagnostic"),
        (["--diagnose", "modes"], "in Python"),
    ],
)
def test_what_cannot_be_asked(program: Path, tmp_path: Path, words: list[str], said: str) -> None:
    done = run(program, *words, cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr and not list(tmp_path.iterdir())


def test_a_scene_is_its_defaults_and_a_program_may_be_static(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "hoop"
    ran("build", HOOP, "--scene", "balanced", "--static", "-o", path)
    own, there = run(path), pkgen("run", HOOP, "--scene", "balanced")
    assert np.allclose(rows(own.stdout), rows(there.stdout), rtol=1e-8, atol=1e-9)
    linked = subprocess.run(["ldd", str(path)], capture_output=True, text=True)
    assert "not a dynamic executable" in linked.stdout + linked.stderr


def test_no_gsl_unless_asked(program: Path) -> None:
    linked = subprocess.run(["ldd", str(program)], capture_output=True, text=True)
    assert "gsl" not in linked.stdout and "libm" in linked.stdout


def test_a_program_is_a_file(pkgen, tmp_path: Path) -> None:
    done = pkgen("build", DOUBLE, "-o", tmp_path)
    assert done.returncode == 2 and "it is a directory" in done.stderr
