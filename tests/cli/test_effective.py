"""V_eff as a column, an expression, a function and a plot: against closed forms."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from pathlib import Path

import numpy
import pytest

import pkgen as package
from conftest import ROOT, ran, run_pkgen, seeds, written

KEPLER = """model orbit
param m = 2 [kg] in (0, inf)
param mu = 3 [m^3/s^2]
coord r [m], phi [rad]
kinetic m/2*(r'^2 + r^2*phi'^2)
potential -mu*m/r
observe slope = V_eff'
start r = 1.5, r' = 0.3, phi' = 0.9
scene radial
  until 5
  method gauss rtol 1e-12
  record r, r', V_eff, slope, energy every 0.1
  expect energy = m/2*r'^2 + V_eff within 1e-10
end
"""
SPHERICAL = """model spherical
coord phi, theta
kinetic 1/2*(theta'^2 + sin(theta)^2*phi'^2)
potential -cos(theta)
start theta = 1, phi' = 0.7
"""


def test_of_kepler(tmp_path: Path) -> None:
    """L^2/(2 m r^2) - G M m/r."""
    path = written(tmp_path, KEPLER)
    model = package.load(path, "radial")
    V, run = model.effective_potential(), model.run()
    L = 2 * 1.5**2 * 0.9
    r = numpy.linspace(0.5, 4, 50)
    assert V.coordinates == ("r",) and V.momenta == {"p_phi": pytest.approx(L)}
    assert V(r) == pytest.approx(L**2 / (4 * r**2) - 6 / r, rel=1e-13)
    assert run["V_eff"] == pytest.approx(V(run["r"]), rel=1e-11)
    slope = (6 / run["r"] ** 2 - L**2 / (2 * run["r"] ** 3)) * run["r'"]
    assert run["slope"] == pytest.approx(slope, abs=1e-10)
    assert run.units["V_eff"] == "J" and str(V) == "-m*mu/r + p_phi^2/(2*m*r^2)"
    assert model.effective_potential(start={"phi'": 1.8}).momenta["p_phi"] == pytest.approx(2 * L)
    ran("run", path, "--scene", "radial")
    for options in ((), ("--scene", "radial")):
        assert f"  V_eff = {V}\n" in ran("explain", path, *options).stdout


def test_a_cyclic_coordinate_that_is_written_gives_way(tmp_path: Path) -> None:
    """L has cos(phi) and sin(phi), which cancel."""
    places = "let px = r*cos(phi)\nlet py = r*sin(phi)\nkinetic m/2*(px'^2 + py'^2)"
    text = KEPLER.replace("kinetic m/2*(r'^2 + r^2*phi'^2)", places)
    path = written(tmp_path, text)
    done = ran("explain", path, "--scene", "radial")
    assert "V_eff = -m*mu/r + p_phi^2/(2*m*r^2)" in done.stdout
    assert "p_phi is constant" in done.stdout
    ran("run", path, "--scene", "radial")


def test_of_a_heavy_top() -> None:
    model = package.load(ROOT / "models/heavy_top.lag", "nutation")
    V, p = model.effective_potential(), model.params
    a, b = V.momenta["p_phi"], V.momenta["p_psi"]
    theta = numpy.linspace(0.3, 3, 40)
    by_hand = (a - b * numpy.cos(theta)) ** 2 / (2 * p["I1"] * numpy.sin(theta) ** 2)
    by_hand += b**2 / (2 * p["I3"]) + p["M"] * p["g"] * p["l"] * numpy.cos(theta)
    assert V(theta) == pytest.approx(by_hand, rel=1e-13) and numpy.isnan(V(0.0))
    run = model.run(record=["theta", "theta'", "V_eff"])
    assert run["V_eff"] == pytest.approx(V(run["theta"]), rel=1e-13)
    assert p["I1"] / 2 * run["theta'"] ** 2 + run["V_eff"] == pytest.approx(V.energy, rel=1e-12)


def test_of_a_spherical_pendulum_and_its_turning_points(tmp_path: Path) -> None:
    model = package.load(written(tmp_path, SPHERICAL))
    V = model.effective_potential()
    L = math.sin(1) ** 2 * 0.7
    theta = numpy.linspace(0.2, 3, 40)
    assert V(theta) == pytest.approx(L**2 / (2 * numpy.sin(theta) ** 2) - numpy.cos(theta))
    run = model.run(30, method="gauss", rtol=1e-12, record=["theta", "V_eff"])
    assert (run["V_eff"] <= V.energy + 1e-12).all()
    curve, level = V.plot("theta", 0.1, 3).axes[0].lines[:2]
    assert curve.get_ydata()[7] == pytest.approx(V(curve.get_xdata()[7]))
    assert level.get_ydata() == pytest.approx([V.energy, V.energy])


def test_without_cyclic_coordinates_it_is_the_energy_at_rest() -> None:
    """Of a driven hoop the Jacobi integral, -m R^2 W^2 sin^2(theta)/2 - m g R cos(theta)."""
    model = package.load(ROOT / "models/bead_on_hoop.lag")
    V, p = model.effective_potential(), model.params
    theta = numpy.linspace(-3, 3, 30)
    by_hand = -p["m"] * (p["R"] * p["Omega"] * numpy.sin(theta)) ** 2 / 2
    by_hand -= p["m"] * p["g"] * p["R"] * numpy.cos(theta)
    assert V(theta=theta) == pytest.approx(by_hand, rel=1e-13) and V.momenta == {}
    done = ran("explain", ROOT / "models/bead_on_hoop.lag")
    assert "V_eff" not in done.stdout


def drawn(chance: random.Random) -> str:
    """A model with cyclic coordinates a and b: any M, terms of first degree, a constraint apart."""
    number = lambda: f"{chance.uniform(-0.4, 0.4):.3f}"  # noqa: E731
    of = "xy"[: chance.randint(1, 2)]
    rates = [*"ab", *of]
    slow = [f"{number()}*sin({chance.choice(of)})" for _ in range(8)]
    lines = ["model drawn", f"coord a, b, {', '.join(of)}"]
    lines += [f"kinetic ({1 + abs(float(number()))} + cos(x)^2)*{u}'^2" for u in rates]
    lines += [f"kinetic {chance.choice(slow)}*{u}'*{w}'" for u, w in pairwise(rates)]
    lines += [f"lagrangian {number()}*cos(x)*{u}'" for u in rates]
    lines += [f"potential {' + '.join(slow[:3])} + {of[-1]}^2"]
    lines += ["start a' = 0.4, b' = -0.7, x = 0.3, x' = 0.2"]
    if chance.random() < 0.4:  # a rod to a bead that is no part of the rest
        lines += ["coord u, w", "kinetic (u'^2 + w'^2)/2", "constraint rod: u^2 + w^2 = 1"]
        lines += ["potential w", "start w = -1, u' = 0.3"]
    return "\n".join(
        [*lines, "scene little", "  until 2", "  record x, x', V_eff every 0.1", "end"]
    )


@pytest.mark.parametrize("seed", seeds(range(3), 6))
def test_a_column_is_the_energy_with_the_momenta_kept(seed: int, tmp_path: Path) -> None:
    """The column is of the graph, before and after Routh's reduction; the function solves for the
    rates by the kernels."""
    path = written(tmp_path, drawn(random.Random(seed)))
    model = package.load(path)
    V = model.effective_potential()
    run = model.run(2, rtol=1e-11, every=0.1, record=[*V.coordinates, "V_eff"])
    assert {*V.coordinates}.isdisjoint("ab") and {*V.momenta} == {"p_a", "p_b"}
    assert run["V_eff"] == pytest.approx(V(*(run[x] for x in V.coordinates)), abs=1e-7)
    kept = package.load(path, "little").run(rtol=1e-11)
    assert kept["V_eff"] == pytest.approx(run["V_eff"], abs=1e-7)


def test_a_name_of_the_author_stays(tmp_path: Path) -> None:
    text = SPHERICAL + "let V_eff = 3*theta\nobserve twice = 2*V_eff\n"
    run = package.load(written(tmp_path, text)).run(1, every=0.5, record=["theta", "twice"])
    assert run["twice"] == pytest.approx(6 * run["theta"])
    own = package.load(written(tmp_path, text)).run(1, record=["theta", "V_eff"])
    assert own["V_eff"] == pytest.approx(3 * own["theta"])
    text = SPHERICAL + "param V_eff = 3\nobserve twice = 2*V_eff\n"
    with pytest.raises(package.UsageError, match="no such column"):
        package.load(written(tmp_path, text)).run(1, record=["V_eff"])


def test_families_are_written_out(tmp_path: Path) -> None:
    text = "model chain\nsize N = 300\ncoord q[1..N]\nfree q[0], q[N+1]\n"
    text += "kinetic sum(q[i]'^2/2, i = 1..N)\npotential sum((q[i+1] - q[i])^2/2, i = 1..N-1)\n"
    text += "start q[i = 1..N] = sin(i)\n"
    run = package.load(written(tmp_path, text)).run(0.1, step=0.1, record=["V", "V_eff"])
    assert run["V_eff"] == pytest.approx(run["V"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "coord x, y\nkinetic x'^4/4 + x'^2 + y'^2\npotential y\n",
            "x stay, for L is not of second",
        ),
        ("coord x\nstate s\nkinetic x'^2\nrate s = V_eff\n", "follows from the rates"),
        ("state s\nrate s = -s\nstart s = 1\n", "no energy"),
    ],
)
def test_what_has_none_is_refused(text: str, said: str, tmp_path: Path) -> None:
    path = written(tmp_path, "model m\n" + text + "observe a = V_eff\n")
    done = run_pkgen("run", path, "--until", "1")
    assert done.returncode == 1 and said in done.stderr and "Traceback" not in done.stderr


def test_a_scene_without_coordinates_has_none(tmp_path: Path) -> None:
    text = "model m\ncoord x\nstate s\nrate s = -s\nkinetic x'^2\nstart s = 1\n"
    text += "scene a\n  hold x = t\n  until 1\n  record V_eff, s every 0.5\nend\n"
    done = run_pkgen("run", written(tmp_path, text), "--scene", "a")
    assert done.returncode == 1 and "there is no energy here" in done.stderr


def test_the_function_refuses_other_names(tmp_path: Path) -> None:
    V = package.load(written(tmp_path, KEPLER)).effective_potential()
    for wrong in (lambda: V(phi=1.0), lambda: V(1.0, 2.0), lambda: V.plot("phi", 0, 1)):
        with pytest.raises(package.UsageError, match="is a function of r"):
            wrong()
    text = "model loose\ncoord x\nkinetic x'^2\n"
    with pytest.raises(package.UsageError, match="there are none"):
        package.load(written(tmp_path, text)).effective_potential()
