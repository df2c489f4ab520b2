"""Bad input of `pkgen plot` and `run --plot`: a message that says what, exit code 2, no file."""

import json
import os
from pathlib import Path

import numpy
import pytest

from conftest import ROOT, ran, run_pkgen

PENDULUM = ROOT / "models/pendulums/pendulum.lag"
GOOD = "t,theta,theta'\n" + "".join(f"{k},{k},{k}\n" for k in range(20))
# Of a file: its bytes, and what is said.
FILES = {
    "empty.csv": (b"", "empty"),
    "blank.csv": (b"\n\n", "empty"),
    "headless.csv": (b"0,1\n1,2\n", "numbers where names"),
    "norows.csv": (b"t,x\n", "no rows"),
    "ragged.csv": (b"t,x\n0,1\n1\n", "ragged.csv:3: 1 values where its head has 2"),
    "words.csv": (b"t,x\n0,1\n1,one\n", "words.csv:3: column x: 'one' is no number"),
    "twice.csv": (b"t,x,x\n0,1,2\n", "column x stands there twice"),
    "nameless.csv": (b"t,,x\n0,1,2\n", "has no name"),
    "latin.csv": (b"t,\xe9\n0,1\n", "UTF-8"),
    "nul.csv": (b"t,x\n0,\0\n", "nul.csv"),
    "alone.csv": (b"t\n0\n1\n", "no column beside t"),
    "not.npy": (b"text", "no file of NumPy"),
    "cut.npy": (b"\x93NUMPY\x01\x00", "no file of NumPy"),
    "old.csv.partial": (b"t,x\n0,1\n1,one\n", "is no number"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_no_rows(name: str, tmp_path: Path) -> None:
    content, said = FILES[name]
    (tmp_path / name).write_bytes(content)
    done = run_pkgen("plot", name, "-o", "x.svg", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert said in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "x.svg").exists()


def test_arrays_without_names(tmp_path: Path) -> None:
    objects = numpy.array([{}, {}], dtype=object)
    for array in (numpy.zeros((3, 2)), numpy.zeros(3), objects):
        numpy.save(tmp_path / "a.npy", array, allow_pickle=True)
        done = run_pkgen("plot", "a.npy", cwd=tmp_path)
        assert done.returncode == 2 and "a.npy: " in done.stderr, done.stderr
    numpy.save(tmp_path / "a.npy", numpy.zeros(3, dtype=[("t", float), ("s", "U3")]))
    done = run_pkgen("plot", "a.npy", cwd=tmp_path)
    assert done.returncode == 2 and "not all of numbers" in done.stderr


# Options behind a file of t, theta, theta', and what is said.
OPTIONS = [
    (("--columns", "thetta"), "did you mean 'theta'"),
    (("--phase", "thet"), "--phase thet: rows.csv has no such column; did you mean 'theta'"),
    (("--phase", "a,b,c"), "two names"),
    (("--path", "theta"), "two or three names"),
    (("--path", "a,b,c,d"), "two or three names"),
    (("--spectrum", "omega"), "no such column"),
    (("--columns", "theta,,x"), "give names"),
    (("--columns", "theta,theta"), "given twice"),
    (("--columns", ""), "give names"),
    (("--phase", "theta", "--drift"), "one picture at a time"),
    (("--phase", "theta", "--columns", "theta"), "one picture at a time"),
    (("--drift",), "has no energy"),
    (("--width", "3"), "from 40 to 1000 mm"),
    (("--width", "nan"), "from 40 to 1000 mm"),
    (("--until", "3"), "--until is of a run"),
    (("--set", "g=1"), "--set is of a run"),
    (("-o", "x.gif"), "must end in .svg, .png or .pdf"),
    (("-o", "x"), "must end in .svg, .png or .pdf"),
    (("--phse", "theta"), "did you mean '--phase'"),
    (("nothere.csv",), "nothere.csv: No such file"),
    (("there",), "there"),
]


@pytest.mark.parametrize("words, said", OPTIONS, ids=[" ".join(w) for w, _ in OPTIONS])
def test_options(words: tuple, said: str, tmp_path: Path) -> None:
    (tmp_path / "rows.csv").write_text(GOOD)
    (tmp_path / "there").mkdir()
    done = run_pkgen("plot", "rows.csv", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert said in done.stderr and "Traceback" not in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["rows.csv", "there"]


MODEL = [
    (("--path", "x,yy"), 2, "--path yy: the model has no such column"),
    (("--phase", "thetta"), 2, "did you mean 'theta'"),
    (("--scene", "loopp"), 2, "did you mean 'loop'"),
    (("--at", "lowes"), 2, "did you mean 'lowest'"),
    (("--record", "theta", "--phase", "theta"), 2, "--record leaves it out"),
    (("--set", "m=-1"), 2, "m"),
    (("--spectrum", "theta", "--scene", "loop"), 2, "one motion is needed"),
]


@pytest.mark.parametrize("words, code, said", MODEL, ids=[" ".join(w[0]) for w in MODEL])
def test_models(words: tuple, code: int, said: str, tmp_path: Path) -> None:
    done = run_pkgen("plot", PENDULUM, *words, "-o", "x.svg", cwd=tmp_path)
    assert done.returncode == code and said in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_wrong_models_are_told_as_everywhere(write, tmp_path: Path) -> None:
    wrong = write("model wrong\ncoord x\nkinetic x'^2/2 + yy\n")
    done = run_pkgen("plot", wrong)
    assert done.returncode == 1 and "wrong.lag:3:18: error" in done.stderr
    assert run_pkgen("plot", tmp_path / "none.lag").returncode == 2
    assert run_pkgen("plot").returncode == 2


RUN = [
    (("--phase", "theta"), "--phase is of a picture: --plot FILE.svg"),
    (("--plot", "x.jpg"), "must end in .svg, .png or .pdf"),
    (("--plot", "x.svg", "--path", "x,yy"), "--path yy"),
    (("--plot", "there/x.svg"), "there/x.svg"),
    (("--report", "x.htm"), "must end in .html"),
    (("--plot", "x.svg", "--columns", "aa"), "--columns aa"),
]


@pytest.mark.parametrize("words, said", RUN, ids=[" ".join(w) for w, _ in RUN])
def test_run(words: tuple, said: str, tmp_path: Path) -> None:
    done = run_pkgen("run", PENDULUM, *words, cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_rows_that_go_into_a_pipe_cannot_be_read_again(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "rows.csv")
    words = ("-o", "rows.csv", "--plot", "x.svg")
    done = run_pkgen("run", PENDULUM, *words, cwd=tmp_path)
    assert done.returncode == 2 and "not a pipe" in done.stderr


def test_what_stands_beside_is_not_trusted(tmp_path: Path) -> None:
    """Rows are drawn without it, and that is said."""
    (tmp_path / "rows.csv").write_text(GOOD)
    beside = tmp_path / "rows.csv.json"
    wrong = ("", "{", "[]", "{}", '{"columns": 3}', '{"columns": [{"name": 1}]}', "[" * 99999)
    for text in wrong:
        beside.write_text(text)
        done = run_pkgen("plot", "rows.csv", "-o", "x.svg", cwd=tmp_path)
        assert done.returncode == 0 and "rows.csv.json: " in done.stderr, done.stderr
    names = [{"name": n, "unit": "m", "description": ""} for n in ("t", "theta", "theta'")]
    odd = ({"settings": 3}, {"report": []}, {"settings": {"at": 7}}, {"report": {"drifts": 1}})
    for more in odd:
        beside.write_text(json.dumps({"columns": names, **more}))
        for words in ((), ("--drift", "--columns", "theta")):
            done = ran("plot", "rows.csv", *words, "-o", "x.svg", cwd=tmp_path)


def test_a_picture_is_replaced_whole(tmp_path: Path) -> None:
    (tmp_path / "rows.csv").write_text(GOOD)
    target = tmp_path / "x.svg"
    target.write_text("old")
    assert run_pkgen("plot", "rows.csv", "--phase", "no", "-o", target, cwd=tmp_path).returncode
    assert target.read_text() == "old"
    os.symlink("x.svg", tmp_path / "link.svg")
    assert run_pkgen("plot", "rows.csv", "-o", "link.svg", cwd=tmp_path).returncode == 0
    assert target.read_text().startswith("<?xml") and (tmp_path / "link.svg").is_symlink()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link.svg", "rows.csv", "x.svg"]


def test_a_run_that_fails_is_drawn_as_far_as_it_came(write, tmp_path: Path) -> None:
    model = write(
        "model fall\ncoord x [m]\nkinetic (1 [kg])*x'^2/2\npotential -(1 [J*m])/x\nstart x = 1\n"
    )
    done = run_pkgen("plot", model, "-o", "x.svg", cwd=tmp_path)
    assert done.returncode == 4 and "vanishes" in done.stderr
    assert "as far as it came" in (tmp_path / "x.svg").read_text()
    done = run_pkgen("plot", model, "--start", "x=0", "-o", "y.svg", cwd=tmp_path)
    assert done.returncode in (2, 4) and not (tmp_path / "y.svg").exists()
    assert "Traceback" not in done.stderr
