"""`pkgen run --ensemble`: members as single runs, what files may say, what wrong ones are told."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from conftest import ROOT, ran, table, written

DOUBLE = ROOT / "models/double_pendulum.lag"


@pytest.fixture
def ensemble(tmp_path: Path):
    def write(text: str, name: str = "members.csv") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_final_states_alone_by_any_number_of_threads(pkgen, ensemble, tmp_path: Path) -> None:
    many = "".join(f"{0.01 * i},{1 + i % 7}\n" for i in range(200))
    path = ensemble("theta1,m1\n" + many)
    options = ["--ensemble", path, "--method", "rk4", "--step", "0.01", "--until", "1"]
    said = [pkgen("run", DOUBLE, *options, "--threads", n).stdout for n in ("1", "2", "5")]
    assert said[0] == said[1] == said[2]
    assert [row[:2] for row in table(said[0])[1]] == [[i + 1, 1] for i in range(200)]
    done = pkgen("run", DOUBLE, *options, "-o", tmp_path / "out.csv")
    assert done.returncode == 0 and (tmp_path / "out.csv").read_text() == said[0]
    beside = json.loads((tmp_path / "out.csv.json").read_text())
    assert beside["columns"][0]["name"] == "member" and beside["settings"]["ensemble"] == path.name
    report = beside["report"]
    assert (report["members"], report["done"], report["failed"]) == (200, 200, 0)
    assert report["step"] == 0.01 and report["rows"] == 200


def test_families_and_inputs_are_named_as_in_set(pkgen, ensemble, tmp_path: Path) -> None:
    model = written(
        tmp_path,
        "model pushed\nsize N = 2\nparam k = 1\ncoord q[1..N]\ninput u\n"
        "kinetic sum(q[i]'^2/2, i = 1..N)\npotential k*sum(q[i]^2/2, i = 1..N)\nforce q[1] = u\n",
    )
    path = ensemble('"q[1]","q[2]\'",u\n0.5,1,0\n\n0.5,1,2\n')
    options = ["--method", "verlet", "--step", "0.01", "--until", "1"]
    done = ran("run", model, "--ensemble", path, *options)
    rows = table(done.stdout)[1]
    alone = ["--start", "q[1]=0.5", "--start", "q[2]'=1", "--set", "u=2"]
    assert rows[1][1:] == table(pkgen("run", model, *alone, *options).stdout)[1][-1]
    assert rows[0][2] != rows[1][2] and rows[0][3] == rows[1][3]


def test_a_member_that_fails_is_told_and_the_others_go_on(pkgen, ensemble, tmp_path) -> None:
    model = tmp_path / "heavy.lag"
    # L = (1 - q) q'^2/2: singular where q reaches 1.
    model.write_text("model heavy\ncoord q\nkinetic (1 - q)*q'^2/2\nstart q' = 0.5\n")
    path = ensemble("q,q'\n" + "0.1,0.1\n" * 70 + "0.9,0.5\n0.1,0.2\n0.8,0.6\n")
    options = ["--ensemble", path, "--method", "rk4", "--step", "0.001", "--until", "0.5"]
    done = pkgen("run", model, *options, "-o", tmp_path / "x.csv")
    assert done.returncode == 4
    assert "2 of 73 members failed, first member 71: the coordinates are singular" in done.stderr
    assert "last valid time 0." in done.stderr
    there = [row[0] for row in table((tmp_path / "x.csv").read_text())[1]]
    assert {*there} == {*range(1, 74)} - {71, 73}
    report = json.loads((tmp_path / "x.csv.json").read_text())["report"]
    assert (report["done"], report["failed"], report["first_failed"]["member"]) == (71, 2, 71)
    assert report["first_failed"]["status"] == "PK_SINGULAR_COORDINATES"


def test_files_of_other_systems_are_read(pkgen, ensemble) -> None:
    options = ["--method", "rk4", "--step", "0.1", "--until", "1", "--ensemble"]
    plain = pkgen("run", DOUBLE, *options, ensemble("theta1,m1\n1,2\n"))
    other = pkgen("run", DOUBLE, *options, ensemble('\ufeff"theta1",m1\r\n" 1",2\r\n', "other.csv"))
    assert plain.returncode == 0 and other.stdout == plain.stdout


def test_without_openmp_there_is_one_thread(pkgen, ensemble, tmp_path: Path) -> None:
    """A compiler that cannot link OpenMP still runs ensembles; a new cache is filled, and used."""
    compiler = tmp_path / "cc"
    compiler.write_text('#!/bin/sh\nfor x; do [ "$x" = -fopenmp ] && exit 1; done\nexec gcc "$@"\n')
    compiler.chmod(0o755)
    env = {**os.environ, "CC": str(compiler), "PKGEN_CACHE": str(tmp_path / "cache")}
    path = ensemble("theta1\n1\n2\n")
    options = ["--ensemble", path, "--method", "rk4", "--step", "0.1", "--until", "1"]
    for _ in range(2):
        done = ran("run", DOUBLE, *options, "--threads", "2", env=env)
        assert len(list((tmp_path / "cache" / "models").iterdir())) == 1
    assert done.stdout == pkgen("run", DOUBLE, *options).stdout
