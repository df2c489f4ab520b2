"""`pkgen run --enclose`: what it writes, what it refuses, how it ends early."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen

pytest.importorskip("flint")
from mpmath import mp, mpf

BEAD = ROOT / "models/bead_on_hoop.lag"
FREE = "model m\ncoord x\nkinetic x'^2/2\nstart x = 1\n"


def said(path: Path, *options: object, code: int = 2) -> str:
    done = run_pkgen("run", path, "--enclose", *options)
    assert done.returncode == code, done.stderr
    return done.stderr


@pytest.mark.parametrize(
    ("text", "place", "word"),
    [
        (FREE + "potential abs(x)\n", ":5:", "abs()"),
        (FREE + "potential max(x, 0)^3\n", ":5:", "max()"),
        (FREE + "input u\nforce x = u\n", ":5:", "'u' is an input"),
        (FREE + "event e: x - 2 stop\n", ":5:", "stops the run"),
    ],
)
def test_what_has_no_bounds_is_refused(text: str, place: str, word: str, tmp_path: Path) -> None:
    (tmp_path / "m.lag").write_text(text)
    message = said(tmp_path / "m.lag")
    assert f"m.lag{place}" in message and word in message and "--enclose" in message


@pytest.mark.parametrize(
    "options",
    [
        ("--method", "rk4"),
        ("--rtol", "1e-9"),
        ("--diagnose", "all"),
        ("--plot", "a.svg"),
        ("-o", "a.npy"),
        ("--digits", "0"),
        ("--digits", "many"),
    ],
)
def test_options_that_mean_nothing_here_are_refused(options: tuple[str, ...]) -> None:
    assert options[0] in said(BEAD, *options)


def test_digits_are_for_bounds() -> None:
    done = run_pkgen("run", BEAD, "--digits", "20")
    assert done.returncode == 2 and "--enclose" in done.stderr


@pytest.mark.long
def test_bounds_that_end_early_say_so(tmp_path: Path) -> None:
    """x' = x^2 from 1 is 1/(1 - t)."""
    (tmp_path / "m.lag").write_text("model m\nstate x\nrate x = x^2\nstart x = 1\n")
    options = ("--until", 2, "--every", 0.25, "--digits", 8)
    done = run_pkgen("run", tmp_path / "m.lag", "--enclose", *options)
    assert done.returncode == 4 and "the bounds end at t = 0.75, before 2" in done.stderr
    assert done.stdout.splitlines()[-1].startswith("0.75,4")


def test_what_is_written(tmp_path: Path) -> None:
    options = ("--until", 0.5, "--every", 0.25, "--record", "theta,x")
    file = tmp_path / "rows.csv"
    assert "certified: " in said(BEAD, *options, "-o", file, code=0)
    done = run_pkgen("run", BEAD, "--enclose", *options, "--json")
    found = json.loads(done.stdout)
    assert found["status"] == "done" and found["t"] == "0.5" and found["digits"]["certified"] >= 15
    assert found["columns"] == ["t", "theta", "radius(theta)", "x", "radius(x)"]
    rows = [line.split(",") for line in file.read_text().splitlines()]
    assert rows == [found["columns"], *found["rows"]]
    assert [row[0] for row in rows[1:]] == ["0", "0.25", "0.5"]


def test_numbers_are_the_decimals_that_are_written(tmp_path: Path) -> None:
    """In a model, a scene and an option; the double 1.1 is another number, and so would x be."""
    scene = "scene s\nset k = 1.1\nend\n"
    force = "param j = 1.1\nparam k = 3*j/3\npotential k*x^2/2\n"
    (tmp_path / "m.lag").write_text(FREE + force + scene)
    texts = [
        run_pkgen("run", tmp_path / "m.lag", "--enclose", "--until", "1", "--digits", "30", *more)
        for more in ((), ("--scene", "s"), ("--set", "k=1.1"), ("--set", "j=1.1"))
    ]
    last = [done.stdout.splitlines()[-1].split(",")[1] for done in texts]
    mp.dps = 40
    x = mp.cos(mp.sqrt(mpf(11) / 10))
    assert all(abs(mpf(text) - x) < mpf(10) ** -30 for text in last)
    assert abs(mp.cos(mp.sqrt(mpf(1.1))) - x) > mpf(10) ** -18


def test_without_the_library_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    from pkgen.system.exits import UsageError
    from pkgen_enclose.domains import flint

    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(UsageError, match="pip install"):
        flint()
