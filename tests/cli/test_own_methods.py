"""`--tableau`, `--composition` and `method NAME tableau FILE`, as a user meets them: against the
built-in methods of the same coefficients, and the order that is told against the one measured."""

from __future__ import annotations

import json
import math
import random
import shutil
from fractions import Fraction
from pathlib import Path

import pytest

import pkgen as api
from conftest import ROOT, ran, run_pkgen, seeds, written
from pkgen.front.read import from_text
from pkgen.own.made import of_text, of_weights

PENDULUM = ROOT / "models/pendulums/pendulum.lag"
RK4 = "A\n0\n1/2\n0 1/2\n0 0 1\nb 1/6 1/3 1/3 1/6\n"
TRIPLE = "1.3512071919596576340476878,-1.7024143839193152680953757,1.3512071919596576340476878"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rk4.tab").write_text(RK4)
    shutil.copy(ROOT / "tests/cases/dopri5.tab", tmp_path / "pair.tab")
    return tmp_path


def last(*options: object) -> list[float]:
    done = ran("run", PENDULUM, "--until", 5, "--every", 5, "-o", "-", *options)
    return [float(x) for x in done.stdout.split()[-1].split(",")]


def test_the_same_coefficients_are_the_same_method(folder: Path) -> None:
    step = ("--step", 0.01)
    assert last("--tableau", folder / "rk4.tab", *step) == last("--method", "rk4", *step)
    mine, theirs = last("--composition", TRIPLE, *step), last("--method", "yoshida4", *step)
    assert mine[:3] == pytest.approx(theirs[:3], rel=1e-13)
    assert last("--composition", "1", *step)[:3] == last("--method", "verlet", *step)[:3]
    mine = last("--tableau", folder / "pair.tab", "--rtol", "1e-8")
    assert mine[:3] == pytest.approx(last("--method", "dopri5", "--rtol", "1e-8")[:3], rel=1e-12)
    worse = last("--composition", "1/2,1/2", *step)
    assert worse[1] != pytest.approx(last("--method", "verlet", *step)[1], rel=1e-7)


ORACLE = "model m\ncoord x\nlagrangian x'^2/2 - x^2/2 - x^4/4\nstart x = 1\n"


def measured(folder: Path, steps: tuple[int, int], *options: object) -> float:
    """The order, of x'' = -x - x^3 at t = 2 beside gauss at its finest."""
    model = written(folder, ORACLE)

    def x(*how: object) -> float:
        shown = ("--until", 2, "--every", 2, "--record", "x", "-o", "-")
        done = ran("run", model, *shown, *how)
        return float(done.stdout.split()[-1].split(",")[1])

    true = x("--method", "gauss", "--rtol", "1e-14")
    errors = [abs(x(*options, "--step", 2 / n) - true) for n in steps]
    assert errors[1] > 1e-14
    return math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0])


def of_order(order: int, random_of: random.Random) -> str:
    """A random explicit tableau of this order: c2, c3 free, by its order conditions."""
    f = Fraction
    c2, c3 = f(random_of.randrange(20, 45), 100), f(random_of.randrange(55, 95), 100)
    if order == 2:
        return f"A\n0\n{c2}\nb {1 - 1 / (2 * c2)} {1 / (2 * c2)}\n"
    # Three stages of order 3: b2 c2 + b3 c3 = 1/2, b2 c2^2 + b3 c3^2 = 1/3, b3 a32 c2 = 1/6.
    b3 = (f(1, 3) - c2 / 2) / (c3 * (c3 - c2))
    b2 = (f(1, 2) - b3 * c3) / c2
    a32 = f(1, 6) / (b3 * c2)
    return f"A\n0\n{c2}\n{c3 - a32} {a32}\nb {1 - b2 - b3} {b2} {b3}\n"


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("seed", seeds([1, 2], 2))
def test_random_tableaux_have_the_order_that_is_told(folder: Path, order: int, seed: int) -> None:
    text = of_order(order, random.Random(seed))
    (folder / "mine.tab").write_text(text)
    told = of_text("mine", from_text("mine.tab", text)).order
    assert told == order
    assert measured(folder, (100, 200), "--tableau", folder / "mine.tab") == pytest.approx(
        told, abs=0.12
    )


@pytest.mark.parametrize("weights", ["0.3,0.2,0.5", "1/4,1/2,1/4", "0.8,-0.6,0.8", TRIPLE])
def test_compositions_have_the_order_that_is_told(folder: Path, weights: str) -> None:
    told = of_weights("mine", weights).order
    found = measured(folder, (50, 100), "--composition", weights)
    assert found == pytest.approx(told, abs=0.12)


