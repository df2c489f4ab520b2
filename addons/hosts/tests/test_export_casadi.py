"""External functions for CasADi: by ctypes against the kernels, and by CasADi where it is."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest

import pkgen
from conftest import ROOT, run_pkgen, written

PAGE = (ROOT / "addons/hosts/export-casadi.md").read_text()
CART = """model cart_pole
param m1 = 1 [kg] in (0, inf)
param m2 = 0.3 [kg] in (0, inf)
param l = 0.5 [m] in (0, inf)
param g = 9.81 [m/s^2]
param reach = 2*l
coord x [m], a [rad]
input u [N]
let pole = [x + l*sin(a), -l*cos(a), 0]
kinetic m1/2*x'^2 + m2/2*dot(pole', pole')
potential m2*g*pole.y
force x = u
observe tip = pole.x
observe push = u*x'
start x = reach/4, a = 0.1
"""
REAL, INT = ctypes.POINTER(ctypes.c_double), ctypes.c_longlong


class Function:
    """A function of the library, by the interface that CasADi documents."""

    def __init__(self, path: Path, name: str):
        self.lib, self.name = ctypes.CDLL(str(path)), name
        self.inputs, self.outputs = self._described("in"), self._described("out")
        self.work = [INT() for _ in range(4)]
        assert self._call("work", *map(ctypes.byref, self.work)) == 0

    def _call(self, what: str, *words, result=ctypes.c_int):
        called = getattr(self.lib, f"{self.name}_{what}")
        called.restype = result
        return called(*words)

    def _described(self, kind: str) -> dict:
        found = {}
        for i in range(self._call(f"n_{kind}", result=INT)):
            name = self._call(f"name_{kind}", INT(i), result=ctypes.c_char_p).decode()
            s = self._call(f"sparsity_{kind}", INT(i), result=ctypes.POINTER(INT))
            (rows, columns), ends = s[:2], s[2 : 3 + s[1]]
            columns_of = np.repeat(np.arange(columns), np.diff(ends))
            found[name] = (rows, columns), (s[3 + columns : 3 + columns + ends[-1]], columns_of)
        return found

    def __call__(self, *given) -> list[np.ndarray]:
        """Returns the outputs, dense."""
        given = [np.array(x, float) for x in given]
        assert [len(x) for x in given] == [n for (n, _), _ in self.inputs.values()][: len(given)]
        out = [np.full(len(rows), np.nan) for _, (rows, _) in self.outputs.values()]
        arg = (REAL * self.work[0].value)(*(x.ctypes.data_as(REAL) for x in given))
        res = (REAL * self.work[1].value)(*(x.ctypes.data_as(REAL) for x in out))
        w = np.full(self.work[3].value, np.nan)
        failed = getattr(self.lib, self.name)(arg, res, None, w.ctypes.data_as(REAL), 0)
        if failed:
            raise ArithmeticError(self.name)
        dense = []
        for (shape, at), values in zip(self.outputs.values(), out, strict=True):
            dense.append(np.zeros(shape))
            dense[-1][tuple(map(list, at))] = values
        return dense


def export(model: Path, to: Path, *words: str) -> Path:
    done = run_pkgen("export", model, "--as", "casadi", "-o", to, *words)
    assert done.returncode == 0, done.stderr
    (library,) = [path for path in to.iterdir() if path.suffix != ".c"]
    return library


def differences(f: Function, given: list[np.ndarray], k: int) -> np.ndarray:
    """Returns the derivative by argument k, from four values of f to fourth order. The steps
    rarely meet a knot of a table."""

    def moved(j: int, by: float) -> np.ndarray:
        changed = [x.copy() for x in given]
        changed[k][j] += by
        return f(*changed)[0][:, 0]

    steps = 1e-5 * np.fmax(abs(given[k]), 0.1)
    pairs = [[moved(j, s * h) - moved(j, -s * h) for s in (1, 2)] for j, h in enumerate(steps)]
    columns = [(8 * a - b) / (12 * h) for (a, b), h in zip(pairs, steps, strict=True)]
    return np.array(columns).reshape(len(steps), len(f(*given)[0])).T


@pytest.mark.parametrize(
    "name",
    [
        "cart_pole",
        "heavy_top",
        "bodies/heavy_top_rotation",
        "bodies/weather_vane",
        "constrained/pendulum_rod",
        "pendulums/foucault",
        "pendulums/shaken_pivot",
        "parts/motor",
    ],
)
def test_values_and_jacobians(name: str, tmp_path: Path) -> None:
    cart = name == "cart_pole"
    path = written(tmp_path, CART) if cart else ROOT / f"models/{name}.lag"
    library, random = export(path, tmp_path / "made"), np.random.default_rng(7)
    (p,) = Function(library, "p0")()
    (x,) = Function(library, "x0")(p[:, 0])
    model = pkgen.load(path)
    n = len(model.coordinates)
    assert x[:, 0] == pytest.approx(model.start)
    shown = (library.parent / f"{library.stem}.c").read_text()
    for function in ("f", "x0", *(["y"] if "y(x" in shown else [])):
        f, slopes = Function(library, function), Function(library, f"jac_{function}")
        sizes = {key: shape[0] for key, (shape, _) in f.inputs.items()}
        for _ in range(3):
            at = {key: random.normal(size=count) for key, count in sizes.items()}
            at["p"] = p[:, 0] * random.uniform(0.95, 1.05, len(p))
            if "x" in at:
                at["x"] = x[:, 0] + 0.1 * random.normal(size=len(x))
            if "t" in at:
                at["t"] = random.uniform(1, 2, 1)
            given = list(at.values())
            blocks = slopes(*given, np.zeros(len(f(*given)[0])))
            for k, block in enumerate(blocks):
                expected = differences(f, given, k)
                size = max(1, abs(expected).max(initial=0))
                assert abs(block - expected).max(initial=0) < 2e-6 * size, (function, k)
            if function == "f":
                q, v = at["x"][:n], at["x"][n:]
                for key, value in zip(model.params, at["p"], strict=True):
                    model.params[key] = value
                a = model.acceleration(q, v, *at.get("t", [0.0]), at["u"] if sizes["u"] else None)
                assert f(*given)[0][:, 0] == pytest.approx([*v[:n], *a], rel=1e-11, abs=1e-11)


def test_sparsity(tmp_path: Path) -> None:
    library = export(written(tmp_path, CART), tmp_path / "made", "--set", "l=0.4")

    def pattern(function: str) -> list[list[str]]:
        found = []
        for shape, at in Function(library, function).outputs.values():
            dense = np.zeros(shape, int)
            dense[tuple(map(list, at))] = 1
            found.append(["".join(map(str, row)) for row in dense])
        return found

    of_p = ["00000", "00000", "11110", "11110"]
    assert pattern("jac_f") == [["0010", "0001", "0101", "0101"], ["0", "0", "1", "1"], of_p]
    assert pattern("jac_y") == [["1100", "0010"], ["0", "1"], ["00100", "00000"]]
    assert pattern("jac_x0") == [["00001", "00000", "00000", "00000"]]
    (p,) = Function(library, "p0")()
    assert p[:, 0] == pytest.approx([1, 0.3, 0.4, 9.81, 0.8])
    kept = export(written(tmp_path, CART), tmp_path / "kept", "--start", "x=0.7")
    assert Function(kept, "x0")(p[:, 0])[0][0] == 0.7
    assert not Function(kept, "jac_x0")(p[:, 0], np.zeros(4))[0].any()


def test_a_scene(tmp_path: Path) -> None:
    """A scene that holds the input; what its expectations compute are no outputs."""
    model = ROOT / "models/parts/motor.lag"
    f = Function(export(model, tmp_path / "made", "--scene", "starts_up"), "y")
    assert [*f.inputs] == ["x", "u", "p"] and f.inputs["u"][0] == (0, 1)
    assert f([0, 2], [], [0.02, 0.3, 1.5, 0.01, 12, 0.5, 0])[0] == pytest.approx((12 - 0.6) / 1.5)


def test_failures(tmp_path: Path) -> None:
    library = export(written(tmp_path, CART), tmp_path / "made")
    for name in ("f", "jac_f"):
        with pytest.raises(ArithmeticError):
            Function(library, name)(np.zeros(4), [0], [1, 1, -1, 1, 1])
        with pytest.raises(ArithmeticError):
            Function(library, name)([0, np.nan, 0, 0], [0], [1, 1, 1, 1, 1])
    with pytest.raises(ArithmeticError):
        Function(library, "x0")([1, 1, -1, 1, 1])
    sampled = ROOT / "models/controlled/cart_pole_swing_up.lag"
    done = run_pkgen("export", sampled, "--as", "casadi", "-o", tmp_path / "no")
    assert done.returncode and "runs no sample block" in done.stderr


def test_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("casadi")
    export(ROOT / "models/parts/motor.lag", tmp_path / "motor")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(re.search(r"^```python\n(.*?)^```", PAGE, re.M | re.S)[1], names)
    assert capfd.readouterr().out in PAGE
    expm = pytest.importorskip("scipy.linalg").expm
    drag = 0.01 + 0.3**2 / 1.5  # of K^2/R and b, by J = 0.02; steps of u are held for 0.01 s
    exact = expm(0.01 * np.array([[0, 1, 0], [0, -drag / 0.02, 10], [0, 0, 0]]))
    powers = [np.linalg.matrix_power(exact[:2, :2], k) @ exact[:2, 2] for k in range(50)]
    gramian = sum(np.outer(x, x) for x in powers)
    least = 0.01 * np.pi**2 * np.linalg.inv(gramian)[0, 0]
    assert names["least"] == pytest.approx(least, rel=1e-6)


def test_a_swing_up(tmp_path: Path) -> None:
    """M. Kelly, SIAM Review 59 (2017) 849: the least integral of u^2, by Simpson's rule."""
    ca = pytest.importorskip("casadi")
    path = str(export(written(tmp_path, CART), tmp_path / "made"))
    f, p = ca.external("f", path), ca.external("p0", path)()["p"]
    problem, N = ca.Opti(), 40
    h = 2 / N
    x, u, mid = problem.variable(4, N + 1), problem.variable(N + 1), problem.variable(N)
    rates = [f(x[:, k], u[k], p) for k in range(N + 1)]
    for k in range(N):
        half = (x[:, k] + x[:, k + 1]) / 2 + h / 8 * (rates[k] - rates[k + 1])
        whole = rates[k] + 4 * f(half, mid[k], p) + rates[k + 1]
        problem.subject_to(x[:, k + 1] - x[:, k] == h / 6 * whole)
    problem.subject_to(x[:, 0] == 0)
    problem.subject_to(x[:, N] == ca.vertcat(1, ca.pi, 0, 0))
    problem.subject_to(problem.bounded(-20, ca.vertcat(u, mid), 20))
    problem.minimize(h / 6 * (ca.sumsqr(u[:-1]) + ca.sumsqr(u[1:]) + 4 * ca.sumsqr(mid)))
    problem.set_initial(x[0, :], np.linspace(0, 1, N + 1))
    problem.set_initial(x[1, :], np.linspace(0, np.pi, N + 1))
    quiet = {"print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory"}
    problem.solver("ipopt", {"print_time": False}, quiet)
    assert problem.solve().value(problem.f) == pytest.approx(58.81, abs=0.01)
