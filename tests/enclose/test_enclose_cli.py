"""`pkgen run --enclose`: what it writes, what it refuses, how it ends early."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from conftest import ROOT, run_pkgen

pytest.importorskip("flint")

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
        (FREE + "coord y\nkinetic y'^2/2\nconstraint x + y = 1\n", ":7:", "constraints"),
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


def test_a_scene_is_taken_as_it_is_written() -> None:
    """3*m*g/l0 and 39.24 are one number as decimals, not as doubles."""
    options = ("--until", 1, "--every", 1, "--digits", 30)
    model = ROOT / "models/elastic_pendulum.lag"
    by_model = run_pkgen("run", model, "--enclose", *options, "--record", "s").stdout
    by_scene = run_pkgen(
        *("run", model, "--enclose", *options, "--record", "s", "--scene", "reference")
    ).stdout
    by_option = run_pkgen(
        *("run", model, "--enclose", *options, "--record", "s", "--set", "k=39.24")
    ).stdout
    last = [text.splitlines()[-1].split(",")[1][:30] for text in (by_model, by_scene, by_option)]
    assert last[0] == last[1] == last[2]


def test_without_the_library_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    from pkgen.analysis.enclose.domains import flint
    from pkgen.system.exits import UsageError

    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(UsageError, match="pip install"):
        flint()
