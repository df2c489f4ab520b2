"""The Python API as people use it: inputs of kernels, copies, equations, data sets."""

from __future__ import annotations

import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import pkgen as api
from conftest import ROOT, written

DOUBLE = ROOT / "models/double_pendulum.lag"


def test_kernels_take_inputs(tmp_path) -> None:
    """Beside the formula, at random: an array, a dictionary, broadcast; without, inputs are 0."""
    text = "model cart\nparam m = 2\ncoord x\ninput F\ninput G\nkinetic m/2*x'^2\n"
    path = written(tmp_path, text + "potential x^4/4\nforce x = F + 2*G*x - x'\n")
    m, draw = api.load(path), np.random.default_rng(5)
    q, v, F, G = draw.normal(size=(4, 7, 1))
    right = (F + 2 * G * q - v - q**3) / 2
    for u in (np.concatenate([F, G], -1), {"F": F[:, 0], "G": G[:, 0]}):
        assert m.acceleration(q, v, u=u) == pytest.approx(right, rel=1e-14)
        assert m.f(q, v, u=u) == pytest.approx(2 * right, rel=1e-14)
        slopes = m.jacobian(q, v, u=u)[..., 0, 0]
        assert slopes[:, :1] == pytest.approx((2 * G - 3 * q**2) / 2, rel=1e-12)
    assert m.acceleration(q, v) == pytest.approx((-v - q**3) / 2, rel=1e-14)
    assert m.f([1.0], [0.0], u={"F": [1.0, 2.0]})[:, 0] == pytest.approx([0.0, 1.0])
    for wrong, words in (({"H": 1}, "F, G"), ([1, 2, 3], r"shape \(..., 2\)")):
        with pytest.raises(api.UsageError, match=words):
            m.f([1.0], [0.0], u=wrong)


def test_models_are_copied_and_pickled() -> None:
    m = api.load(DOUBLE, scene="slow")
    m.params["m1"] = 3
    for other in (pickle.loads(pickle.dumps(m)), copy.deepcopy(m)):
        assert other.scene == "slow" and other.params["m1"] == 3
        other.params["m1"] = 4
        assert m.params["m1"] == 3
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(type(m).energy, (m, [0.0, 0.0], [0.0, 0.0])) == m.energy([0, 0], [0, 0])
    assert dir(api) == sorted(api.__all__)


def test_equations_are_those_of_the_kernels() -> None:
    m = api.load(DOUBLE)
    found = m.sympy()
    values = dict(zip(found.q + found.v, (0.3, -0.7, 1.1, 0.2), strict=True))
    values |= {s: m.params[s.name] for s in found.L.free_symbols - values.keys()}
    M, f = (np.array(x.subs(values), float) for x in (found.M, found.f))
    assert pytest.approx(m.M([0.3, -0.7], [1.1, 0.2]), rel=1e-13) == M
    assert pytest.approx(m.f([0.3, -0.7], [1.1, 0.2]), rel=1e-13) == f[:, 0]
    text = m.equations()._repr_latex_()
    assert text.count(r"\ddot{\theta}_{1}") == 2 and text.count("&=") == 2


def test_an_expression_that_is_too_long_is_refused(monkeypatch) -> None:
    monkeypatch.setattr("pkgen.api.symbols._LONGEST", 9)
    with pytest.raises(api.UsageError, match=r"double_pendulum: .*operations, and SymPy gets 9"):
        api.load(DOUBLE).sympy()


def test_an_ensemble_in_xarray() -> None:
    xarray = pytest.importorskip("xarray")
    table = {"theta1": [0.1, 0.2, 0.3]}
    found = api.load(DOUBLE).ensemble(table, 1, every=0.5, method="rk4", step=0.01).to_xarray()
    assert isinstance(found, xarray.Dataset) and found["theta1"].dims == ("member", "t")
    assert found["theta1"].shape == (3, 3) and float(found["theta1"][1, 0]) == 0.2
