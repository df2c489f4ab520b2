"""x'' and multipliers in outputs, events, records and expectations, beside closed forms and finite
differences of the rates."""

from __future__ import annotations

import json
import math

import pytest

from conftest import case, table, written

PENDULUM = case("pendulum")


def columns(done) -> dict[str, list[float]]:
    assert done.returncode == 0, done.stderr
    head, rows = table(done.stdout)
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))


def test_a_pendulum_accelerates_as_it_is_known_to(pkgen, tmp_path):
    path = written(tmp_path, PENDULUM)
    done = pkgen("run", path, "--scene", "swings")
    assert done.returncode == 4 and "expected: 2 of 3 met" in done.stderr  # theta'' is not < 8
    head, rows = table(done.stdout)
    assert ",".join(head) == "t,theta,theta',theta'',x'',r.x'',r.y'',r.z'',acc"
    for _, q, v, a, ax, bx, by, bz, acc in rows:
        known = -9.81 / 0.7 * math.sin(q)
        assert a == pytest.approx(known, abs=1e-12) and acc == a and bz == 0
        assert (
            ax == bx == pytest.approx(0.7 * (known * math.cos(q) - v * v * math.sin(q)), abs=1e-12)
        )
        assert by == pytest.approx(0.7 * (known * math.sin(q) + v * v * math.cos(q)), abs=1e-12)
    assert max(abs(row[3]) for row in rows) > 5


def test_an_acceleration_crosses_zero_and_is_a_column_with_a_unit(pkgen, tmp_path):
    path = written(tmp_path, PENDULUM)
    done = pkgen("run", path, "--until", "5", "--rtol", "1e-12", "--json")
    found = json.loads(done.stdout)
    units = {c["name"]: c["unit"] for c in found["columns"]}
    assert units["acc"] == "1/s^2" and units["down"] == units["place.x"] == "m/s^2"
    times = {e["name"]: e["times"] for e in found["report"]["events"]}
    assert len(times["turns"]) >= 2  # every other time at which it is lowest
    assert times["turns"] == pytest.approx(times["lowest"][::2], abs=1e-10)


def test_members_have_accelerations_too(pkgen, tmp_path):
    done = pkgen("run", written(tmp_path, PENDULUM), "--scene", "many")
    found = columns(done)
    for q, a in zip(found["theta"], found["theta''"], strict=True):
        assert a == pytest.approx(-9.81 / 0.7 * math.sin(q), abs=1e-12)
    assert len(set(found["y''"])) == 20


ROD = case("accelerations_rod")


def test_the_tension_of_a_rod_is_an_output_an_event_and_expected(pkgen, tmp_path):
    done = pkgen("run", written(tmp_path, ROD), "--scene", "thrown")
    found = columns(done)
    assert "expected: 3 of 3 met" in done.stderr and "event slack: once" in done.stderr
    rows = zip(*(found[k] for k in ("x", "y", "x'", "y'", "tension", "lambda_rod")), strict=True)
    for x, y, vx, vy, tension, multiplier in rows:
        known = 0.8 * ((vx * vx + vy * vy) / 1.5 - 9.81 * y / math.hypot(x, y))
        assert tension == pytest.approx(known, abs=1e-9) and multiplier == -tension
    assert found["tension"][0] > 30 and abs(found["tension"][-1]) < 1e-9


