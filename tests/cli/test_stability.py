"""`pkgen stability` as a user meets it: maps, files, usage."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import time
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from conftest import case, no_page, written
from pkgen.__main__ import main
from pkgen.analysis.stability import measure
from pkgen.cli import stability as command
from pkgen.system.exits import NumericsFailed

# matplotlib warns where labels have no room.
pytestmark = pytest.mark.filterwarnings("error")

PENDULUM = case("stability_pendulum")


@pytest.fixture
def stability(capsys):
    """The command in this process: importing pkgen takes longer than a small map."""

    def run(*arguments: object) -> SimpleNamespace:
        code = main(["stability", *map(str, arguments)])
        out, err = capsys.readouterr()
        return SimpleNamespace(code=code, out=out, err=err)

    return run


@pytest.fixture(scope="module")
def quick(tmp_path_factory) -> tuple[dict, Path]:
    """A quick map of the pendulum on both sides of Verlet's limit, as a user makes it."""
    directory = tmp_path_factory.mktemp("stability")
    model = written(directory, PENDULUM)
    said = io.StringIO()
    words = "--methods verlet,rk4 --vary theta=0.001..0.002 --steps 1.98..2.02 --points 2x2"
    with contextlib.redirect_stdout(said):
        given = ["stability", str(model), "-o", str(directory), "--json", *words.split()]
        assert main(given) == 0
    return json.loads(said.getvalue()), directory


def test_a_map_is_bounded_below_and_growing_above(quick) -> None:
    made, _ = quick
    verlet = {(p["h"], p["x"]): p["kind"] for p in made["points"] if p["method"] == "verlet"}
    assert len(verlet) == 4
    for (h, _), kind in verlet.items():
        assert kind == ("bounded" if h < 2 else "growing")
    limit_ = next(
        p for p in made["predictions"] if p["method"] == "verlet" and p["kind"] == "limit"
    )
    assert limit_["h"] == pytest.approx(2, rel=1e-9)
    assert limit_["measured"] == pytest.approx(2, rel=1e-4)
    assert all(m["kind"] == "response" for m in made["misses"]), made["misses"]


PAGE = () if no_page() else (".html",)  # the add-on that writes it may be missing


def test_files(quick) -> None:
    made, directory = quick
    assert {Path(f).suffix for f in made["files"]} == {".svg", ".png", ".csv", *PAGE}
    with open(directory / "pendulum_stability.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8 and rows[0]["method"] == "verlet"
    assert [float(r["h"]) for r in rows] == [p["h"] for p in made["points"]]
    assert {r["class"] for r in rows} == {p["kind"] for p in made["points"]}
    picture = (directory / "pendulum_stability.svg").read_text()
    assert "verlet" in picture and "limit" in picture


@pytest.mark.needs_addon("pages")
def test_the_page(quick) -> None:
    page = (quick[1] / "pendulum_stability.html").read_text()
    assert page.count("<svg") == 1 and "Predicted and measured" in page
    for outside in ("src=", 'href="http', "url(http", "@import", "<script", "<link"):
        assert outside not in page


KEPLER = case("stability_kepler")


def test_without_an_equilibrium_the_rates_are_varied(stability, tmp_path: Path) -> None:
    model = written(tmp_path, KEPLER.format(e=0.0))
    asked = ["--methods", "verlet", "-o", tmp_path, "--points", "3x2", "--until", "20"]
    done = stability(model, *asked)
    assert done.code == 0 and "2 values of rates," in done.out, done.err
    done = stability(model, *asked, "--vary", "y'=0.9..1.6", "--steps", "0.01..0.1")
    assert done.code == 0, done.err
    # At y' = 1.6 it flies away.
    assert "not judged" in done.out and "leaves in 1 of 2 rows" in done.out


@pytest.mark.parametrize("e", [0.5, 0.9])
def test_an_orbit_has_a_scale(stability, tmp_path: Path, e: float) -> None:
    """At the pericentre r = 1 - e the attraction grows at sqrt(2/r^3): Verlet's limit over it."""
    model = written(tmp_path, KEPLER.format(e=e))
    asked = ["--methods", "verlet,gauss1", "-o", tmp_path, "--points", "2x3", "--until", "13"]
    done = stability(model, *asked, "--json")
    assert done.code == 0, done.err
    found = {p["method"]: p for p in json.loads(done.out)["predictions"]}
    for p in found.values():
        assert p["kind"] == "local" and p["sharp"] is False and p["equilibrium"] is None
        assert p["h"] == pytest.approx(2 * (1 - e) ** 1.5 / math.sqrt(2), rel=0.01)
        assert 0.5 < p["measured"] / p["h"] < 2


def test_progress_shows_from_the_start(stability, tmp_path: Path, monkeypatch) -> None:
    said: list[tuple[float, str]] = []
    monkeypatch.setattr(command, "progress", lambda _: nullcontext(lambda *now: said.append(now)))
    model = written(tmp_path, PENDULUM)
    asked = ["--methods", "rk4", "--points", "2x2", "--until", "9", "-o", tmp_path]
    done = stability(model, *asked)
    assert done.code == 0 and done.err == no_page()
    parts = [part for part, _ in said]
    assert said[:2] == [(0.0, "compiling"), (0.0, "equilibria")]
    assert parts == sorted(parts) and parts[-1] == 1 and len(set(parts)) > 3


def test_a_parameter_moves_the_limit(stability, tmp_path: Path) -> None:
    model = written(
        tmp_path,
        "model spring\nparam k = 1\ncoord x\nkinetic x'^2/2\npotential k/2*x^2\nstart x = 1\n",
    )
    asked = [
        *["--vary", "k=1..4", "--points", "20x4", "--methods", "verlet", "-o"],
        tmp_path,
        "--json",
    ]
    done = stability(model, *asked)
    assert done.code == 0, done.err
    made = json.loads(done.out)
    for row in made["rows"]:
        (line,) = (p for p in row["predictions"] if p["kind"] == "limit")
        assert line["h"] == pytest.approx(2 / math.sqrt(row["x"]), rel=1e-9)
    points = made["points"]
    for p in points:
        y = p["h"] * math.sqrt(p["x"])
        if abs(y - 2) > 0.02:
            assert (p["kind"] == "bounded") == (y < 2), p
    assert any(p["kind"] == "bounded" for p in points)


def test_small_energies_are_said(stability, tmp_path: Path) -> None:
    model = written(
        tmp_path,
        "model mems\nparam d = 1e-6\ncoord x\nkinetic 1e-12*x'^2/2\n"
        "potential -x^2/2 + x^4/(4*d^2)\nstart x = 1.2e-6\n",
    )
    asked = ["--methods", "verlet", "--points", "2x2", "--until", "1e-4", "-o", tmp_path]
    done = stability(model, *asked)
    assert done.code == 0, done.err
    assert "x = -1e-06" in done.out and "-2.5e-13" in done.out and "x = 0 " in done.out


def test_what_fails_ends_all(stability, tmp_path: Path, monkeypatch) -> None:
    rows = []

    def failing(*_: object) -> None:
        rows.append(1)
        if len(rows) > 1:
            time.sleep(0.05)
        raise NumericsFailed("no more")

    monkeypatch.setattr(measure, "row", failing)
    model = written(tmp_path, PENDULUM)
    done = stability(model, "-o", tmp_path, "--methods", "rk4", "--points", "2x60")
    assert done.code == 4 and "no more" in done.err
    assert len(rows) < 30
