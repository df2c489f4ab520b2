"""Equilibria, steady motions and Jacobians: against closed forms, differences and motions."""

from __future__ import annotations

import argparse
import json
import math
import random
from functools import partial
from pathlib import Path

import numpy
import pytest
from drawn_models import drawn, slope

import pkgen as package
from conftest import ROOT, ran, seeds, written
from pkgen.analysis.linear.system import opened
from pkgen.api.arguments import DEFAULTS
from pkgen.back.kernels import all_but

TOP = {"precession": 1.1931380589634, "spin": 17.3870829461320, "nutation": 7.3155695065632}
HOOP = ROOT / "models/bead_on_hoop.lag"


def load(name: str, **params: float) -> package.api.model.Model:
    model = package.load(ROOT / "models" / name)
    model.params.update(params)
    return model


# -- equilibria and steady motions ---------------------------------------------------------------


@pytest.mark.parametrize("name", ["heavy_top.lag", "bodies/heavy_top_rotation.lag"])
def test_a_top_precesses_nutates_and_spins(name: str) -> None:
    done = ran("equilibria", ROOT / "models" / name, "--json")
    found = json.loads(done.stdout)["equilibria"]
    assert len(found) == 2 and all(at["stable"] for at in found)
    for at in found:
        assert {k: at[k] for k in TOP} == pytest.approx(TOP, rel=1e-11)
        assert at["frequencies"] == [at["nutation"]]
    if name == "heavy_top.lag":
        assert abs(found[0]["state"]["theta"]) == pytest.approx(0.6593415109076552, rel=1e-13)


def test_the_lagrange_points() -> None:
    model = load("particles/restricted_three_body.lag")
    found = model.equilibria()
    mu = model.params["mu"]
    five = [at for at in found if abs(at["state"]["y"]) > 0.1]
    assert len(found) == 5 and [at["stable"] for at in five] == [True, True]
    # Szebehely, Theory of Orbits (1967) 5.5: w^4 - w^2 + 27 mu (1 - mu)/4 = 0 of L4 and L5.
    roots = numpy.roots([1, -1, 27 * mu * (1 - mu) / 4])
    for at in five:
        place = at["state"]["x"], abs(at["state"]["y"])
        assert place == pytest.approx((0.5 - mu, math.sqrt(0.75)), abs=1e-13)
        assert sorted(x**2 for x in at["frequencies"]) == pytest.approx(sorted(roots), rel=1e-9)


def test_a_hoop_has_a_pitchfork() -> None:
    model = package.load(HOOP)
    g, r = model.params["g"], model.params["R"]
    critical = math.sqrt(g / r)
    for part, count in ((0.9, 2), (1.1, 4)):
        model.params["Omega"] = part * critical
        found = model.equilibria()
        assert len(found) == count
        lowest = abs(found[0]["state"]["theta"])
        assert lowest == pytest.approx(math.acos(min(1, part**-2)), abs=1e-12)


def test_a_disk_goes_round_steadily() -> None:
    (at,) = load("constrained/rolling_disk.lag").equilibria()
    assert at["precession"] == pytest.approx(10, rel=1e-9)
    assert at["verdict"] == "stable"


def test_gimbals_rest_or_precess_at_the_momenta_of_the_start() -> None:
    """With V_eff = (p - p_spin cos beta)^2/(2 I(beta)): beside cos beta = p/p_spin it is 0 and
    nothing precesses; where all axes are the vertical, alpha' = (p -+ p_spin)/I(0)."""
    model = load("constrained/gimbals.lag", beta0=math.radians(50))
    p = model.params
    spin, tilt = p["C"] * p["spin"], p["beta0"]

    def outer(beta: float) -> float:
        sine, cosine = math.sin(beta) ** 2, math.cos(beta) ** 2
        return p["J"] + (p["K2"] + p["A"]) * sine + p["K3"] * cosine

    whole = outer(tilt) * p["turn"] + spin * math.cos(tilt)
    still = math.acos(whole / spin)
    frequency = spin * math.sin(still) / math.sqrt(outer(still) * (p["K1"] + p["A"]))
    fast = {round((whole + sign * spin) / outer(0), 6) for sign in (1, -1)}
    found, seen = model.equilibria(), set()
    for at in found:
        rate = at["state"]["alpha'"]
        seen.add(round(rate, 6))
        if at["stable"]:
            assert abs(math.cos(at["state"]["beta"])) == pytest.approx(whole / spin, rel=1e-9)
            assert at["frequencies"] == pytest.approx([frequency], rel=1e-8) and abs(rate) < 1e-9
        else:
            assert abs(math.sin(at["state"]["beta"])) < 1e-9
    assert {abs(x) for x in seen} == {0.0} | {abs(x) for x in fast}


