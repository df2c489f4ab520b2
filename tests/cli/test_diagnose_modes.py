"""`--diagnose modes` against closed forms, and Fermi, Pasta, Ulam and Tsingou's recurrence."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conftest import ROOT, case, diagnosed

OSCILLATORS = ROOT / "models/coupled_oscillators.lag"
FPUT = ROOT / "models/chains/fput.lag"
FREE = case("diagnose_modes_chain")


def modes(folder: Path, model: Path | str, *arguments: object) -> tuple[dict, str]:
    found, said, _ = diagnosed(folder, model, "modes", *arguments)
    return found["modes"], said


def test_of_a_linear_chain(tmp_path: Path) -> None:
    # Three masses between walls: 2 sin(j pi/8), shapes sin(j pi i/4)/sqrt 2; energies constant.
    found, said = modes(tmp_path, OSCILLATORS, "--until", "20", "--rtol", "1e-13")
    frequencies = [2 * math.sin(j * math.pi / 8) for j in (1, 2, 3)]
    assert all(abs(a - b) < 1e-14 for a, b in zip(found["frequencies"], frequencies, strict=True))
    shape = [math.sin(math.pi * i / 4) / math.sqrt(2) for i in (1, 2, 3)]
    assert all(abs(a - b) < 1e-14 for a, b in zip(found["shapes"][0]["shape"], shape, strict=True))
    assert found["equilibrium"] == [0, 0, 0] and found["energy"] == 0
    # By hand: q = (.7 -.2 .1), q' = (0 .3 -.5), of the slowest.
    Q = sum(s * x for s, x in zip(shape, (0.7, -0.2, 0.1), strict=True))
    P = sum(s * x for s, x in zip(shape, (0, 0.3, -0.5), strict=True))
    first = found["rows"][0]
    assert abs(first[3] - (P**2 + (frequencies[0] * Q) ** 2) / 2) < 1e-15
    assert len(found["rows"]) == 200 and found["left_out"] == 0 and found["modes"] == 3
    for row in found["rows"]:
        assert abs(row[1] - sum(row[3:])) < 1e-15 and abs(row[2]) < 1e-15
        assert all(abs(a - b) < 1e-11 for a, b in zip(row[3:], first[3:], strict=True))
    assert "modes: 0.7653668647, 1.414213562, 1.847759065 rad/s" in said
    assert "modes: at the end 0.87 in all modes, 0.607199 in mode 3" in said


def test_recurrence(tmp_path: Path) -> None:
    # REGIMES F1: E = .07704437 in the first mode, and .98127 of it again after 146.447 periods; in
    # between it is elsewhere. The nonlinear energy is what is left of a constant h.
    period = 64.0257093
    steps = ["--method", "kahan_li8", "--step", "0.5", "--until", str(146.447 * period)]
    found, _ = modes(tmp_path, FPUT, *steps)
    assert abs(found["frequencies"][0] * period / (2 * math.pi) - 1) < 1e-8
    first, last = found["rows"][0], found["rows"][-1]
    assert abs(first[3] - 0.07704437) < 5e-9 and abs(first[1] - first[3]) < 1e-15
    assert abs(last[3] / first[3] - 0.98127) < 2e-4
    assert min(row[3] for row in found["rows"]) < 0.1 * first[3]
    assert 1e-4 < max(abs(row[2]) for row in found["rows"]) < 0.05 * first[1]
    assert all(abs(row[1] + row[2] - first[1]) < 1e-9 for row in found["rows"])


def test_free_ends_and_a_pendulum(tmp_path: Path) -> None:
    found, _ = modes(tmp_path, FREE, "--until", "10")
    # All together without a force: P^2/2 = (sum of q'/sqrt N)^2/2; the others 2 sin(j pi/8).
    assert found["frequencies"][0] == 0
    assert abs(found["frequencies"][1] - 2 * math.sin(math.pi / 8)) < 1e-14
    assert all(abs(row[3] - 0.25**2 / 2) < 1e-12 for row in found["rows"])
    assert all(abs(row[2]) < 1e-11 for row in found["rows"])
    # REGIMES D1, about the equilibrium that it swings about: hanging, and at rest with the inner
    # rod upright.
    double = ROOT / "models/double_pendulum.lag"
    near = ["--start", "theta1=0.1", "--start", "theta2=0.1", "--until", "1"]
    found, _ = modes(tmp_path, double, *near)
    assert abs(found["frequencies"][0] - 2.3971993979) < 1e-10
    assert abs(found["frequencies"][1] - 5.7873512980) < 1e-10
    assert 1e-6 < abs(found["rows"][-1][2]) < 0.01 * found["rows"][-1][1]
    rest = [x for name in ("theta1'", "theta2'", "theta2") for x in ("--start", f"{name}=0")]
    upright = [*rest, "--start", "theta1=180 [deg]", "--until", "0.1"]
    found, said = modes(tmp_path, double, *upright)
    assert abs(found["equilibrium"][0] - math.pi) < 1e-12 and abs(found["equilibrium"][1]) < 1e-12
    assert found["frequencies"][0] is None and found["frequencies"][1] is not None
    assert abs(found["squares"][0] + 9.81 * math.sqrt(2)) < 1e-11
    rate = math.sqrt(9.81 * math.sqrt(2))
    assert f"1 of 2 modes leave it, at the rate {rate:.10g} /s" in said
    assert f"modes: {rate:.10g} rad/s" in said  # of the other, as it happens the same


LINE = "model m\ncoord x\nkinetic x'^2/2\npotential {}\n"
# In WELLS x = 0.03 is the top between them, of an energy above that of most starts.
WELLS = LINE.format("(x^2 - 1)^2*(1 + x/8)/4")
RIDGE = LINE.format("x^2/2 - 3*exp(-2*(x - 3)^2) + 4*exp(-8*(x - 2)^2)")
PENDULUM = LINE.format("-cos(x)")


@pytest.mark.parametrize(
    ("text", "starts", "place", "square"),
    [
        (WELLS, "x=0.3", 1, 2.25),  # nearer to the top
        (WELLS, "x=-0.3", -1, 1.75),
        (WELLS, "x=-0.3 x'=0.01", -1, 1.75),
        (WELLS, "x=1.2", 1, 2.25),
        (WELLS, "x=0.1 x'=3", 1, 2.25),  # over the top: of both the nearer
        (WELLS, "x=-0.1 x'=3", -1, 1.75),
        (LINE.format("(x^2 - 1)^2/4"), "x=0", 0, -1),  # at rest on top of a hill
        (LINE.format("-x^2/2"), "x=0.1", 0, -1),  # beside one behind which there is no valley
        (LINE.format("x^2/2 + max(0, x - 1)^2"), "x=1.5", 0, 1),  # kinks elsewhere are no matter
        (RIDGE, "x=1.6", 0, None),  # a far valley in sight, and a near one behind a ridge
        (PENDULUM, "x=9", 2 * math.pi, 1),  # the turn of an angle that is next
    ],
)
def test_about_what_a_motion_swings(tmp_path: Path, text, starts, place, square) -> None:
    """Not about the nearest place where nothing pulls, but in the well in which it is."""
    words = [f"--start={start}" for start in starts.split()]
    found, said = modes(tmp_path, text, "--until", "1", *words)
    assert abs(found["equilibrium"][0] - place) < (1e-12 if square else 1e-6)
    if square:
        assert abs(found["squares"][0] - square) < 1e-12
        assert ("leave it" in said or "unstable" in said) == (square < 0)
        assert (found["frequencies"] == [None]) == (square < 0)


def test_energies_of_an_angle_that_turns(tmp_path: Path) -> None:
    first = modes(tmp_path, PENDULUM, "--start", "x=9", "--until", "1")[0]["rows"][0]
    assert abs(first[1] - (9 - 2 * math.pi) ** 2 / 2) < 1e-12 and abs(first[2]) < 2
    turning = ["--start", "x=0", "--start", "x'=3", "--until", "10"]
    for row in modes(tmp_path, PENDULUM, *turning)[0]["rows"]:
        assert abs(row[1] + row[2] - 4.5) < 1e-8 and row[1] < math.pi**2 / 2 + 4.5


def test_energies_without_what_a_total_derivative_adds_to_momenta(tmp_path: Path) -> None:
    text = "model gauge\ncoord x, y\nstart x = 0.1, y' = 0.5\n"
    text += "lagrangian (x'^2 + y'^2)/2 + 1.5*(x*y' + y*x') - x^2/2 - y^2\n"
    for _, *energies in modes(tmp_path, text, "--until", "20")[0]["rows"]:
        assert energies == pytest.approx((0.13, 0, 0.005, 0.125), abs=1e-9)


def test_of_what_a_scene_reduces_to(tmp_path: Path) -> None:
    """A top's nutation about its steady precession; the whole top rests nowhere."""
    found, _ = modes(tmp_path, ROOT / "models" / "heavy_top.lag", "--scene", "nutation")
    assert found["frequencies"] == pytest.approx([7.3155695066], abs=1e-9)
    assert found["equilibrium"] == pytest.approx([0.6593415109], abs=1e-9)
