"""`state` and `rate` at the command line: rows, starts, options, other commands."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case, ran, written

# Of an orbit from its pericentre: the action of a revolution is that of T - V, whose means are a
# half and 1 by the virial theorem, and the area is that of the ellipse.
ORBIT = case("orbit")
# Its sums of logarithms are constant; no coordinate, so no energy.
LOTKA = case("lotka")


@pytest.fixture
def orbit(tmp_path: Path) -> Path:
    return written(tmp_path, ORBIT)


@pytest.mark.needs_addon("pages")
def test_on_the_page(pkgen, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert pkgen("explain", written(tmp_path, LOTKA), "--html", page).returncode == 0
    assert "Rates of the states" in page.read_text(encoding="utf-8")


def test_the_chart_has_states(tmp_path: Path) -> None:
    """One state beside one coordinate: three numbers, of which one is a place."""
    text = "model q\ncoord x\nstate s\nkinetic x'^2/2\npotential x^2/2 + x^4/10\n"
    model = written(tmp_path, text + "rate s = x - s\nstart x = 1\n")
    done = ran(
        "chart",
        model,
        *["--until", "5", "--quick", "--methods", "rk4,gauss,radau,verlet", "-o"],
        tmp_path,
        "--json",
    )
    assert "verlet" in json.loads(done.stdout)["refused"]


def test_a_state_that_begins_at_zero_does_not_shorten_the_first_steps(tmp_path: Path) -> None:
    """A unit of its own gives it no scale from other numbers: 130 steps from 1e-73 on."""
    text = (
        "model m\nparam w = 2 [1/s]\ncoord x [m]\nobserve z while x > 0.5 [m]\n"
        "kinetic (1 [kg])*x'^2/2\npotential (1 [kg])*w^2*x^2/2\nstart x = 1\n"
    )
    for method in ("dop853", "gauss"):
        run = ("run", written(tmp_path, text), "--until", "3", "--every", "3", "--json")
        report = json.loads(ran(*run, "--method", method).stdout)["report"]
        assert 3 < report["steps"] < 60
