"""Condition numbers along a motion, and the digits that are lost: against NumPy and fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from stability_asker import asker
from sympy import QQ
from sympy.polys.matrices import DomainMatrix

import pkgen as api
from conftest import ROOT, seeds

EPSILON = 2.0**-52
DOUBLE = ROOT / "models/double_pendulum.lag"
NAMES = [(i, j) for i in range(3) for j in range(i, 3)]
LINEAR = f"""model linear
coord x1, x2, x3
{"".join(f"param m{i + 1}{j + 1} = {float(i == j)}" + chr(10) for i, j in NAMES)}
param f1 = 0; param f2 = 0; param f3 = 0
param k1 = 1; param k2 = 1; param k3 = 1
kinetic {" + ".join(f"m{i + 1}{j + 1}*x{i + 1}'*x{j + 1}'{'/2' * (i == j)}" for i, j in NAMES)}
potential f1*x1 + f2*x2 + f3*x3 + (k1*x1^2 + k2*x2^2 + k3*x3^2)/2
start x1 = 0.3, x2 = -0.2, x3 = 0.7
""".replace("; ", "\n")


def bauer(A: np.ndarray) -> float:
    """The least condition number over all scalings of rows and columns."""
    return max(abs(np.linalg.eigvals(abs(np.linalg.inv(A)) @ abs(A))))


def random_mass(rng: np.random.Generator, cond: float) -> np.ndarray:
    """Positive definite, of units that differ by powers of ten."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    M = Q @ np.diag(np.geomspace(1, cond, 3)) @ Q.T
    units = np.diag(10.0 ** rng.integers(-4, 5, 3))
    return units @ (M + M.T) / 2 @ units


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> api.Model:
    path = tmp_path_factory.mktemp("condition") / "linear.lag"
    path.write_text(LINEAR)
    return api.load(path)


def give(model: api.Model, M: np.ndarray, f: np.ndarray, k: np.ndarray) -> None:
    for i, j in NAMES:
        model.params[f"m{i + 1}{j + 1}"] = float(M[i, j])
    for i in range(3):
        model.params[f"f{i + 1}"], model.params[f"k{i + 1}"] = float(f[i]), float(k[i])


def exact(M: np.ndarray, f: np.ndarray) -> list[Fraction]:
    """M a = -f in fractions."""
    A, b = (DomainMatrix(x.tolist(), x.shape, QQ) for x in (lifted(M), lifted(-f[:, None])))
    return [Fraction(int(x.numerator), int(x.denominator)) for x in A.lu_solve(b).to_list_flat()]


def lifted(A: np.ndarray) -> np.ndarray:
    return np.vectorize(lambda x: QQ(*float(x).as_integer_ratio()), otypes=[object])(A)


@pytest.mark.parametrize("power", [0, 2, 5, 8, 11])
def test_of_random_masses_in_any_units(linear: api.Model, power: int) -> None:
    """As NumPy has it; and rounding takes as many digits from accelerations, and not more."""
    rng = np.random.default_rng(power)
    measured, predicted = [], []
    for _ in range(6):
        M = random_mass(rng, 10.0**power)
        f = rng.normal(size=3) * np.sqrt(np.diag(M))
        give(linear, M, f, np.zeros(3))
        found = linear.run(1, method="dop853").report["condition"]
        assert found["mass"]["cond"] == pytest.approx(bauer(M), rel=0.1)
        assert 10 ** found["lost"]["digits"] <= 1.01 * found["mass"]["cond"]
        a, true = linear.acceleration(np.zeros(3), np.zeros(3)), exact(M, f)
        terms = abs(M) @ abs(np.array(true, float)) / np.diag(M)
        error = max(abs(float(Fraction(x) - y)) / z for x, y, z in zip(a, true, terms, strict=True))
        measured.append(np.log10(max(error / EPSILON, 1)))
        predicted.append(found["lost"]["digits"])
    assert all(m <= p + 0.5 for m, p in zip(measured, predicted, strict=True))
    assert max(measured) > max(predicted) - 1.5
    assert power - 2.5 < max(predicted) < power + 1.5


@pytest.mark.parametrize("seed", seeds(range(3), 2))
@pytest.mark.parametrize("method", ["gauss1", "radau5"])
def test_of_the_equations_of_a_step(linear: api.Model, method: str, seed: int) -> None:
    """Newton's matrix of linear equations: the identity times M plus h^2 A^2 times K."""
    rng = np.random.default_rng(seed)
    M, k, h = random_mass(rng, 1e3), 10.0 ** rng.uniform(2, 6, 3), 0.05
    k *= np.diag(M)
    give(linear, M, np.zeros(3), k)
    found = linear.run(1, method=method, step=h).report["condition"]
    A = np.array([[0.5]])
    if method == "radau5":
        c = np.array([(4 - 6**0.5) / 10, (4 + 6**0.5) / 10, 1])
        powers = np.vander(c, increasing=True)
        A = (powers * c[:, None] / [1, 2, 3]) @ np.linalg.inv(powers)
    Newton = np.kron(np.eye(len(A)), M) + h * h * np.kron(A @ A, np.diag(k))
    assert found["step"]["cond"] == pytest.approx(bauer(Newton), rel=0.1)
    assert not np.allclose(np.diag(Newton), np.tile(np.diag(M), len(A)), rtol=0.01)