def test_what_is_told(folder: Path) -> None:
    (folder / "midpoint.tab").write_text("A\n1/2\nb 1\n")
    given = ["--tableau", folder / "rk4.tab", "--tableau", folder / "midpoint.tab"]
    done = run_pkgen("methods", *given, "--composition", "1/2,1/2", "--json")
    found = {m["name"]: m for m in json.loads(done.stdout)}
    rk4, halves, midpoint = found["own_rk4"], found["composition"], found["midpoint"]
    assert rk4["facts"]["order"] == 4
    assert rk4["limits"]["imaginary"] == pytest.approx(math.sqrt(8), rel=1e-12)
    assert rk4["limits"]["real"] == pytest.approx(2.785293563405, rel=1e-10)
    assert halves["limits"]["imaginary"] == pytest.approx(4, rel=1e-12)
    assert halves["facts"]["symplectic"] and "linear_drag" in halves["requires"]
    assert midpoint["facts"]["symplectic"] and not midpoint["runs"]
    text = run_pkgen("methods", "--tableau", folder / "rk4.tab").stdout
    assert "own_rk4" in text and "2.8284271" in text and "0.0145" in text


def test_scenes_and_commands(folder: Path) -> None:
    model = written(
        folder,
        ORACLE + "method mine tableau rk4.tab\n"
        "scene a\n until 2\n method mine step 0.1\n record x every 2\nend\n"
        "scene b\n until 2\n method pair tableau pair.tab rtol 1e-9\n record x every 2\nend\n",
    )
    done = run_pkgen("run", model, "--scene", "a")
    assert done.returncode == 0 and "mine: t = 2 after 20 steps" in done.stderr
    done = run_pkgen("run", model, "--scene", "b")
    assert done.returncode == 0 and "pair: t = 2 after" in done.stderr
    assert run_pkgen("run", model, "--scene", "a", "--method", "pair").returncode == 0
    wanted = ["--methods", "rk4", "--composition", "1/4,1/2,1/4", "--until", 2]
    quick = ["--quick", "--points", 4, "--seconds", 1, "-o", folder, "--json"]
    chart = json.loads(run_pkgen("chart", model, *wanted, *quick).stdout)
    assert {p["method"] for p in chart["points"]} == {"rk4", "composition"}
    stability = ["--methods", "verlet", "--composition", "1/2,1/2", "--points", "6x2", "--quick"]
    found = json.loads(run_pkgen("stability", model, *stability, "-o", folder, "--json").stdout)
    limits = {p["method"]: p for p in found["predictions"] if p["kind"] == "limit"}
    assert limits["composition"]["h"] == pytest.approx(2 * limits["verlet"]["h"], rel=1e-9)
    assert limits["composition"]["measured"] == pytest.approx(4, rel=0.02)


def test_a_file_may_be_called_anything(tmp_path: Path) -> None:
    """Its name stands in C, in a text."""
    path = tmp_path / 'odd"\nint x = 1; "\\.tab'
    path.write_text("A\n0\n1\nb 1/2 1/2\n")
    words = ("--tableau", path, "--step", "0.01", "--until", "0.02", "-o", tmp_path / "rows.csv")
    ran("run", ROOT / "models" / "double_pendulum.lag", *words)


def test_described(folder: Path) -> None:
    """With what the model brings and the options do, and why not where they do not apply."""
    model = written(folder, "model swing\nmethod mine tableau rk4.tab\n" + ORACLE.split("\n", 1)[1])
    options = ("--composition", "1/2,1/2", "--tableau", folder / "pair.tab", "--json")
    done = run_pkgen("describe", model, *options)
    found = json.loads(done.stdout)["methods"]
    own = {m["name"]: m for m in found if m["own"]}
    assert [*own] == ["mine", "pair", "composition"] and all(m["applies"] for m in own.values())
    assert own["pair"]["adaptive"] and own["mine"]["order"] == 4 and own["mine"]["stages"] == 4
    assert own["composition"]["symplectic"] and len(found) > 40
    done = run_pkgen("describe", ROOT / "models/double_pendulum.lag", *options)
    own = [m for m in json.loads(done.stdout)["methods"] if m["own"]]
    assert [m["applies"] for m in own] == [True, False] and "separable" in own[1]["why"]


def test_from_python(folder: Path) -> None:
    model = api.load(PENDULUM)

    def theta(**how: object) -> float:
        return model.run(5, every=5, **({"step": 0.01} | how))["theta"][-1]

    assert theta(tableau=folder / "rk4.tab") == theta(method="rk4")
    assert theta(tableau=[str(folder / "rk4.tab")], method="verlet") == theta(method="verlet")
    half = theta(composition=[0.5, 0.5])
    assert half == pytest.approx(theta(method="verlet", step=0.005), rel=1e-9)
    assert half == theta(composition="1/2,1/2") and half != theta(composition=[1])
    (folder / "rk4.tab").write_text(RK4.replace("1/6 1/3 1/3 1/6", "1/4 1/4 1/4 1/4"))
    assert theta(tableau=folder / "rk4.tab") != theta(method="rk4")  # the file, as it is now
    starts = {"theta": [0.5, 1.0]}
    many = model.ensemble(starts, until=1, every=1, step=0.01, composition=[0.5, 0.5])
    assert many.by_member("theta").shape == (2, 2)
    with pytest.raises(api.ModelError):
        theta(composition=[0.5, 0.6])
