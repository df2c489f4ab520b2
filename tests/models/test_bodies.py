"""Bodies that turn, roll and hang together: the models' motions against Newton's and Euler's laws.

The starts are nobody's special case: of general direction, far from rest. What has a closed form is
expected by the models' own scenes. Each bound is missed by a loose tolerance.
"""

import json

import numpy as np
import pytest
from oracles import attitude
from oracles.dumbbell import Body, Dumbbell
from oracles.gimbals import Gimbals
from oracles.heavy_top import Top
from oracles.integrate import integrate
from oracles.rolling import Rolling, disk, ellipsoid

from conftest import ROOT, ran

GOOD, LOOSE = "1e-13", "1e-5"


def last(pkgen, path: str, until: float, rtol: str, *words: str) -> dict[str, float]:
    """The final row of a run, by the names of its columns."""
    command = ["run", ROOT / "models" / path, "--until", until, "--every", until, "--json"]
    done = ran(*command, "--method", "gauss", "--rtol", rtol, *words)
    told = json.loads(done.stdout)
    return dict(zip((c["name"] for c in told["columns"]), told["rows"][-1], strict=True))


def turned(row: dict[str, float], name: str = "R") -> np.ndarray:
    return attitude.matrix(np.array([row[f"{name}.{c}"] for c in "wxyz"]))


def rates(row: dict[str, float], name: str = "R") -> np.ndarray:
    return np.array([row[f"omega({name}).{c}"] for c in "xyz"])


def setting(**values: float) -> list[str]:
    return [word for name, value in values.items() for word in ("--set", f"{name}={value!r}")]


def starting(name: str, omega: np.ndarray) -> list[str]:
    parts = zip("xyz", map(float, omega), strict=True)
    return [word for c, x in parts for word in ("--start", f"omega({name}).{c}={x!r}")]


def alike(found: dict, want: np.ndarray, bound: float, name: str = "R", scale: float = 1) -> bool:
    """Attitude and rates as those of (quaternion, ..., rates)."""
    off = np.abs(turned(found, name) - attitude.matrix(want[:4])).max()
    return 0 < max(off, np.abs(rates(found, name) - want[-3:]).max() / scale) < bound


def test_a_free_body_of_three_moments(pkgen) -> None:
    moments, omega = np.array([1.3, 2.1, 2.9]), np.array([0.4, 1.1, -0.7])

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        w = y[4:]
        return np.concatenate([attitude.rate(y[:4], w), np.cross(moments * w, w) / moments])

    want = integrate(rate, np.concatenate([[1, 0, 0, 0], omega]), np.array([0, 6.0]), 0.05)[-1]
    words = setting(I1=1.3, I2=2.1, I3=2.9) + starting("R", omega)
    run = ("bodies/free_body.lag", 6.0)
    assert alike(last(pkgen, *run, GOOD, *words), want, 1e-11)
    assert not alike(last(pkgen, *run, LOOSE, *words), want, 1e-11)


def test_a_top_thrown(pkgen) -> None:
    top, omega = Top(i1=1.2, i3=0.7, mgl=2 * 0.3 * 9.81), np.array([1.0, -2.0, 9.0])
    start = np.concatenate([attitude.turn((1, 0, 0), 0.6), omega])
    want = integrate(top.rate, start, np.array([0, 3.0]), 0.02)[-1]
    words = setting(I1=1.2, I3=0.7, M=2.0, l=0.3) + starting("R", omega)
    run = ("bodies/heavy_top_rotation.lag", 3.0)
    assert alike(last(pkgen, *run, GOOD, *words), want, 1e-11, scale=9)
    assert not alike(last(pkgen, *run, LOOSE, *words), want, 1e-11, scale=9)


@pytest.mark.parametrize("drag", [0.0, 1e-4])
def test_a_rattleback(pkgen, drag: float) -> None:
    inertia = np.array([[2, -0.2, 0], [-0.2, 16, 0], [0, 0, 17]]) * 1e-4
    stone = Rolling(ellipsoid(0.2, 0.03, 0.02, 0.01), inertia, drag=drag)
    tilted = attitude.product(attitude.turn((1, 0, 0), 0.02), attitude.turn((0, 1, 0), -0.01))
    start = np.concatenate([tilted, [0, 0], [0, 0.4, -3]])
    want = integrate(stone.rate, start, np.array([0, 0.3]), 0.005)[-1]
    words = setting(alpha=0.02, beta=-0.01, n2=0.4, n3=-3.0, sigma=drag)
    run = ("constrained/rattleback.lag", 0.3)
    found = last(pkgen, *run, GOOD, *words)
    assert alike(found, want, 1e-9, scale=5)
    assert [found["x"], found["y"]] == pytest.approx(want[4:6], abs=1e-11)
    assert not alike(last(pkgen, *run, LOOSE, *words), want, 1e-9, scale=5)


