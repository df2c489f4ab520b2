"""Data files that are not as they say: one line that names the file, never a traceback."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from conftest import seeds
from pkgen.__main__ import main

MODEL = "model p\ncoord a\nkinetic a'^2/2\npotential -cos(a)\nstart a = 1\n"
PLAN = "until = 1\nmembers = 4\nstep = 0.1\nmethod = 'rk4'\n[random]\na = '0 .. 1'\n"
HEAD = "{'descr': [('t','<f8'),('x','<f8')], 'fortran_order': False, 'shape': (1000000000000,), }"
NPY = b"\x93NUMPY\x01\x00v\x00" + HEAD.ljust(117).encode() + b"\n" + bytes(16)
PARQUET = b"PAR1" + b"\xff" * 40 + b"\x15\x04\x15\x00" * 8 + b"\x20\x00\x00\x00PAR1"
FILES = {
    "plan.toml": ("sweep m.lag -o d --plan", PLAN.replace("4", "9" * 5000, 1).encode()),
    "deep.toml": ("sweep m.lag -o d --plan", b"x = " + b"[" * 9999),
    "rows.npy": ("plot -o a.svg", NPY),
    "short.npy": ("plot -o a.svg", NPY[:60]),
    "members.parquet": ("run m.lag --until 1 --ensemble", PARQUET),
    "none.parquet": ("run m.lag --until 1 --ensemble", b""),
}


OF_SWEEP = pytest.mark.needs_addon("sweep")
SWEPT = [pytest.param(n, marks=OF_SWEEP) if n.endswith("toml") else n for n in FILES]


@pytest.mark.parametrize("name", SWEPT)
def test_a_file_that_is_broken_is_named(name: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    words, data = FILES[name]
    Path("m.lag").write_text(MODEL)
    Path(name).write_bytes(data)
    assert main([*words.split(), name]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"pkgen: {name}: ") and said.count("\n") == 1 and "internal" not in said


WRONG = ['"size": -1', '"size": [1]', '"members": -1', '"shard": "x"', '"digest": 1', '"model": {}']


@OF_SWEEP
@pytest.mark.parametrize("wrong", WRONG)
def test_a_plan_json_of_other_kinds_is_refused(wrong: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.lag").write_text(MODEL)
    Path("plan.toml").write_text(PLAN)
    assert main(["sweep", "m.lag", "--plan", "plan.toml", "-o", "d"]) == 0
    text = Path("d/plan.json").read_text().rstrip().removesuffix("}")
    Path("d/plan.json").write_text(f"{text}, {wrong}}}")  # the last of a name holds
    for words in ("sweep --resume d", "sweep --status d", "sweep m.lag --plan plan.toml -o d"):
        capsys.readouterr()
        assert main(words.split()) == 2
        assert "d/plan.json: it is not as it was written" in capsys.readouterr().err


def _valid(folder: Path) -> dict[str, str]:
    """Files that are right, each with the command that reads it."""
    import numpy
    from pyarrow import parquet, table

    rows = numpy.array([(0.0, 1.0), (0.5, 2.0)], dtype=[("t", float), ("a", float)])
    numpy.save(folder / "rows.npy", rows)
    (folder / "rows.csv").write_text("t,a\n0,1\n0.5,2e3\n1,-3\n")
    (folder / "members.csv").write_text("a,a'\n0,1\n0.5,2e-3\n")
    parquet.write_table(table({"a": [0.0, 0.5], "a'": [1.0, 2.0]}), folder / "members.parquet")
    (folder / "plan.toml").write_text(PLAN)
    (folder / "mine.tab").write_text("0 |\n1/2 | 1/2\n-----\n | 0 1\n")
    assert main(["sweep", "m.lag", "--plan", "plan.toml", "-o", "d"]) == 0
    return {
        "plan.toml": "sweep m.lag -q -o e --plan plan.toml",
        "d/plan.json": "sweep --status d",
        "rows.npy": "plot rows.npy -o a.svg",
        "rows.csv": "plot rows.csv -o a.svg",
        "members.csv": "run m.lag --until 1 --ensemble members.csv",
        "members.parquet": "run m.lag --until 1 --ensemble members.parquet",
        "mine.tab": "run m.lag --until 1 --step 0.1 --tableau mine.tab",
    }


def _mutated(dice: random.Random, data: bytes) -> bytes:
    for _ in range(dice.randint(1, 3)):
        at, end = sorted(dice.randrange(len(data) + 1) for _ in range(2))
        some = dice.choice(
            (b"", b"\0", b"\xff" * 4, b"9" * 400, b"-", b"[", b'"', data[at:end] * 2)
        )
        data = data[:at] + some + data[dice.choice((at, min(at + len(some), len(data)), end)) :]
    return data


@OF_SWEEP
@pytest.mark.parametrize("seed", seeds([1, 0, 2], 37))
def test_no_mutation_of_a_file_is_an_internal_error(seed, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.lag").write_text(MODEL)
    dice = random.Random(seed)
    for name, words in _valid(tmp_path).items():
        whole = Path(name).read_bytes()
        for _ in range(4):
            data = _mutated(dice, whole)
            Path(name).write_bytes(data)
            capsys.readouterr()
            code, said = main(words.split()), capsys.readouterr().err
            assert code in (0, 1, 2, 4) and "internal" not in said, (name, data, said)
        Path(name).write_bytes(whole)
