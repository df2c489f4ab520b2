"""Runs that are left and gone on with are to the bit those that were never stopped."""

from __future__ import annotations

import ctypes
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import checkpoint_runs as runs
import numpy
import pytest

from conftest import wait_for
from pkgen.run.library import COMPUTE

GSLS_OWN = ("gsl_msadams", "gsl_msbdf", "gsl_bsimp")
QUICK = ("damped", "turning", "switched")


def compared(what, path: Path, dice: random.Random, most: int = 40) -> int:
    """How often it was left."""
    whole = runs.run(what)
    found, left = runs.chopped(what, path, dice, most)
    assert found == whole
    return left


NAMES = [*((name, 0.5) for name in QUICK), *((name, 3.0) for name in runs.MODELS)]


@pytest.fixture
def ck() -> Iterator[Path]:
    """A checkpoint where each is on the disk at once."""
    memory = "/dev/shm" if os.path.isdir("/dev/shm") else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        yield Path(folder) / "c"


@pytest.mark.parametrize("case", NAMES, ids=str)
def test_every_method_goes_on_to_the_bit(case: tuple, tmp_path: Path, ck: Path) -> None:
    """Left after random numbers of steps; the report is the same too."""
    name, until = case
    what = runs.of(name, tmp_path)
    dice, left, made = random.Random(name), 0, 0
    for method in runs.methods(what):
        one = runs.by(what, method, until=until, every=until / runs.ROWS)
        if not runs.run(one)[1]:  # the method is not for this model
            continue
        if method in GSLS_OWN:
            refused = runs.run(one, checkpoint=bytes(ck))
            assert refused[0] == 2 and "what it remembers of its steps is GSL's own" in refused[3]
            continue
        left += compared(one, ck, dice, 40 if until > 1 else 20)
        made += 1
    assert made > (2 if name == "noisy" else 20) and left > made  # three methods take noise


@pytest.mark.parametrize(
    "rows",
    [
        {"every": 0.0},
        {"at": 0},
        {"at": 1, "every": None},
        {"diagnose": ("spectrum",)},
        {"step": 2e-3},
    ],
    ids=str,
)
def test_rows_of_each_kind(rows: dict, tmp_path: Path, ck: Path) -> None:
    """At each step, or at events; those of diagnostics; and so many steps that looks at condition
    numbers are spread over them."""
    what = runs.of("events", tmp_path)
    for method in ("verlet", "rkmk4", "gauss4"):
        one = runs.by(what, method, **{"every": runs.UNTIL / 150, **rows})
        assert compared(one, ck, random.Random(method)) > 3


def test_blocks_of_coordinates(tmp_path: Path, ck: Path) -> None:
    (tmp_path / "b.lag").write_text(runs.BLOCKS)
    what = runs.prepared(runs.options(tmp_path / "b.lag", "--scene", "s"))
    assert len(what.settings.parts) == 2
    assert compared(what, ck, random.Random(1), 3) > 3


SWARM = """scene s
  swarm k = 1..{}
  start y = k/1000, x' = 0.3
  until 3
  method {}
  record x, y, energy every 0.5
  expect drift(energy) < 1e-3
  {}
end
"""


@pytest.mark.parametrize(
    "method, more, words",
    [
        ("verlet step 0.01", "", ()),
        ("dop853 rtol 1e-9", "expect time(section) < 9", ()),
        ("verlet step 0.01", "", ("--diagnose", "area")),
    ],
)
def test_members(method: str, more: str, words: tuple, tmp_path: Path, ck: Path) -> None:
    """In lanes, each by itself, and around a loop; a batch is 128 of two threads."""
    name = "events" if more else "free"
    path = tmp_path / f"{name}.lag"
    path.write_text(runs.text(name) + SWARM.format(1000, method, more))
    what = runs.prepared(runs.options(path, "--scene", "s", *words))
    assert compared(what, ck, random.Random(1), 1) > 3


def test_rows_in_a_file_are_cut_and_go_on(tmp_path: Path) -> None:
    """What was written behind the checkpoint is gone, whatever it was."""
    what = runs.by(runs.of("damped", tmp_path), "dop853")
    whole, path, ck = tmp_path / "a.csv", tmp_path / "b.csv", tmp_path / "c"
    with open(whole, "w+b") as file:
        assert runs.run(what, csv=file.fileno())[0] == 0
    left = {"checkpoint": bytes(ck), "checkpoint_after": 30}
    with open(path, "w+b") as file:
        assert runs.run(what, csv=file.fileno(), **left)[0] == 75
    before = path.read_bytes()
    assert 100 < len(before) < len(whole.read_bytes())
    for torn in (before + b"1,2,3\n4,", before):
        path.write_bytes(torn)
        with open(path, "r+b") as file:
            assert runs.run(what, csv=file.fileno(), checkpoint=bytes(ck), resume=1)[0] == 0
        assert path.read_bytes() == whole.read_bytes()
    for wrong in (before[:-1], before[:-2] + b"0\n", b"x" * 9999):
        path.write_bytes(wrong)
        with open(path, "r+b") as file:
            found = runs.run(what, csv=file.fileno(), checkpoint=bytes(ck), resume=1)
        assert found[0] == 2 and "the rows" in found[3] and path.read_bytes() == wrong


