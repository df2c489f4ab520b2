"""Data files that are not as they say: one line that names the file, never a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest
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


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_broken_is_named(name: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    words, data = FILES[name]
    Path("m.lag").write_text(MODEL)
    Path(name).write_bytes(data)
    assert main([*words.split(), name]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"pkgen: {name}: ") and said.count("\n") == 1 and "internal" not in said


WRONG = ['"size": -1', '"size": [1]', '"members": -1', '"shard": "x"', '"digest": 1', '"model": {}']


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
