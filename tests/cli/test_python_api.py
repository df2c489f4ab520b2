"""pkgen from Python: the same rows as the command line's, kernels beside each other, errors."""

from __future__ import annotations

import json
import os
import signal
import threading

import numpy as np
import pytest

import pkgen as api
from conftest import ROOT, case, table, written

DOUBLE = ROOT / "models/double_pendulum.lag"
HOOP = ROOT / "models/bead_on_hoop.lag"
WALL = case("fall")


@pytest.fixture(scope="module")
def double():
    return api.load(DOUBLE)


def test_rows_are_those_of_the_command_line(pkgen, double) -> None:
    found = double.run(
        "3 [s]", method="dop853", rtol=1e-9, every=0.25, start={"theta1": "80 [deg]"}
    )
    options = ["--until", "3", "--method", "dop853", "--rtol", "1e-9", "--every", "0.25"]
    done = pkgen("run", DOUBLE, *options, "--start", "theta1=80 [deg]")
    names, rows = table(done.stdout)
    rows = np.array(rows)
    assert list(found) == names and len(found) == 13
    assert all((found[name] == rows[:, i]).all() for i, name in enumerate(names))
    assert found.units == dict(zip(names, ["s", "rad", "rad", "rad/s", "rad/s", "J"], strict=True))
    assert found.report["status"] == "PK_DONE" and found.events == {}
    assert "<table>" in found._repr_html_() and "dop853" in repr(found)
    with pytest.raises(KeyError, match="theta3: the rows have t, theta1"):
        found["theta3"]


def test_a_scene_and_its_record(pkgen) -> None:
    scene = api.load(HOOP, scene="balanced")
    names, rows = table(pkgen("run", HOOP, "--scene", "balanced").stdout)
    found = scene.run()
    assert list(found) == names and [*found["t"]] == [row[0] for row in rows]
    assert api.load(DOUBLE).scenes == ("reference", "slow", "fast")


def test_a_mass_matrix_of_families_kept_as_loops_is_refused() -> None:
    model = api.load(ROOT / "models" / "chains" / "fput.lag", sizes={"N": 40})
    rest = np.zeros(len(model.coordinates))
    assert model.f(rest, rest).shape == rest.shape
    with pytest.raises(api.UsageError, match="mass: families of so many members"):
        model.M(rest, rest)


def test_parameters(double) -> None:
    assert double.params["g"] == 9.81 and len(double.params) == 5
    model = api.load(DOUBLE)
    before = model.run(1, every=1)["theta1"][-1]
    model.params["g"] = "1.62 [m/s^2]"
    assert model.params["g"] == 1.62 and model.run(1, every=1)["theta1"][-1] != before
    del model.params["g"]
    assert model.params["g"] == 9.81 and model.run(1, every=1)["theta1"][-1] == before
    with pytest.raises(KeyError, match="did you mean 'm1'"):
        model.params["m11"] = 1
    with pytest.raises(api.UsageError, match="unit"):
        model.params["g"] = "2 [kg]"


@pytest.mark.parametrize("shape", [(), (1,), (7,), (8,), (3, 5), (2, 1, 9)])
def test_kernels_take_any_leading_shape(double, shape) -> None:
    draw = np.random.default_rng(1)
    q, v = draw.normal(size=(*shape, 2)), draw.normal(size=(*shape, 2))
    mass, force, a = double.M(q, v), double.f(q, v), double.acceleration(q, v)
    assert mass.shape == (*shape, 2, 2) and a.shape == force.shape == (*shape, 2)
    assert np.allclose(np.einsum("...ij,...j", mass, a), force, rtol=1e-12, atol=1e-12)
    assert np.allclose(np.einsum("...ij,...j", mass, v), double.momenta(q, v), atol=1e-13)
    j = double.jacobian(q, v)
    assert j.shape == (*shape, 2, 2, 2) and double.energy(q, v).shape == shape
    h = 1e-6
    for k in range(2):
        step = h * np.eye(2)[k]
        slope = (double.acceleration(q + step, v) - double.acceleration(q - step, v)) / (2 * h)
        assert np.allclose(j[..., 0, :, k], slope, rtol=1e-6, atol=1e-5)
    assert (double.acceleration(q[None], v, np.zeros((4, *[1] * len(shape)))) == a).all()


def test_kernels_refuse_other_shapes(double) -> None:
    with pytest.raises(ValueError, match=r"q must be of shape \(..., 2\)"):
        double.M([1.0], [1.0, 2.0])