def test_a_pipe_gets_the_rows_that_follow(tmp_path: Path) -> None:
    what = runs.by(runs.of("damped", tmp_path), "dop853")
    command = [sys.executable, "-c", "import sys; sys.stdout.write(sys.stdin.read())"]
    texts = []
    for more in ({}, {"checkpoint_after": 30}, {"resume": 1}):
        ck = {"checkpoint": bytes(tmp_path / "c")} if more else {}
        with subprocess.Popen(command, stdin=-1, stdout=-1, text=True) as reader:
            runs.run(what, csv=reader.stdin.fileno(), **ck, **more)
            texts.append(reader.communicate()[0])
    assert texts[0] == texts[1] + texts[2] and texts[1] and texts[2]


def test_what_does_not_fit_is_refused(tmp_path: Path, ck: Path) -> None:
    what = runs.by(runs.of("damped", tmp_path), "dop853")
    left = {"checkpoint": bytes(ck), "checkpoint_after": 30}
    assert runs.run(what, **left)[0] == 75
    good = ck.read_bytes()
    assert int.from_bytes(good[20:24], sys.byteorder) == zlib.crc32(good[24:])

    def told(one=what) -> str:
        code, rows, _, said = runs.run(one, checkpoint=bytes(ck), resume=1)
        assert code == 2 and not rows
        return said

    assert "another setting: rtol" in told(runs.replace(
        what, settings=runs.replace(what.settings, rtol=2e-8)))  # fmt: skip
    assert "another setting: method" in told(runs.by(what, "dopri5"))
    assert "another setting: q" in told(runs.by(what, "dop853", start_q=((0, 0.5),)))
    assert "of another model" in told(runs.by(runs.of("free", tmp_path), "dop853"))
    dice = random.Random(1)
    for _ in range(40):
        at, bit = dice.randrange(len(good)), 1 << dice.randrange(8)
        ck.write_bytes(good[:at] + bytes([good[at] ^ bit]) + good[at + 1 :])
        assert "cannot go on from" in told()
    for part in (b"", good[:20], good[:-1], good + b"\0", good[:3000]):
        ck.write_bytes(part)
        assert "cannot go on from" in told()
    ck.unlink()
    assert "No such file" in told()
    ck.mkdir()
    assert "it is no file" in told()


def test_inputs_that_are_computed_are_settings(tmp_path: Path, ck: Path) -> None:
    """A run with other times of its inputs, or without them, does not go on from a checkpoint."""
    what = runs.by(runs.of("damped", tmp_path), "rk4")
    compute = COMPUTE(lambda context, t, stop: 0)

    def inputs(*times: float, only: int = 0) -> dict[str, object]:
        numbers = [(ctypes.c_double * 16)(*x) for x in (times, (), (1.0,))]
        stops, seen, computed = (ctypes.cast(x, ctypes.POINTER(ctypes.c_double)) for x in numbers)
        found = {"compute": compute, "only_stops": only, "n_stops": len(times), "stops": stops}
        return {**found, "seen": seen, "computed": computed}

    left = {"checkpoint": bytes(ck), "checkpoint_after": 30}
    assert runs.run(what, **left, **inputs(0.0, 1.0))[0] == 75

    def resumed(**more: object) -> tuple[int, str]:
        code, _, _, said = runs.run(what, checkpoint=bytes(ck), resume=1, **more)
        return code, said

    assert "another setting: compute" in resumed()[1]
    assert "another setting: stops" in resumed(**inputs(0.0, 1.5))[1]
    assert "another setting: only_stops" in resumed(**inputs(0.0, 1.0, only=1))[1]
    assert resumed(**inputs(0.0, 1.0))[0] == 0


def started(folder: Path, *words: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "pkgen", *words], cwd=folder, stderr=-1, stdout=-1, text=True
    )


def ended(process: subprocess.Popen, ck: Path, number: int) -> int:
    """Its code after the signal, sent when there is a checkpoint."""
    wait_for(lambda: ck.exists() or process.poll() is not None)
    process.send_signal(number)
    process.communicate()
    return process.returncode


@pytest.mark.parametrize("kind", ["csv", pytest.param("npy", marks=pytest.mark.long)])
def test_the_command_line(kind: str, pkgen, tmp_path: Path) -> None:
    (tmp_path / "m.lag").write_text(runs.text("free"))
    words = ["m.lag", "--until", "15000", "--every", "5", "--method", "gauss4", "--step", "0.05"]
    assert pkgen("run", *words, "--units", "-o", f"a.{kind}", cwd=tmp_path).returncode == 0
    keep = ["--units", "-o", f"b.{kind}", "--checkpoint", "c", "--checkpoint-every", "0.05"]
    ck = tmp_path / "c"
    assert ended(started(tmp_path, "run", *words, *keep), ck, signal.SIGUSR1) == 75
    again = pkgen("run", *words, *keep, cwd=tmp_path)
    assert again.returncode == 2 and "`pkgen resume c` goes on from it" in again.stderr
    assert ended(started(tmp_path, "resume", "c"), ck, signal.SIGKILL) == -signal.SIGKILL
    assert pkgen("resume", tmp_path / "c").returncode == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *(f"{x}.{kind}{end}" for x in "ab" for end in ("", ".json")),
        "m.lag",
    ]
    a, b = ((tmp_path / f"{x}.{kind}").read_bytes() for x in "ab")
    assert a == b and len(a) > 10000
    reports = [json.loads((tmp_path / f"{x}.{kind}.json").read_text())["report"] for x in "ab"]
    for report in reports:
        assert report.pop("seconds") > 0 and report.pop("processor") > 0
    assert reports[0] == reports[1]
    if kind == "npy":
        assert len(numpy.load(tmp_path / "b.npy")) == 3001
