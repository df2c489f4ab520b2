"""`--diagnose area`: what a loop of starts encloses in phase space, while that can be told."""

from __future__ import annotations

import json
import math
from pathlib import Path

from conftest import case, written

LOOP = case("diagnose_area_loop")
PENDULUM = "-cos(theta)"


def area(pkgen, tmp_path: Path, text: str, *options: object, code: int = 0) -> tuple[dict, str]:
    path = written(tmp_path, text)
    scene = ["--scene", "ring"] if "ring" in text else []
    done = pkgen("run", path, *scene, "--diagnose", "area", "-o", tmp_path / "o.csv", *options)
    assert done.returncode == code, done.stderr
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


def test_a_loop_round_the_cylinder(pkgen, tmp_path: Path) -> None:
    # theta goes once round: the integral is 2 pi times the mean of theta'.
    text = ring(PENDULUM, 1000, 2, 0.5, "kahan_li8 step 0.05")
    text = text.replace("1 + 0.5*cos(2*pi*k/1000)", "2*pi*k/1000").replace("0.5*sin", "3 + 0.5*sin")
    found, _ = area(pkgen, tmp_path, text)
    assert found["winding"] == [2 * math.pi] and found["resolved_until"] == 2
    assert all(abs(row[1] - 6 * math.pi) < 1e-12 for row in found["rows"])


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


STARTS = "theta = 1 + 0.5*cos(2*pi*k/256), theta' = 0.5*sin(2*pi*k/256)"


def test_noise_of_steps_of_their_own(pkgen, tmp_path: Path) -> None:
    """A plateau of the harmonics at the tolerance is no structure of the loop: the area has its
    digits, and how many is known."""
    text = ring(PENDULUM, 256, 10, 1, "gauss rtol 1e-9").replace(" step 0.1", "")
    for rtol, least, most in (("1e-9", 1e-12, 1e-9), ("1e-6", 1e-9, 1e-6)):
        found, said = area(pkgen, tmp_path, text, "--rtol", rtol)
        assert found["resolved_until"] == 10 and found["ends"] is None
        tails = [row[2] for row in found["rows"]]
        assert tails[0] < 1e-15 and least < max(tails) < most
        errors = [abs(row[1] + math.pi / 4) for row in found["rows"]]
        noise = max(row[3] for row in found["rows"])
        assert noise / 10 < max(errors) < 3 * noise  # which tells the error, not only bounds it
        beside = noise / found["drift"]["scale"]
        assert f"errors of each member's own may be {beside:.0e} of that" in said
    # Too fine is too fine, whatever the steps, and that shows about as soon as it leaves the noise.
    fine = ring(PENDULUM, 64, 60, 2, "kahan_li8 step 0.1")
    until = area(pkgen, tmp_path, fine)[0]["resolved_until"]
    found, said = area(pkgen, tmp_path, fine, "--method", "gauss", "--rtol", "1e-9")
    assert 8 < until < 30 and until - 4 <= found["resolved_until"] <= until + 8
    assert "it is finer than its members are apart" in found["ends"]
    # A method whose steps leave more noise than can be told from a torn loop.
    found, said = area(pkgen, tmp_path, text, "--method", "adaptive_verlet", "--step", "0.1")
    assert found["resolved_until"] < 5 and "take a fixed step, of a symplectic method" in said


def test_loops_that_enclose_nothing(pkgen, tmp_path: Path) -> None:
    # An eight, and there and back again at rest: 0, and so exact beside their size.
    text = ring(PENDULUM, 256, 10, 1, "kahan_li8 step 0.1")
    for starts in (
        "theta = 0.5*sin(2*pi*k/256), theta' = 0.5*sin(4*pi*k/256)",
        "theta = 0.5*sin(2*pi*k/256)",
    ):
        found, said = area(pkgen, tmp_path, text.replace(STARTS, starts))
        assert found["resolved_until"] == 10 and all(abs(r[1]) < 1e-15 for r in found["rows"])
        assert found["drift"]["max"] < 1e-15 and 0.1 < found["drift"]["scale"] < 2
        assert "round-off" in said and "starts at 0" not in said
        worse, _ = area(pkgen, tmp_path, text.replace(STARTS, starts), "--method", "euler")
        assert worse["drift"]["max"] < 1e-2  # they enclose nothing by their symmetry
    lopsided = "theta = 0.3 + 0.5*sin(2*pi*k/256), theta' = 0.5*sin(4*pi*k/256)"
    worse, said = area(pkgen, tmp_path, text.replace(STARTS, lopsided), "--method", "euler")
    assert abs(worse["rows"][0][1]) < 1e-15 and 1e-4 < worse["drift"]["max"] < 0.5


