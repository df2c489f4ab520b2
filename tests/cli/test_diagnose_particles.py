"""`--diagnose angular_momentum,lrl` against closed forms."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT, case, diagnosed, table

KEPLER = case("diagnose_particles_kepler")
POLAR = case("diagnose_particles_polar")
TWO = case("two")
SWING = (
    "model swing\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential x^2/2 + y^2\nstart x = 1, y' = 1"
)


def found(folder: Path, text: str, what: str, *arguments: object) -> tuple[dict, str]:
    return diagnosed(folder, text, what, *arguments)[:2]


def test_the_apsides_turn_as_the_step_has_it(tmp_path: Path) -> None:
    # REGIMES K1, e = .6: Verlet -(pi/8) h^2 (4 + e^2)/(1 - e^2)^3 an orbit, to a part in 1000.
    steps = ["--method", "verlet", "--step", str(math.pi / 1000), "--until", str(20.02 * math.pi)]
    of, said = found(tmp_path, KEPLER, "lrl,angular_momentum", *steps)
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


def test_precession_of_another_force(tmp_path: Path) -> None:
    # Of -b/r^2 beside -mu/r: 2 pi (1/sqrt(1 - 2 b/L^2) - 1) from pericentre to pericentre.
    options = ["--set", "b=0.01", "--until", "60", "--method", "gauss8", "--step", "0.01"]
    of, said = found(tmp_path, KEPLER, "lrl", *options)
    turn = 2 * math.pi * (1 / math.sqrt(1 - 0.02 / 0.64) - 1)
    assert of["lrl"]["pericentres"] == 12
    assert abs(of["lrl"]["per_period"] / turn - 1) < 1e-10
    assert of["lrl"]["varies"] > 0.01 and "the model does not conserve its vector" in said
    # Without it there is none.
    of, said = found(tmp_path, KEPLER, "lrl", *options[2:])
    assert abs(of["lrl"]["per_period"]) < 1e-13 and "does not conserve" not in said
    # A circle has no direction.
    round_one = ["--start", "x=1", "--start", "y'=1"]
    of, said = found(tmp_path, KEPLER, "lrl", *options[2:], *round_one)
    assert (
        of["lrl"]["turned"] is None and of["lrl"]["direction"] == [] and "that of a circle" in said
    )


def test_polar_coordinates_and_two_bodies(tmp_path: Path) -> None:
    steps = ["--until", "40", "--method", "gauss8", "--step", "0.01"]
    of, _ = found(tmp_path, POLAR, "lrl,angular_momentum", *steps)
    assert abs(of["lrl"]["eccentricity"] - 0.6) < 1e-14 and abs(of["lrl"]["turned"]) < 1e-12
    assert abs(of["angular_momentum"]["origin"]["first"][2] - 2.4) < 1e-14
    assert of["angular_momentum"]["origin"]["drifts"][0]["max"] < 1e-13
    assert of["lrl"]["pericentres"] == 7 and abs(of["lrl"]["period"] - 2 * math.pi) < 1e-10
    # Two in space: about each other as one of m1 + m2, and L about both places.
    of, said = found(tmp_path, TWO, "lrl,angular_momentum", *steps)
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


def test_what_is_not_conserved_is_said(tmp_path: Path) -> None:
    of, said = found(tmp_path, SWING, "angular_momentum", "--until", "9")
    assert of["angular_momentum"]["origin"]["torque"] > 0.01
    assert "the model does not conserve it (there is a torque): this is how it varies" in said


PENDULUM = case("diagnose_particles_pendulum")
DOUBLE = case("two_bobs")
FOUCAULT = case("foucault")
STARS = """observe X = x*cos(Omega*t) - y*sin(Omega*t)
observe Y = x*sin(Omega*t) + y*cos(Omega*t)
"""
STEPS = ["--until", "4", "--method", "gauss8", "--step", "0.01"]


def rows(tmp_path: Path) -> dict[str, np.ndarray]:
    names, found = table((tmp_path / "rows.csv").read_text())
    return dict(zip(names, np.array(found).T, strict=True))


def check(of: dict, about: str, axis: int, expected: np.ndarray) -> None:
    """One component against what it is by the rows; it alone has a drift."""
    found = of["angular_momentum"][about]
    scale = np.abs(expected).max()
    assert abs(found["first"][axis] - expected[0]) < 1e-14 * scale
    assert abs(found["final"][axis] - expected[-1]) < 1e-12 * scale
    assert all(found["first"][k] == 0 for k in range(3) if k != axis)
    (drift,) = found["drifts"]
    assert drift["name"] == "L_" + "xyz"[axis]
    largest = np.abs(expected - expected[0]).max() / drift["scale"]
    assert 0.9 * largest <= drift["max"] + 1e-13 and drift["max"] <= 1.1 * largest + 1e-13


def test_against_the_rows(tmp_path: Path) -> None:
    # On a circle in the plane of x and z, which is named by outputs: z x' - x z'.
    of, said = found(tmp_path, PENDULUM, "angular_momentum", *STEPS)
    row = rows(tmp_path)
    check(of, "origin", 1, -2 * 9 * row["theta'"])
    assert of["angular_momentum"]["places"] == ["(x, z)"] and "the particles at (x, z)" in said
    # Two whose T is written in angles, of L alone.
    of, _ = found(tmp_path, DOUBLE, "angular_momentum", *STEPS)
    row = rows(tmp_path)
    x1, y1 = 3 * np.sin(row["a"]), -3 * np.cos(row["a"])
    u1, w1 = -y1 * row["a'"], x1 * row["a'"]
    x2, y2 = x1 + 4 * np.sin(row["b"]), y1 - 4 * np.cos(row["b"])
    u2, w2 = u1 + 4 * np.cos(row["b"]) * row["b'"], w1 + 4 * np.sin(row["b"]) * row["b'"]
    whole = x1 * w1 - y1 * u1 + 2 * (x2 * w2 - y2 * u2)
    of_centre = ((x1 + 2 * x2) * (w1 + 2 * w2) - (y1 + 2 * y2) * (u1 + 2 * u2)) / 3
    check(of, "origin", 2, whole)
    check(of, "centre", 2, whole - of_centre)
    assert of["angular_momentum"]["origin"]["torque"] > 0.01


def test_in_a_frame_that_turns(tmp_path: Path) -> None:
    # m r x r' is of the frame in which the places are: it turns, and there it is not conserved.
    of, said = found(tmp_path, FOUCAULT, "angular_momentum", *STEPS)
    row = rows(tmp_path)
    turning = 3 * (row["x"] * row["y'"] - row["y"] * row["x'"])
    check(of, "origin", 2, turning)
    assert of["angular_momentum"]["places"] == ["r"]
    assert "linear in the rates" in of["angular_momentum"]["beyond"]
    assert "as of a turning frame, in which r' is then measured" in said
    assert of["angular_momentum"]["origin"]["torque"] > 0.01
    # Beside the stars, once their places are named, it is: m r x r' + m Omega r^2.
    of, said = found(tmp_path, FOUCAULT + STARS, "angular_momentum", *STEPS)
    row = rows(tmp_path)
    beside = turning + 3 * 0.3 * (row["x"] ** 2 + row["y"] ** 2)
    check(of, "origin", 2, beside)
    assert of["angular_momentum"]["places"] == ["(X, Y)"]
    assert of["angular_momentum"]["beyond"] is None and "turning" not in said
    assert of["angular_momentum"]["origin"]["torque"] < 1e-14
    assert np.ptp(beside) < 1e-12 < 0.1 < np.ptp(turning)


def test_a_start_at_rest_has_the_plane_in_which_it_turns(tmp_path: Path) -> None:
    of, _ = found(tmp_path, case("charged"), "lrl", "--until", "10")
    assert of["lrl"]["direction"] == pytest.approx([-1, 0, 0], abs=1e-15)
    # By SciPy's DOP853 from the same start.
    assert of["lrl"]["turned"] == pytest.approx(6.58004, abs=1e-5)
    assert of["lrl"]["per_period"] == pytest.approx(1.7366297, abs=1e-6)


def test_a_start_at_the_pericentre_counts_once(tmp_path: Path) -> None:
    # r . r' is a rounding below 0 there, and passes 0 right after.
    text = (ROOT / "models/particles/kepler_space.lag").read_text()
    text = text[text.index("model ") :]
    options = ["--set", "mu=1", "--set", "a=1", "--set", "m=1", "--until", "20"]
    of, _ = found(tmp_path, text, "lrl", *options)
    assert of["lrl"]["pericentres"] == 4
    assert abs(of["lrl"]["period"] / (2 * math.pi) - 1) < 1e-9


def test_methods_that_need_derivatives_have_them(tmp_path: Path) -> None:
    # A diagnostic that does not need them leaves them as they are without it.
    method = ["--method", "adaptive_verlet", "--step", "0.001", "--until", "1"]
    of, _ = found(tmp_path, KEPLER, "angular_momentum", *method)
    assert of["angular_momentum"]["origin"]["drifts"][0]["max"] < 1e-13