def test_a_disk_that_rolls(pkgen) -> None:
    a, m = 0.0375, 0.44
    body = Rolling(disk(a), m * a * a * np.diag([0.25, 0.25, 0.5]), mass=m)
    theta, nod, W, w = 0.9, 2.0, 9.0, -14.0
    omega = np.array([nod, W * np.sin(theta), w])
    start = np.concatenate([attitude.turn((1, 0, 0), theta), [0, 0], omega])
    want = integrate(body.rate, start, np.array([0, 1.0]), 0.005)[-1]
    words = setting(theta0=theta, nod=nod, W0=W, w0=w)
    run = ("constrained/rolling_disk.lag", 1.0)
    found = last(pkgen, *run, GOOD, *words)
    assert alike(found, want, 1e-10, scale=14)
    assert [found["x"], found["y"]] == pytest.approx(want[4:6], abs=1e-11)
    assert not alike(last(pkgen, *run, LOOSE, *words), want, 1e-10, scale=14)


def test_two_bodies_on_a_joint(pkgen) -> None:
    one = Body(1.5, np.array([0.3, 0.3, 0.1]), np.array([0, 0, -0.6]))
    two = Body(0.8, np.array([0.2, 0.35, 0.15]), np.array([0, 0, 0.3]))
    w1, w2, V = np.array([0.7, -0.4, 3.0]), np.array([-0.9, 1.1, -2.0]), 0.3
    apart = np.cross(w2, two.joint) - np.cross(w1, one.joint)  # v1 - v2
    part = two.mass / (one.mass + two.mass)
    v1 = np.array([V, 0, 0]) + part * apart
    r1 = np.array([0, 0, part * 0.9])
    start = np.concatenate([[1, 0, 0, 0], [1, 0, 0, 0], w1, w2, r1, v1])
    want = integrate(Dumbbell(one, two).rate, start, np.array([0, 3.0]), 0.02)[-1]
    words = setting(m1=1.5, m2=0.8, l1=0.6, l2=0.3, A2=0.2, B2=0.35, C2=0.15)
    run = ("constrained/dumbbell.lag", 3.0)
    found = last(pkgen, *run, GOOD, *words)
    assert alike(found, np.concatenate([want[:4], want[8:11]]), 1e-11, "R1", 3)
    assert alike(found, np.concatenate([want[4:8], want[11:14]]), 1e-11, "R2", 3)
    assert [found["x1"], found["y1"], found["z1"]] == pytest.approx(want[14:17], abs=1e-12)
    loose = last(pkgen, *run, LOOSE, *words)
    assert not alike(loose, np.concatenate([want[:4], want[8:11]]), 1e-11, "R1", 3)


def test_gimbals_by_an_attitude_and_by_three_angles(pkgen) -> None:
    """Through the lock and out again."""
    start = np.array([0.4, np.radians(20), 2.5, -6])
    times = np.linspace(0, 2, 41)
    rows = integrate(lambda t, y: Gimbals().rate(0.6, y), start, times, 0.01)
    assert rows[:, 1].min() < -0.1  # it went through
    run = ("constrained/gimbals.lag", 2.0)

    def off(rtol: str) -> float:
        found = last(pkgen, *run, rtol)
        names = ("alpha", "beta", "alpha'", "beta'")
        return max(abs(found[n] - y) for n, y in zip(names, rows[-1], strict=True))

    assert 0 < off(GOOD) < 1e-10 < off(LOOSE)


@pytest.mark.parametrize(("n", "end"), [(1, 2.0), (2, 0.2**3 / 0.03), (0.5, 0.2**1.5 / 0.015)])
def test_eulers_disk_ends_in_finite_time(pkgen, n: float, end: float) -> None:
    """X1: a run past the end says so, and when, whatever the friction."""
    run = ["run", ROOT / "models/bodies/euler_disk.lag", "--set", f"n={n}", "--json"]
    done = pkgen(*run, "--until", 9, "--every", 9, "--method", "dop853", "--rtol", "1e-13")
    assert done.returncode == 4
    report = json.loads(done.stdout)["report"]
    assert report["status"] == "PK_SINGULAR_TIME"
    assert report["last_valid"] == pytest.approx(end, abs=1e-9)
    assert report["last_valid"] < end
    loose = pkgen(*run, "--until", 9, "--every", 9, "--method", "dop853", "--rtol", "1e-4")
    assert abs(json.loads(loose.stdout)["report"]["last_valid"] - end) > 1e-9


def bobs(row: dict[str, float]) -> list[float]:
    """Places, of rods one metre long, from the angles."""
    places, x, y = [], 0.0, 0.0
    for name in ("theta", "theta1", "theta2"):
        if name in row:
            x, y = x + np.sin(row[name]), y - np.cos(row[name])
            places += [x, y]
    return places


@pytest.mark.parametrize(
    ("rods", "angles"),
    [
        ("constrained/pendulum_rod.lag", "pendulums/pendulum.lag"),
        ("constrained/double_pendulum_rods.lag", "double_pendulum.lag"),
    ],
)
def test_a_pendulum_of_rods_moves_as_that_of_angles(pkgen, rods: str, angles: str) -> None:
    """Places of the bobs at a time of no special meaning."""
    want = bobs(last(pkgen, angles, 3.7, GOOD))

    def off(rtol: str) -> float:
        found = last(pkgen, rods, 3.7, rtol)
        names = [n for n in found if n[0] in "xy" and "'" not in n]
        assert len(names) == len(want)
        return max(abs(found[n] - place) for n, place in zip(names, want, strict=True))

    assert 0 < off(GOOD) < 1e-10 < off(LOOSE)
