"""`--diagnose area`: what a loop of starts encloses in phase space, while that can be told."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

LOOP = """model loop
param g = 1 in (0, inf)
coord theta
kinetic theta'^2/2
potential g*({potential})
scene ring
  swarm k = 1..{members}
  start theta = 1 + 0.5*cos(2*pi*k/{members}), theta' = 0.5*sin(2*pi*k/{members})
  until {until}
  method {method}
  record theta every {every}
end
"""
PENDULUM = "-cos(theta)"


def area(pkgen, tmp_path: Path, text: str, *options: object) -> tuple[dict, str]:
    path = tmp_path / "model.lag"
    path.write_text(text)
    scene = ["--scene", "ring"] if "ring" in text else []
    done = pkgen("run", path, *scene, "--diagnose", "area", "-o", tmp_path / "o.csv", *options)
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "o.csv.json").read_text())["report"]
    return report["diagnostics"]["area"], done.stderr


def ring(potential: str, members: int, until: float, every: float, method: str) -> str:
    return LOOP.format(**locals())


def test_of_a_pendulum(pkgen, tmp_path: Path) -> None:
    text = ring(PENDULUM, 1000, 120, 3, "kahan_li8 step 0.1")
    found, said = area(pkgen, tmp_path, text)
    assert found["members"] == 1000 and found["winding"] == [0] and found["conserved"]
    assert len(found["rows"]) == 41 and found["resolved_until"] == 120
    assert all(abs(row[1] + math.pi / 4) < 1e-14 for row in found["rows"])  # clockwise
    assert all(0 < row[2] < 1e-14 for row in found["rows"]) and found["drift"]["max"] < 1e-13
    assert "area: -0.785398163397 within 1000 members at the start; resolved to the end" in said
    # A method that is not symplectic.
    worse, _ = area(pkgen, tmp_path, text, "--method", "rk4", "--step", "0.1")
    assert 1e-7 < worse["drift"]["max"] < 1e-2


@pytest.mark.long
def test_a_shear_is_resolved_for_a_time(pkgen, tmp_path: Path) -> None:
    # Swings of other amplitudes take other times, so the loop winds up; ten times as many members
    # resolve it some ten times as long. A harmonic oscillator has one frequency, for ever.
    few = ring(PENDULUM, 64, 1000, 10, "kahan_li8 step 0.2")
    found, said = area(pkgen, tmp_path, few)
    until = found["resolved_until"]
    assert 10 <= until < 500 and f"resolved until t = {until:g}" in said
    assert found["drift"]["max"] < 1e-10
    tails = [row[2] for row in found["rows"]]
    assert tails[0] < 1e-14 and tails[-1] > 0.01
    assert (
        abs(found["rows"][-1][1] / found["rows"][0][1] - 1) > 0.01
    )  # what is told there is no area
    more, _ = area(pkgen, tmp_path, few.replace("64", "640"))
    assert 8 * until < more["resolved_until"] < 1000
    found, _ = area(pkgen, tmp_path, few.replace(PENDULUM, "theta^2/2"))
    assert found["resolved_until"] == 1000 and max(row[2] for row in found["rows"]) < 1e-13


@pytest.mark.long
def test_a_loop_round_the_cylinder(pkgen, tmp_path: Path) -> None:
    # theta goes once round: the integral is 2 pi times the mean of theta'.
    text = ring(PENDULUM, 1000, 2, 0.5, "kahan_li8 step 0.05")
    text = text.replace("1 + 0.5*cos(2*pi*k/1000)", "2*pi*k/1000").replace("0.5*sin", "3 + 0.5*sin")
    found, _ = area(pkgen, tmp_path, text)
    assert found["winding"] == [2 * math.pi] and found["resolved_until"] == 2
    assert all(abs(row[1] - 6 * math.pi) < 1e-12 for row in found["rows"])
    open_ends = text.replace("theta = 2*pi*k", "theta = pi*k")
    found, said = area(pkgen, tmp_path, open_ends)
    assert found["resolved_until"] is None and "no smooth closed loop" in said


@pytest.mark.long
def test_two_coordinates_and_an_ensemble(pkgen, tmp_path: Path) -> None:
    # Sum of both areas; the members in a file, in polar coordinates where p is not r' alone.
    text = "model drum\ncoord r, phi\nkinetic (r'^2 + r^2*phi'^2)/2\npotential r^2/2\nstart r = 1\n"
    lines = ["r,phi',phi,r'"]
    for k in range(64):
        c, s = math.cos(2 * math.pi * k / 64), math.sin(2 * math.pi * k / 64)
        lines.append(f"{2 + 0.3 * c!r},{(1 + 0.2 * c) / (2 + 0.3 * c) ** 2!r},{s!r},{0.4 * s!r}")
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n")
    options = ["--ensemble", tmp_path / "m.csv", "--until", "3", "--every", "1"]
    found, _ = area(pkgen, tmp_path, text, *options, "--rtol", "1e-13")
    expected = -math.pi * 0.3 * 0.4 + math.pi * 0.2  # of (r, p_r), of (phi, p_phi)
    assert len(found["rows"]) == 4
    assert all(abs(row[1] - expected) < 1e-11 for row in found["rows"])


def test_refusals(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "model.lag"
    path.write_text(ring(PENDULUM, 31, 1, 1, "verlet step 0.1"))
    done = pkgen("run", path, "--scene", "ring", "--diagnose", "area")
    assert done.returncode == 2 and "a loop has 32 members at least" in done.stderr
    done = pkgen("run", path, "--diagnose", "area")
    assert done.returncode == 2 and "is of a closed loop of starts" in done.stderr
    done = pkgen("run", path, "--scene", "ring", "--diagnose", "area,lyapunov")
    assert done.returncode == 2 and "not for a swarm" in done.stderr and "'area'" in done.stderr
    (tmp_path / "m.csv").write_text("theta,g\n" + "".join(f"0.{k},2\n" for k in range(10, 60)))
    done = pkgen("run", path, "--ensemble", tmp_path / "m.csv", "--diagnose", "area")
    assert done.returncode == 2 and "let starts alone differ" in done.stderr


@pytest.mark.long
def test_of_a_large_swarm(pkgen, tmp_path: Path) -> None:
    # 1e5 members of a wide loop, near the separatrix, where it shears fast: constant to 1e-10 as
    # long as it is resolved, which is for longer than of a thousand.
    text = ring(PENDULUM, 100_000, 400, 10, "kahan_li8 step 0.2")
    text = text.replace("1 + 0.5*cos", "0.2 + 2.4*cos")
    found, _ = area(pkgen, tmp_path, text)
    assert found["resolved_until"] == 400 and found["drift"]["max"] < 1e-10
    few, _ = area(pkgen, tmp_path, text.replace("100000", "1000"))
    assert 10 <= few["resolved_until"] < 100 and few["rows"][-1][2] > 1e-3
