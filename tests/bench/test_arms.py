"""The arms of `python -m bench arms`: pkgen's C in the bench's own loop beside M and f by Jacobians
of the links; the forms that other packages read beside the model. No time is asserted."""

import xml.etree.ElementTree as Xml
from dataclasses import replace

import numpy as np
import pytest

from bench import arms, builds, environment
from bench.arm_models import CENTRE, GRAVITY, LENGTH, links, mjcf, quaternion, rows
from bench.turns import Runner, take_turns

N = 5
BUILD = builds.QUICK_BUILDS[0]


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    for module in (arms, builds):
        monkeypatch.setattr(module, "OUTPUT", tmp_path)


def drawn(count: int):
    """As main.c draws."""
    state = 2385
    while count:
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        yield (state >> 11) / 2**52 - 1
        count -= 1


def states() -> list[tuple[np.ndarray, np.ndarray]]:
    numbers = np.array(list(drawn(6 * N))).reshape(-1, 2)
    return [
        tuple(x * y for x, y in zip((3, 2), part.T, strict=True))
        for part in numbers.reshape(3, N, 2)
    ]


def turn(axis, angle: float) -> np.ndarray:
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def mass_and_potential(q: np.ndarray) -> tuple[np.ndarray, float]:
    """By the velocity of each link's centre, and its spin, where one angle alone changes."""
    frame, joint, axes, joints = np.eye(3), np.zeros(3), [], []
    mass, potential = np.zeros((N, N)), 0.0
    for k, link in enumerate(links(N)):
        axes.append(frame @ np.array(link.axis, dtype=float))
        joints.append(joint)
        frame = frame @ turn(link.axis, q[k])
        centre = joint + CENTRE * frame[:, 2]
        moving, spin = np.zeros((3, N)), np.zeros((3, N))
        for i in range(k + 1):
            moving[:, i], spin[:, i] = np.cross(axes[i], centre - joints[i]), axes[i]
        mass += link.mass * moving.T @ moving + link.inertia[0][0] * spin.T @ spin
        potential += link.mass * GRAVITY * centre[2]
        joint = joint + LENGTH * frame[:, 2]
    return mass, potential


def force(q: np.ndarray, v: np.ndarray, h: float = 1e-5) -> np.ndarray:
    """dT/dq - dV/dq - (dM/dt) v, by differences."""
    slope = np.zeros(N)
    for i in range(N):
        ends = [mass_and_potential(q + s * h * np.eye(N)[i]) for s in (1, -1)]
        (up, above), (down, below) = ends
        slope[i] = (v @ (up - down) @ v / 2 - (above - below)) / (2 * h)
    turned = (mass_and_potential(q + h * v)[0] - mass_and_potential(q - h * v)[0]) / (2 * h)
    return slope - turned @ v


def test_own_c_has_the_arms_accelerations_mass_and_force() -> None:
    (runner,) = arms._own(arms.arm(N), arms.OWN, [BUILD], 1e-3)
    nanoseconds, (a, mass, f) = runner.run()
    assert nanoseconds > 0
    for k, (q, v) in enumerate(states()):
        expected, right = mass_and_potential(q)[0], force(q, v)
        found = np.array(mass[k * N * N :][: N * N]).reshape(N, N)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert f[k * N :][:N] == pytest.approx(right, rel=1e-6, abs=1e-6 * abs(right).max())
        assert found @ np.array(a[k * N :][:N]) == pytest.approx(f[k * N :][:N], rel=1e-9, abs=1e-9)


def test_what_the_peers_read_is_the_same_arm() -> None:
    table = [line.split() for line in rows(links(N)).splitlines()]
    body = Xml.fromstring(mjcf(links(N))).find("worldbody/body")
    for k, (link, row) in enumerate(zip(links(N), table, strict=True)):
        parent, kind, *numbers = int(row[0]), row[1], *map(float, row[2:])
        axis, turned, at, (mass,), centre, inertia = parts(numbers, 3, 9, 3, 1, 3, 9)
        assert (parent, kind, axis, mass) == (k - 1, "r", [*link.axis], link.mass)
        assert (centre, at) == ([0, 0, CENTRE], [0, 0, LENGTH if k else 0])
        assert turned == [*np.eye(3).flat] and inertia == [*np.array(link.inertia).flat]
        inertial, joint = body.find("inertial"), body.find("joint")
        assert floats(body.get("pos")) == at and floats(body.get("quat")) == [1, 0, 0, 0]
        assert floats(joint.get("axis")) == axis and joint.get("type") == "hinge"
        assert float(inertial.get("mass")) == mass and floats(inertial.get("pos")) == centre
        assert floats(inertial.get("fullinertia")) == [link.inertia[0][0]] * 3 + [0] * 3
        body = body.find("body")
    assert body is None


@pytest.mark.parametrize(
    "axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8), (2 / 3, -2 / 3, 1 / 3)]
)
def test_turned_frames_as_quaternions(axis) -> None:
    for angle in (0, 1e-9, 0.7, 2.9, np.pi, 4, 6.2):
        w, *v = quaternion(tuple(map(tuple, turn(axis, angle))))
        wanted = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.array(axis))])
        assert abs(np.array([w, *v]) @ wanted) == pytest.approx(1, abs=1e-15)
        assert np.abs(np.outer([w, *v], [w, *v]) - np.outer(wanted, wanted)).max() < 1e-15


def parts(numbers: list[float], *lengths: int) -> list[list[float]]:
    assert len(numbers) == sum(lengths)
    ends = np.cumsum(lengths)
    return [numbers[end - length : end] for end, length in zip(ends, lengths, strict=True)]


def floats(text: str) -> list[float]:
    return [float(x) for x in text.split()]


def test_another_result_stops_the_bench() -> None:
    def runner(title: str, a: list[float]) -> Runner:
        return Runner(title, "", lambda: (1.0, [a]))

    pair = replace(arms.arm(2), what=arms.WHAT[:1])
    same, close = [1.0, -2.0, 3.0, 5.0, 8.0, 9.0], [1.0 + 1e-12, -2.0, 3.0, 5.0, 8.0, 9.0]
    take_turns([runner("one", same), runner("two", close)], 2, arms.Agreement(pair))
    far = [1.0, -2.0 + 1e-9, *same[2:]]
    with pytest.raises(SystemExit, match=r"two, : another acceleration, by 5\.0e-10"):
        take_turns([runner("one", same), runner("two", far)], 2, arms.Agreement(pair))


def test_who_is_not_installed_is_left_out_with_a_word(monkeypatch) -> None:
    six = replace(arms.arm(6), what=arms.WHAT[:1])

    def missing(*_):
        raise builds.Unavailable("pin is not installed")

    monkeypatch.setattr(arms, "_ways", lambda n: {arms.OWN: fake, arms.ABA: missing})
    found, refused = arms.measured(six, [BUILD], 3, 0.0)
    assert arms.missing_of(refused) == [f"- {arms.ABA}: pin is not installed"]
    assert arms.ratios({six: found}).splitlines()[2].split("|")[2].strip() == "-"
    monkeypatch.setattr(arms, "_ways", lambda n: {arms.OWN: missing, arms.ABA: fake})
    found, _ = arms.measured(six, [BUILD], 3, 0.0)
    assert arms.ratios({six: found}).splitlines()[2].split("|")[2].strip() == "-"


def fake(title: str, *_) -> list[Runner]:
    return [Runner(title, "gcc", lambda: (1.0, [[1.0, 2.0, 3.0]]))]


def test_the_peers_are_among_those_that_are_installed() -> None:
    assert {"pin", "cmeel-eigen", "mujoco"} <= set(environment.PEERS)