# Inputs, drag, time, a state in a momentum, constraints, a switch, turns; a few rows of each.
MIXED = {
    "driven": """\
coord a, b
state s
input u
kinetic (2 + cos(a - b))*(a'^2/2 + 0.4*a'*b') + b'^2*(1 + 0.1*s) + 0.2*u'*b'
potential sin(a)*b^2 + a^2
dissipation 0.1*a'^2
force b = u*t
rate s = a*b' - s
start a = 0.4, b = -0.3, b' = 0.2
""",
    "bound": """\
coord a, b, c
kinetic (a'^2 + b'^2 + (1.5 + sin(a))*c'^2)/2
potential c + a*b
constraint tie: c = a*b + 0.1*sin(t)
rolling slide: b' = 0.3*c*a' + 0.1
start a = 0.4, b = 0.5, c = 0.2, a' = -0.1, b' = 0.094, c' = 0.0876
""",
    "kinked": """\
coord a, b
kinetic (a'^2 + b'^2)/2 + 0.2*a'*b'
potential a^2/2 + abs(a - 0.2)*b
force b = step(t - 0.5)
start a = 0.5, b = 0.1
""",
}
BODY = """\
rotation R
coord z
let w = omega(R)
kinetic w.x^2/2 + w.y^2 + 1.5*w.z^2 + z'^2/2 + 0.1*z'*w.z
potential z^2*(R*[0, 0, 1]).x
force R = [0.1*t, 0, -0.1*w.z]
start z = 0.3, omega(R) = [0.3, 1, 0.2]
"""


@pytest.mark.parametrize("name", [*MIXED, "body"])
def test_accelerations_are_the_slopes_of_rates(pkgen, tmp_path, name):
    text = MIXED.get(name, BODY)
    names = ["omega(R).x", "omega(R).y", "omega(R).z", "z'"] if name == "body" else ["a'", "b'"]
    names += ["c'"] if name == "bound" else ["s'", "s"] if name == "driven" else []
    lines = "".join(f"observe n{k} = ({n})'\n" for k, n in enumerate(names) if "(" not in n)
    if name == "body":
        lines += "observe turning = omega(R)'\n"
    recorded = ", ".join(
        [*names, "turning" if name == "body" else "n0", "n1" if name != "body" else "n3"]
    )
    recorded += ", n2" if "n2" in lines else ""
    recorded += ", n3" if "n3" in lines and name != "body" else ""
    given = "  set u = sin(2*t)\n" if name == "driven" else ""
    scene = f"scene s\n{given}  until 0.9\n  method gauss rtol 1e-14\n"
    scene += f"  record {recorded} every 0.005\nend\n"
    found = columns(
        pkgen("run", written(tmp_path, f"model {name}\n{text}{lines}{scene}"), "--scene", "s")
    )
    h, t = 0.005, found["t"]
    slopes = {n: f"turning.{n[-1]}" if "(" in n else f"n{k}" for k, n in enumerate(names)}
    compared = 0
    for rate, slope in slopes.items():
        v, a = found[rate], found[slope]
        largest = max(map(abs, a))
        for k in range(2, len(t) - 2):
            known = (v[k - 2] - v[k + 2] + 8 * (v[k + 1] - v[k - 1])) / (12 * h)
            bends = name == "kinked" and (abs(t[k] - 0.5) < 0.011 or "kinks" in rate)
            if not bends and not (name == "kinked" and _turns(found, k)):
                assert a[k] == pytest.approx(known, abs=3e-8 * (1 + largest)), (rate, t[k])
                compared += 1
        assert largest > 0.01
    assert compared > 100 * len(slopes)


def _turns(found: dict, k: int) -> bool:
    """Near where a - 0.2 changes its sign, by the jump of b's acceleration."""
    a = found["n1"]
    return any(abs(a[i + 1] - a[i]) > 0.05 for i in range(k - 3, k + 3) if 0 <= i < len(a) - 1)


def test_what_a_scene_leaves_of_a_model_has_the_same_accelerations(pkgen, tmp_path):
    top = case("top")
    path = written(tmp_path, top)
    some, all_ = (
        columns(pkgen("run", path, "--scene", "nods", *o)) for o in ((), ("--no-reduce",))
    )
    for name in ("theta''", "phi''"):
        assert some[name] == pytest.approx(all_[name], abs=1e-7)
        assert max(map(abs, some[name])) > 1


CHAIN = case("chain")


def test_members_of_families_accelerate(pkgen, tmp_path):
    found = columns(pkgen("run", written(tmp_path, CHAIN), "--scene", "s"))
    for t, a in zip(found["t"], found["q[31]''"], strict=True):
        assert a == pytest.approx(-0.1 * math.sin(t), abs=1e-15)
    assert abs(found["q[3]''"][0]) > 1e-3 and abs(found["all"][2]) > 1e-3
