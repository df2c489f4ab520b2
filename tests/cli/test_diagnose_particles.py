"""`--diagnose angular_momentum,lrl` against closed forms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

KEPLER = """model kepler
param mu = 1 in (0, inf)
param b = 0
coord x, y
let r = sqrt(x^2 + y^2)
kinetic (x'^2 + y'^2)/2
potential -mu/r - b/r^2
start x = 0.4, y' = 2
"""
POLAR = """model polar
param m = 3 in (0, inf)
coord r, phi
kinetic m/2*(r'^2 + r^2*phi'^2)
potential -m/r
start r = 0.4, phi' = 5
"""
TWO = """model two
param m1 = 1 in (0, inf)
param m2 = 3 in (0, inf)
coord x1, y1, z1, x2, y2, z2
let d = sqrt((x2 - x1)^2 + (y2 - y1)^2 + (z2 - z1)^2)
kinetic m1/2*(x1'^2 + y1'^2 + z1'^2) + m2/2*(x2'^2 + y2'^2 + z2'^2)
potential -m1*m2/d
start x1 = -1, x2 = 1, y2' = 0.5, z2' = 1, x1' = 0.1, y1' = 0.2
"""
SWING = (
    "model swing\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential x^2/2 + y^2\nstart x = 1, y' = 1"
)


def found(pkgen, tmp_path: Path, text: str, what: str, *arguments: object) -> tuple[dict, str]:
    path = tmp_path / "model.lag"
    path.write_text(text)
    done = pkgen("run", path, "--diagnose", what, "-o", tmp_path / "rows.csv", *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads((tmp_path / "rows.csv.json").read_text())["report"][
        "diagnostics"
    ], done.stderr


def test_the_apsides_turn_as_the_step_has_it(pkgen, tmp_path: Path) -> None:
    # REGIMES K1, e = .6: Verlet -(pi/8) h^2 (4 + e^2)/(1 - e^2)^3 an orbit, to a part in 1000.
    steps = ["--method", "verlet", "--step", str(math.pi / 1000), "--until", str(20.02 * math.pi)]
    of, said = found(pkgen, tmp_path, KEPLER, "lrl,angular_momentum", *steps)
    lrl, turning = of["lrl"], of["angular_momentum"]
    assert abs(lrl["eccentricity"] - 0.6) < 1e-15 and abs(lrl["k"] - 1) < 1e-15
    assert lrl["direction"] == [1, 0, 0] and lrl["particles"] == 1
    assert lrl["pericentres"] == 11 and abs(lrl["per_period"] / -6.446236e-5 - 1) < 1e-3
    assert abs(lrl["rate"] * 2 * math.pi / -6.446236e-5 - 1) < 0.05
    assert lrl["varies"] < 1e-14 and lrl["drift"]["growth"] == "bounded"
    assert 1e-6 < lrl["drift"]["max"] < 1e-3
    origin = turning["origin"]
    assert turning["particles"] == 1 and turning["centre"] is None
    assert origin["first"] == [0, 0, 0.8] and origin["torque"] < 1e-15
    assert [drift["name"] for drift in origin["drifts"]] == ["L_z"]
    assert origin["drifts"][0]["max"] < 1e-15
    assert "its torque is round-off: this is drift" in said
    assert "lrl: it has turned by -0.0006" in said


@pytest.mark.long
def test_precession_of_another_force(pkgen, tmp_path: Path) -> None:
    # Of -b/r^2 beside -mu/r: 2 pi (1/sqrt(1 - 2 b/L^2) - 1) from pericentre to pericentre.
    options = ["--set", "b=0.01", "--until", "60", "--method", "gauss8", "--step", "0.01"]
    of, said = found(pkgen, tmp_path, KEPLER, "lrl", *options)
    turn = 2 * math.pi * (1 / math.sqrt(1 - 0.02 / 0.64) - 1)
    assert of["lrl"]["pericentres"] == 12
    assert abs(of["lrl"]["per_period"] / turn - 1) < 1e-10
    assert of["lrl"]["varies"] > 0.01 and "the model does not conserve its vector" in said
    # Without it there is none.
    of, said = found(pkgen, tmp_path, KEPLER, "lrl", *options[2:])
    assert abs(of["lrl"]["per_period"]) < 1e-13 and "does not conserve" not in said
    # A circle has no direction.
    round_one = ["--start", "x=1", "--start", "y'=1"]
    of, said = found(pkgen, tmp_path, KEPLER, "lrl", *options[2:], *round_one)
    assert (
        of["lrl"]["turned"] is None and of["lrl"]["direction"] == [] and "that of a circle" in said
    )


@pytest.mark.long
def test_polar_coordinates_and_two_bodies(pkgen, tmp_path: Path) -> None:
    steps = ["--until", "40", "--method", "gauss8", "--step", "0.01"]
    of, _ = found(pkgen, tmp_path, POLAR, "lrl,angular_momentum", *steps)
    assert abs(of["lrl"]["eccentricity"] - 0.6) < 1e-14 and abs(of["lrl"]["turned"]) < 1e-12
    assert abs(of["angular_momentum"]["origin"]["first"][2] - 2.4) < 1e-14
    assert of["angular_momentum"]["origin"]["drifts"][0]["max"] < 1e-13
    assert of["lrl"]["pericentres"] == 7 and abs(of["lrl"]["period"] - 2 * math.pi) < 1e-10
    # Two in space: about each other as one of m1 + m2, and L about both places.
    of, said = found(pkgen, tmp_path, TWO, "lrl,angular_momentum", *steps)
    assert of["lrl"]["particles"] == 2 and abs(of["lrl"]["k"] - 4) < 1e-14
    speed = 0.1**2 + 0.3**2 + 1
    semi = 1 / (2 / 2 - speed / 4)
    assert abs(of["lrl"]["period"] / (2 * math.pi * math.sqrt(semi**3 / 4)) - 1) < 1e-10
    assert abs(of["lrl"]["per_period"]) < 1e-12
    turning = of["angular_momentum"]
    for place in ("origin", "centre"):
        assert [d["name"] for d in turning[place]["drifts"]] == ["L_x", "L_y", "L_z"]
        assert all(d["max"] < 1e-13 for d in turning[place]["drifts"])
        assert turning[place]["torque"] < 1e-14
    # m1 m2/(m1 + m2) r x r', r = (2 0 0), r' = (-.1 .3 1).
    expected = [0, -0.75 * 2 * 1, 0.75 * 2 * 0.3]
    assert all(
        abs(a - b) < 1e-14 for a, b in zip(turning["centre"]["first"], expected, strict=True)
    )
    assert "angular momentum about the centre of mass: " in said


def test_what_is_not_conserved_is_said(pkgen, tmp_path: Path) -> None:
    of, said = found(pkgen, tmp_path, SWING, "angular_momentum", "--until", "9")
    assert of["angular_momentum"]["origin"]["torque"] > 0.01
    assert "the model does not conserve it (there is a torque): this is how it varies" in said


def test_refusals(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "model.lag"
    path.write_text("model line\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\n")
    done = pkgen("run", path, "--diagnose", "angular_momentum")
    assert done.returncode == 2 and f"{path}:3:9: --diagnose angular_momentum is of" in done.stderr
    assert "write kinetic as a sum of m/2*(x'^2 + y'^2)" in done.stderr
    path.write_text(SWING.replace("x^2/2 + y^2", "-x^2"))
    done = pkgen("run", path, "--diagnose", "lrl", "--until", "1")
    assert done.returncode == 2 and "not drawn to the origin" in done.stderr
    three = TWO.replace("x2, y2, z2\n", "x2, y2, z2, x3, y3\n", 1)
    path.write_text(three.replace("potential", "kinetic (x3'^2 + y3'^2)/2\npotential"))
    done = pkgen("run", path, "--diagnose", "lrl", "--until", "1")
    assert done.returncode == 2 and "or of two about each other; 'two' has 3" in done.stderr
