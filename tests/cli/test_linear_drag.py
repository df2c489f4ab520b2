"""Splitting where forces have C v, on models as they are written: against gauss, symplectic where C
turns, refused where the rates come in otherwise."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from conftest import case, ran, run_pkgen

FREE = "kinetic x'^2/2 + y'^2 + x'*y'/3\npotential x^2 + x^4/4 + cos(x - y)\n"
TURNING = "kinetic ((x' - w*y)^2 + (y' + w*x)^2)/2\npotential x^2 + x^4/4 + cos(x - y)\n"
MODELS = {
    "drag": FREE + "dissipation w*(x' - 2*y')^2/4\n",
    "drag driven": FREE + "dissipation w*(x' - 2*y')^2/4\nforce x = cos(2*t)\n",
    "field": FREE + "lagrangian w*x*y'\n",
    "frame": TURNING,
    "field that varies": FREE + "lagrangian w*x*(1 + x^2/3)*y'\n",
    "drag that varies": FREE + "dissipation w*(1 + sin(x)^2)*x'^2/2\n",
    "drag that jumps": FREE + "dissipation w*step(x)*x'^2/2\n",
    "drag of time": FREE + "force x = -w*(1 + sin(t)/2)*x'\n",
    "square drag": FREE + "force x = -w*abs(x')*x'\n",
}
CHAIN = case("linear_drag_chain")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("drag")

    def written(name: str) -> Path:
        path = folder / f"{name.replace(' ', '_')}.lag"
        head = "model m\nparam w = 0.8\ncoord x, y\nstart x = 1, y = 0.2, y' = 0.5\n"
        path.write_text(head + MODELS[name])
        return path

    return written


def last(path: Path, *options: object) -> list[float]:
    done = ran("run", path, "--until", 2, "--every", 2, "-o", "-", *options)
    return [float(x) for x in done.stdout.split()[-1].split(",")][1:5]


def off(path: Path, method: str, step: float, true: list[float]) -> float:
    found = last(path, "--method", method, "--step", step)
    return max(abs(a - b) for a, b in zip(found, true, strict=True))


@pytest.mark.parametrize(("name", "keeps"), [("field", True), ("frame", True), ("drag", False)])
def test_the_form(model, tmp_path: Path, name: str, keeps: bool) -> None:
    def defect(method: str) -> float:
        how = ("--method", method, "--step", 0.2, "--diagnose", "symplectic", "--json")
        done = ran("run", model(name), "--until", 2, *how, "-o", tmp_path / "x.csv")
        return json.loads(done.stdout)["report"]["diagnostics"]["symplectic"]["defect"]

    for method in ("verlet", "blanes_moan4"):
        assert (defect(method) < 1e-13) is keeps
    assert defect("rk4") > 1e-6 and (not keeps or defect("boris") > 1e-6)


def test_a_parameter_may_be_zero(model) -> None:
    """And then it is what it is without the term."""
    path = model("drag")
    plain = path.with_name("plain.lag")
    plain.write_text(path.read_text().replace("dissipation", "observe power ="))
    none = last(path, "--set", "w=0", "--method", "verlet", "--step", 0.1)
    assert none == pytest.approx(last(plain, "--method", "verlet", "--step", 0.1), rel=1e-14)


def test_members_are_those_alone(model, tmp_path: Path) -> None:
    (tmp_path / "members.csv").write_text("x,w\n1,0.8\n0.5,0.3\n")
    by = ("--method", "yoshida4", "--step", 0.1, "--until", 2, "--every", 2)
    done = ran("run", model("drag"), "--ensemble", tmp_path / "members.csv", *by)
    rows = [[float(x) for x in row.split(",")] for row in done.stdout.split()[1:]]
    alone = last(model("drag"), "--method", "yoshida4", "--step", 0.1)
    ends = [row[2:6] for row in rows if row[1] > 1]
    assert ends[0] == alone and ends[1] != alone and len(ends) == 2


def test_a_family_that_stays_a_loop(model, tmp_path: Path) -> None:
    path = tmp_path / "chain.lag"
    path.write_text(CHAIN)
    done = run_pkgen("explain", path)
    assert "loops in C" in done.stdout and "but for forces C v with constant C" in done.stdout
    true = last(path, "--method", "dop853", "--rtol", "1e-13")
    coarse, fine = (off(path, "blanes_moan4", h, true) for h in (0.2, 0.1))
    assert fine > 1e-11 and 12 < coarse / fine < 20
    for size, method, said in ((40, "boris", "derivatives"), (300, "verlet", "at most 256")):
        by = ("--until", 1, "--method", method, "--step", 0.1)
        done = run_pkgen("run", path, "--size", f"N={size}", *by)
        assert done.returncode != 0 and said in done.stderr