EVENTS = """
event low: theta + 0.9 falling{stop}
event top: theta' falling
"""


def test_members_that_part(pkgen, tmp_path: Path) -> None:
    """By an event that stops some, by a failure: what is told is up to the last row of all."""
    text = ring(PENDULUM, 256, 10, 0.05, "gauss8 step 0.05")
    text = text.replace("scene ring", EVENTS + "scene ring").replace(
        "end\n", "  expect time(top) > 0\nend\n"
    )
    whole, said = area(pkgen, tmp_path, text.format(stop=""))
    assert whole["resolved_until"] == 10 and len(whole["rows"]) == 201
    assert whole["drift"]["max"] < 1e-13
    found, said = area(pkgen, tmp_path, text.format(stop=" stop"), code=4)
    rows = found["rows"]
    assert 2 < len(rows) < 80 and rows == whole["rows"][: len(rows)]
    assert found["resolved_until"] == rows[-1][0] and " of 256 members, first k = " in said
    assert "for an event stopped them: the last row that all have is at t = " in said
    assert f"until t = {rows[-1][0]:.6g}, as far as all members come" in said
    falling = text.replace(EVENTS, "").replace("  expect time(top) > 0\n", "")
    falling = falling.replace("g*(-cos(theta))", "-1/theta")
    found, said = area(pkgen, tmp_path, falling, code=4)
    assert "for they failed: the last row that all have is at t = " in said
    assert len(found["rows"]) > 3 and found["drift"]["max"] < 1e-10


def test_states_have_no_part_in_it(pkgen, tmp_path: Path) -> None:
    text = ring("theta^2/2", 64, 10, 1, "gauss8 step 0.1")
    text = text.replace("coord theta", "coord theta\nstate S").replace("scene", "rate S = L\nscene")
    found, said = area(pkgen, tmp_path, text)
    assert found["winding"] == [0] and all(abs(r[1] + math.pi / 4) < 1e-14 for r in found["rows"])
    said_of_states = "with states, or forces besides those of L, it need not be conserved"
    assert found["conserved"] and said_of_states not in said  # nothing reads S
    read = text.replace("rate S = L", "rate S = L\nforce theta = -0.01*S")
    found, said = area(pkgen, tmp_path, read)
    assert not found["conserved"] and said_of_states in said


def test_a_loop_with_kinks(pkgen, tmp_path: Path) -> None:
    found, said = area(pkgen, tmp_path, ring("abs(theta)", 256, 4, 1, "gauss8 step 0.01"))
    assert found["resolved_until"] == 0 and "it has kinks, where the equations have" in said
    assert found["drift"] is None and "drift" not in said  # of one row there is none
    # A kink so small that its harmonics could be noise.
    slight = ring("theta^2/2 + 1e-6*abs(theta)", 256, 4, 1, "gauss8 step 0.1")
    slightly, said = area(pkgen, tmp_path, slight)
    assert slightly["resolved_until"] == 1 and "it has kinks" in said  # then the first come to 0
    assert 1e-12 < slightly["rows"][2][2] < 1e-7
    assert abs(found["rows"][-1][1] + math.pi / 4) < 0.01  # and the area is there, but for them


def test_of_a_large_swarm(pkgen, tmp_path: Path) -> None:
    # 1e5 members of a wide loop, near the separatrix, where it shears fast: constant to 1e-10 as
    # long as it is resolved, which is for longer than of a thousand.
    text = ring(PENDULUM, 100_000, 400, 10, "kahan_li8 step 0.2")
    text = text.replace("1 + 0.5*cos", "0.2 + 2.4*cos")
    found, _ = area(pkgen, tmp_path, text)
    assert found["resolved_until"] == 400 and found["drift"]["max"] < 1e-10
    few, _ = area(pkgen, tmp_path, text.replace("100000", "1000"))
    assert 10 <= few["resolved_until"] < 100 and few["rows"][-1][2] > 1e-3