def test_a_free_body_turns_about_three_axes() -> None:
    """Euler: unstable about the middle axis, by the rates of the closed form."""
    model = load("bodies/free_body.lag")
    inertia = [model.params[f"I{k}"] for k in (1, 2, 3)]
    for at in model.equilibria():
        w = numpy.array([at["state"][f"omega(R).{x}"] for x in "xyz"])
        k = int(abs(w).argmax())
        a, b = (inertia[i] for i in range(3) if i != k)
        square = (inertia[k] - a) * (inertia[k] - b) / (a * b) * w[k] ** 2
        assert at["stable"] == (square > 0)
        rates = at["frequencies"] or [max(m["growth"] for m in at["modes"])]
        assert rates == pytest.approx([math.sqrt(abs(square))], rel=1e-9)


@pytest.mark.parametrize(
    ("name", "constant"),
    [
        ("heavy_top.lag", ["theta", "energy"]),
        ("bodies/heavy_top_rotation.lag", ["top"]),
        ("particles/kepler.lag", ["r"]),
        ("constrained/rolling_disk.lag", ["z"]),
    ],
)
def test_a_steady_motion_goes_on(name: str, constant: list[str]) -> None:
    model = load(name)
    for at in model.equilibria()[:2]:
        run = model.run(3.0, method="gauss", rtol=1e-12, start=at["state"], record=constant)
        for column in ("top.z",) if constant == ["top"] else constant:
            assert numpy.ptp(run[column]) < 1e-9 * max(1, abs(run[column]).max())


def test_no_place_to_rest(tmp_path: Path) -> None:
    text = "model falls\ncoord x\nkinetic x'^2/2\npotential x\n"
    assert package.load(written(tmp_path, text)).equilibria() == []


def test_a_word_of_the_author_does_not_hide_what_is_listed(tmp_path: Path) -> None:
    text = "model m\ncoord a, b [rad]  # energy, tilt\nparam J = 1 [kg*m^2]\n"
    text += "kinetic J/2*(a'^2 + b'^2)\npotential 3 [J]*b^2\nstart a' = 3\n"
    (at,) = package.load(written(tmp_path, text)).equilibria()
    assert at["energy"] == pytest.approx(4.5) and at["tilt"] == pytest.approx(math.sqrt(6))


KINDS = ("acceleration", "outputs")

# -- Jacobians -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", seeds([0, 2, 5], 12))
def test_jacobians_are_slopes(seed: int, tmp_path: Path) -> None:
    text, p, u = drawn(random.Random(seed))
    path = written(tmp_path, text)
    model = package.load(path)
    options = argparse.Namespace(
        **{**DEFAULTS, "model": str(path), "scene": None, "set": [], "start": []}
    )
    made = model._compiled(options, unroll=None, kernels=all_but())
    system = opened(options, made, "test")
    chance = numpy.random.default_rng(seed)
    n, m, given = system.n, system.m, chance.uniform(-1, 1, len(u))
    system.inputs = given
    q, v = numpy.split(system.start.copy(), 2)
    q = numpy.nan_to_num(q)

    def at(name: str, q=q, v=v, u=given) -> numpy.ndarray:
        system.inputs = u
        found = system.kernel(name, 0.0, numpy.concatenate([q, v]))[0]
        system.inputs = given
        return found

    def close(a: numpy.ndarray, b: numpy.ndarray) -> None:
        assert a == pytest.approx(b, rel=1e-8, abs=1e-8)

    def along(kind: str) -> list:
        return [lambda x, k=k: at(kind, **{k: x}) for k in "quv"]

    M, e = at("mass").reshape(n, n), numpy.eye(max(n, len(u)))
    _, a_u, _ = along("acceleration")
    out_of_q, out_of_u, out_of_v = along("outputs")
    r_u, out_u = at("r_u").reshape(n, len(u)), at("out_u").reshape(2, len(u))
    for j in range(len(u)):
        by = e[j, : len(u)]
        close(numpy.linalg.solve(M, r_u[:, j]), slope(a_u, given, by))
        close(out_u[:, j], slope(out_of_u, given, by))
    out_x = at("out_x").reshape(2, 2, n)
    for j in range(n):
        close(out_x[:, 1, j], slope(out_of_v, v, e[j, :n]))
        if j < m:
            close(out_x[:, 0, j], slope(out_of_q, q, e[j, :n]))
    r_p, out_p = at("r_p").reshape(n, len(p)), at("out_p").reshape(2, len(p))

    def changed(kind: str, values: numpy.ndarray) -> numpy.ndarray:
        options.set = [f"{name}={x!r}" for name, x in zip(p, values.tolist(), strict=True)]
        other = opened(options, made, "test")
        other.inputs = given
        return other.kernel(kind, 0.0, numpy.concatenate([q, v]))[0]

    values = numpy.array([model.params[name] for name in p])
    for j in range(len(p)):
        by = numpy.eye(len(p))[j]
        of_a, of_out = (slope(partial(changed, kind), values, by) for kind in KINDS)
        close(numpy.linalg.solve(M, r_p[:, j]), of_a)
        close(out_p[:, j], of_out)
