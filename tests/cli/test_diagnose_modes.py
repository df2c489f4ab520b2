"""`--diagnose modes` against closed forms, and Fermi, Pasta, Ulam and Tsingou's recurrence."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import ROOT, case, ran, written

OSCILLATORS = ROOT / "models/coupled_oscillators.lag"
FPUT = ROOT / "models/chains/fput.lag"
FREE = case("diagnose_modes_chain")


def modes(pkgen, tmp_path: Path, model: Path, *arguments: object) -> tuple[dict, str]:
    done = ran("run", model, "--diagnose", "modes", "-o", tmp_path / "rows.csv", *arguments)
    report = json.loads((tmp_path / "rows.csv.json").read_text())["report"]
    return report["diagnostics"]["modes"], done.stderr


def test_of_a_linear_chain(pkgen, tmp_path: Path) -> None:
    # Three masses between walls: 2 sin(j pi/8), shapes sin(j pi i/4)/sqrt 2; energies constant.
    found, said = modes(pkgen, tmp_path, OSCILLATORS, "--until", "20", "--rtol", "1e-13")
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


def test_recurrence(pkgen, tmp_path: Path) -> None:
    # REGIMES F1: E = .07704437 in the first mode, and .98127 of it again after 146.447 periods; in
    # between it is elsewhere. The nonlinear energy is what is left of a constant h.
    period = 64.0257093
    steps = ["--method", "kahan_li8", "--step", "0.5", "--until", str(146.447 * period)]
    found, _ = modes(pkgen, tmp_path, FPUT, *steps)
    assert abs(found["frequencies"][0] * period / (2 * math.pi) - 1) < 1e-8
    first, last = found["rows"][0], found["rows"][-1]
    assert abs(first[3] - 0.07704437) < 5e-9 and abs(first[1] - first[3]) < 1e-15
    assert abs(last[3] / first[3] - 0.98127) < 2e-4
    assert min(row[3] for row in found["rows"]) < 0.1 * first[3]
    assert 1e-4 < max(abs(row[2]) for row in found["rows"]) < 0.05 * first[1]
    assert all(abs(row[1] + row[2] - first[1]) < 1e-9 for row in found["rows"])


def test_free_ends_and_a_pendulum(pkgen, tmp_path: Path) -> None:
    path = written(tmp_path, FREE)
    found, _ = modes(pkgen, tmp_path, path, "--until", "10")
    # All together without a force: P^2/2 = (sum of q'/sqrt N)^2/2; the others 2 sin(j pi/8).
    assert found["frequencies"][0] == 0
    assert abs(found["frequencies"][1] - 2 * math.sin(math.pi / 8)) < 1e-14
    assert all(abs(row[3] - 0.25**2 / 2) < 1e-12 for row in found["rows"])
    assert all(abs(row[2]) < 1e-11 for row in found["rows"])
    # REGIMES D1, about the equilibrium that it swings about: hanging, and at rest with the inner
    # rod upright.
    double = ROOT / "models/double_pendulum.lag"
    near = ["--start", "theta1=0.1", "--start", "theta2=0.1", "--until", "1"]
    found, _ = modes(pkgen, tmp_path, double, *near)
    assert abs(found["frequencies"][0] - 2.3971993979) < 1e-10
    assert abs(found["frequencies"][1] - 5.7873512980) < 1e-10
    assert 1e-6 < abs(found["rows"][-1][2]) < 0.01 * found["rows"][-1][1]
    rest = [x for name in ("theta1'", "theta2'", "theta2") for x in ("--start", f"{name}=0")]
    upright = [*rest, "--start", "theta1=180 [deg]", "--until", "0.1"]
    found, said = modes(pkgen, tmp_path, double, *upright)
    assert abs(found["equilibrium"][0] - math.pi) < 1e-12 and abs(found["equilibrium"][1]) < 1e-12
    assert found["frequencies"][0] is None and found["frequencies"][1] is not None
    assert abs(found["squares"][0] + 9.81 * math.sqrt(2)) < 1e-11
    rate = math.sqrt(9.81 * math.sqrt(2))
    assert f"1 of 2 modes leave it, at the rate {rate:.10g} /s" in said
    assert f"modes: {rate:.10g} rad/s" in said  # of the other, as it happens the same


def test_about_what_a_motion_swings(pkgen, tmp_path: Path) -> None:
    """Not about the nearest place where nothing pulls, but in the well in which it is."""
    wells = "model m\ncoord x\nkinetic x'^2/2\npotential (x^2 - 1)^2*(1 + x/8)/4\n"
    path = tmp_path / "model.lag"
    # x = 0.03 is the top between them, of an energy above that of these starts but the last two.
    for starts, place in (
        (["x=0.3"], 1),  # nearer to the top
        (["x=-0.3"], -1),
        (["x=-0.3", "x'=0.01"], -1),
        (["x=1.2"], 1),
        (["x=0.1", "x'=3"], 1),  # over the top: of both the nearer
        (["x=-0.1", "x'=3"], -1),
    ):
        path.write_text(wells)
        words = [x for text in starts for x in ("--start", text)]
        found, said = modes(pkgen, tmp_path, path, "--until", "1", *words)
        assert abs(found["equilibrium"][0] - place) < 1e-12, starts
        assert abs(found["squares"][0] - (2 + place / 4)) < 1e-12 and "unstable" not in said
    # At rest on top of a hill, and beside one behind which there is no valley.
    path.write_text("model m\ncoord x\nkinetic x'^2/2\npotential (x^2 - 1)^2/4\nstart x = 0\n")
    found, said = modes(pkgen, tmp_path, path, "--until", "1")
    assert found["squares"] == [-1] and found["frequencies"] == [None]
    assert "unstable equilibrium, in which the motion starts" in said and "rad/s" not in said
    path.write_text("model m\ncoord x\nkinetic x'^2/2\npotential -x^2/2\nstart x = 0.1\n")
    found, said = modes(pkgen, tmp_path, path, "--until", "1")
    assert found["squares"] == [-1] and "1 of 1 modes leave it, at the rate 1;" in said
    # Kinks elsewhere are no matter. Of bodies that attract each other no place far off is taken.
    path.write_text("model m\ncoord x\nkinetic x'^2/2\npotential x^2/2 + max(0, x - 1)^2\n")
    found, _ = modes(pkgen, tmp_path, path, "--start", "x=1.5", "--until", "1")
    assert found["squares"] == [1]
    bodies = ROOT / "models/particles/n_body.lag"
    done = pkgen("run", bodies, "--diagnose", "modes", "--until", "1")
    assert done.returncode == 2 and "no equilibrium was found" in done.stderr
    # A far valley in sight, and a near one behind a ridge.
    ridge = "potential x^2/2 - 3*exp(-2*(x - 3)^2) + 4*exp(-8*(x - 2)^2)"
    path.write_text(f"model m\ncoord x\nkinetic x'^2/2\n{ridge}\nstart x = 1.6\n")
    found, _ = modes(pkgen, tmp_path, path, "--until", "1")
    assert abs(found["equilibrium"][0]) < 1e-6


def test_about_the_turn_of_an_angle_that_is_next(pkgen, tmp_path: Path) -> None:
    path = written(tmp_path, "model m\ncoord a\nkinetic a'^2/2\npotential -cos(a)\n")
    found, _ = modes(pkgen, tmp_path, path, "--start", "a=9", "--until", "1")
    assert abs(found["equilibrium"][0] - 2 * math.pi) < 1e-12
    first = found["rows"][0]
    assert abs(first[1] - (9 - 2 * math.pi) ** 2 / 2) < 1e-12 and abs(first[2]) < 2
    turning = ["--start", "a=0", "--start", "a'=3", "--until", "10"]
    found, _ = modes(pkgen, tmp_path, path, *turning)
    assert all(abs(row[1] + row[2] - 4.5) < 1e-8 for row in found["rows"])
    assert all(row[1] < math.pi**2 / 2 + 4.5 for row in found["rows"])


def test_energies_without_what_a_total_derivative_adds_to_momenta(tmp_path: Path) -> None:
    path = tmp_path / "gauge.lag"
    path.write_text("""model gauge
coord x, y
lagrangian (x'^2 + y'^2)/2 + 1.5*(x*y' + y*x') - x^2/2 - y^2
start x = 0.1, y' = 0.5
""")
    out = tmp_path / "rows.csv"
    ran("run", path, "--until", "20", "--diagnose", "modes", "-o", out)
    report = json.loads((tmp_path / "rows.csv.json").read_text())["report"]
    for _, together, beyond, slow, fast in report["diagnostics"]["modes"]["rows"]:
        assert together == pytest.approx(0.13, abs=1e-9) and abs(beyond) < 1e-9
        assert (slow, fast) == pytest.approx((0.005, 0.125), abs=1e-9)


def test_of_what_a_scene_reduces_to(pkgen, tmp_path: Path) -> None:
    """A top's nutation about its steady precession; the whole top rests nowhere."""
    top = ROOT / "models" / "heavy_top.lag"
    found, _ = modes(pkgen, tmp_path, top, "--scene", "nutation")
    assert found["frequencies"] == pytest.approx([7.3155695066], abs=1e-9)
    assert found["equilibrium"] == pytest.approx([0.6593415109], abs=1e-9)