@pytest.fixture(scope="module")
def rails(tmp_path_factory: pytest.TempPathFactory) -> api.Model:
    path = tmp_path_factory.mktemp("condition") / "rails.lag"
    path.write_text(
        "model rails\ncoord x, y, z\nparam s = 1\nparam m = 3\n"
        "kinetic x'^2/2 + m*y'^2/2 + z'^2/2\npotential z + x*z + x^2*y\n"
        "constraint a: x - 2*y + z = 0\nconstraint b: x - (2 + s)*y + z = 0\nstart x = 1, z = -1\n"
    )
    return api.load(path)


@pytest.mark.parametrize("slope", [2.0, 0.1, 1e-3, 1e-6])
def test_of_constraints_that_all_but_follow_from_each_other(rails: api.Model, slope: float) -> None:
    rails.params["s"] = slope
    result = rails.run(1, method="dop853")
    J = np.array([[1, -2, 1], [1, -2 - slope, 1]])
    A = J @ np.diag([1, 1 / 3, 1]) @ J.T
    found = result.report["condition"]
    assert found["constraints"]["cond"] == pytest.approx(bauer(A), rel=0.1)
    assert found["mass"]["cond"] == pytest.approx(1)
    assert ("J M^-1 J^T is nearly singular" in result.messages) == (slope < 1e-2)


# At t = 0.6, by gauss in __float128 at 1e-28 (m1 = 1e-3 as pkgen run --enclose has it, +-1e-13).
STRETCHED = {1e-1: -3.17024207187513380, 1e-3: -2.8919710636268852, 1e-6: -2.88648315881497908}


@pytest.mark.parametrize("m1", STRETCHED)
def test_of_a_mass_that_is_all_but_zero(m1: float) -> None:
    """The rods are stretched at t = 0.458, where det M is of the size of m1; the tightest motion
    loses there as many digits as are predicted, but for two."""
    model = api.load(DOUBLE)
    model.params["m1"] = m1
    result = model.run(0.6, method="dop853", rtol=1e-14, record=["theta1'"])
    lost = result.report["condition"]["lost"]
    assert lost["digits"] == pytest.approx(-np.log10(m1), abs=1)
    assert ("nearly singular" in result.messages) == (m1 < 1e-5)
    off = abs(result["theta1'"][-1] / STRETCHED[m1] - 1)
    assert abs(np.log10(off / EPSILON) - lost["digits"]) < 2
    assert lost["t"] == pytest.approx(0.4585, abs=0.01)


@pytest.mark.parametrize("rtol", [1e-13, 1e-14])
def test_rounding_there_is_no_excuse_for_errors_after_it(rtol: float) -> None:
    """Steps that grow again are judged by what rounding does to them, not by what it did before: by
    the older noise gauss was off by 3e-7 at 1e-14, more than at 1e-8."""
    model = api.load(DOUBLE)
    model.params["m1"] = 1e-6
    result = model.run(0.6, method="gauss", rtol=rtol, record=["theta1'"])
    assert abs(result["theta1'"][-1] / STRETCHED[1e-6] - 1) < 1e-9


@pytest.mark.parametrize("apart", [0.5, 1e-3, 1e-8])
def test_of_a_map(apart: float) -> None:
    """M along the motion and the equations of a midpoint step, M + h^2 K/4, in closed form."""
    asked = asker(
        f"model near\ncoord x, y\nkinetic x'^2/2 + y'^2/2 + (1 - {apart!r})*x'*y'\n"
        "potential x^2/2 + y^2\nstart x = 0.1, y = 0.2\n",
        until=10.0,
    )
    motion = asked.motion()
    assert motion.condition is not None
    assert motion.condition["mass"]["cond"] == pytest.approx(2 / apart - 1, rel=0.1)
    assert ("M is nearly singular" in (motion.warning or "")) == (apart < 1e-6)
    M, K, h = np.array([[1, 1 - apart], [1 - apart, 1]]), np.diag([1.0, 2.0]), 0.5
    made = asked.point("gauss1", h)
    assert made.cond == pytest.approx(bauer(M + h * h / 4 * K), rel=0.1)
    assert asked.point("rk4", 0.01).cond == 0


def test_that_it_is_seldom_asked(linear: api.Model) -> None:
    """So that no run is slower for it; and not of members, nor where nothing is solved."""
    give(linear, np.eye(3), np.zeros(3), np.ones(3))
    report = linear.run(1000, method="rk4", step=0.01).report
    assert report["steps"] == 100_000 and 30 < report["condition"]["looks"] < 80
    assert "condition" not in linear.ensemble({"k1": [1.0, 2.0]}, 1).report