def test_a_family_of_many_has_all_its_members(pkgen, tmp_path) -> None:
    path = written(
        tmp_path,
        "model chain\nsize N = 40\nparam k[i = 1..N+1] = 1 + i\nparam m = 7\ncoord q[1..N]\n"
        "fixed q[0] = 0, q[N+1] = 0\nkinetic m*sum(q[i]'^2, i = 1..N)/2\n"
        "potential sum(k[i+1]/2*(q[i+1] - q[i])^2, i = 0..N)\n",
    )
    model = api.load(path)
    assert model.coordinates == tuple(f"q[{i}]" for i in range(1, 41))
    assert model.rates == tuple(f"q[{i}]'" for i in range(1, 41))
    assert dict(model.params) == {f"k[{i}]": 1 + i for i in range(1, 42)} | {"m": 7}
    model.params["k[3]"] = 99
    q, k = np.linspace(-1, 1, 40) ** 3, np.arange(2.0, 43)
    k[2] = 99
    pulls = k * np.diff(q, prepend=0, append=0)
    assert model.acceleration(q, 0 * q) == pytest.approx(np.diff(pulls) / 7)
    described = json.loads(pkgen("describe", path, "--json").stdout)["parameters"]
    assert [row["value"] for row in described] == [*range(2, 43), 7]


def test_a_step_of_rhs_is_one_of_the_run(double) -> None:
    h, y = 1e-3, double.start
    k1 = double.rhs(0, y)
    k2 = double.rhs(h / 2, y + h / 2 * k1)
    k3 = double.rhs(h / 2, y + h / 2 * k2)
    y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + double.rhs(h, y + h * k3))
    run = double.run(h, method="rk4", step=h, every=h)
    there = [run[n][-1] for n in (*double.coordinates, *double.rates)]
    assert np.allclose(y, there, rtol=1e-14, atol=1e-15)
    many = np.stack([y, y], axis=1)
    assert (double.rhs(0, many)[:, 1] == double.rhs(0, y)).all()


def test_an_ensemble_has_rows_by_member(double) -> None:
    given = {"theta1": np.linspace(1, 2, 5), "m1": [1, 2, 3, 4, 5]}
    found = double.ensemble(given, until=2, every=1, method="gauss")
    assert found.by_member("theta1").shape == (5, 3) and found.member[-1] == 5
    assert (found.by_member("theta1")[:, 0] == given["theta1"]).all()


@pytest.mark.parametrize(
    ("members", "said"),
    [
        ({"theta1": [0, np.nan]}, "table:2: column theta1: a value is missing or not finite"),
        ({"theta1": [0, 1], "m1": [1]}, "table: members are columns of one length"),
        ({"theta1": []}, "table: it has no rows"),
        ({}, "table: members are columns of one length"),
        ({"thet1": [0]}, "column thet1: did you mean 'theta1'"),
    ],
)
def test_tables_that_cannot_be(double, members: dict, said: str) -> None:
    with pytest.raises(api.UsageError, match=said):
        double.ensemble(members, until=1)


def test_errors_carry_what_is_known(tmp_path) -> None:
    path = written(tmp_path, WALL)
    model = api.load(path)
    with pytest.raises(api.RunError) as failed:
        model.run(10, every=0.1)
    assert failed.value.status.startswith("PK_") and 1 < failed.value.last_valid < 1.2
    assert failed.value.result.t[-1] <= failed.value.last_valid
    with pytest.raises(api.UsageError, match="no such method"):
        model.run(1, method="gausss")
    with pytest.raises(TypeError):
        model.run(1, methods="gauss")
    path.write_text("model wrong\ncoord x\nkinetic y'^2/2\n")
    with pytest.raises(api.ModelError) as wrong:
        api.load(path)
    assert wrong.value.diagnostics[0].span is not None


def test_an_interrupt_ends_a_run(double) -> None:
    threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        double.run(1e7, method="rk4", step=1e-3, every=1e4)
    assert len(double.run(1, every=0.5)) == 3


def test_runs_in_threads(double) -> None:
    found: dict[int, float] = {}

    def one(k: int) -> None:
        found[k] = double.run(5, every=5, start={"theta1": 1 + 0.1 * k})["theta1"][-1]

    double.run(1)
    threads = [threading.Thread(target=one, args=(k,)) for k in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    again = [double.run(5, every=5, start={"theta1": 1 + 0.1 * k})["theta1"][-1] for k in range(4)]
    assert [found[k] for k in range(4)] == again


def test_events_and_expectations(tmp_path) -> None:
    path = written(
        tmp_path,
        "model swing\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\n"
        "event down: x falling\nscene turns\n  until 10\n  expect x < 1.1\nend\n",
    )
    found = api.load(path, scene="turns").run()
    assert np.allclose(found.events["down"], [np.pi / 2, 5 * np.pi / 2], atol=1e-9)


def test_frames(double) -> None:
    pandas = pytest.importorskip("pandas")
    found = double.run(1, every=0.5)
    frame = found.to_dataframe()
    assert list(frame.columns) == list(found)[1:] and frame.attrs["units"]["theta1"] == "rad"
    assert isinstance(frame, pandas.DataFrame)


def test_datasets(double) -> None:
    pytest.importorskip("xarray")
    found = double.run(1, every=0.5).to_xarray()
    assert found["theta1"].attrs["units"] == "rad" and found.sizes["t"] == 3
