"""x'' and multipliers in outputs, events, records and expectations, beside closed forms and finite
differences of the rates."""

from __future__ import annotations

import json
import math

import pytest

from conftest import table, written

PENDULUM = """\
model pendulum
param m = 1.3 [kg] in (0, inf)
param l = 0.7 [m] in (0, inf)
param g = 9.81 [m/s^2]
coord theta [rad]
let x = l*sin(theta)
let y = -l*cos(theta)
let r = [x, y, 0]
kinetic m/2*(x'^2 + y'^2)
potential m*g*y
observe acc = theta''
observe down = -(l*cos(theta))''
observe place = r''
event turns: theta'' rising
event lowest: theta either
start theta = 1, theta' = 0.3
scene swings
  until  2
  method gauss rtol 1e-13
  record theta, theta', theta'', x'', r'', acc every 0.1
  expect theta'' = -g/l*sin(theta) within 1e-11
  expect theta'' < 8 [1/s^2]
  expect r''.y < 0 at 0
end
scene many
  swarm  k = 1..20
  start  theta = k/10
  until  2
  method rk4 step 0.001
  record theta, theta'', y''
end
"""


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


ROD = """\
model rod
param m = 0.8 [kg] in (0, inf)
param l = 1.5 [m] in (0, inf)
param g = 9.81 [m/s^2]
param v0 = 7 [m/s]
coord x, y [m]
kinetic m/2*(x'^2 + y'^2)
potential m*g*y
constraint rod: (x^2 + y^2 - l^2)/(2*l) = 0
observe tension = -lambda_rod
event slack: lambda_rod rising stop
start y = -l, x' = v0
scene thrown
  until  3
  method gauss rtol 1e-12
  record x, y, x', y', x'', y'', lambda_rod, tension every 0.05 at slack
  expect lambda_rod < 1e-9 [N]
  expect y = -l*(2 - v0^2/(g*l))/3 within 1e-9 at slack
  expect m*(x''*x + y''*y) = l*lambda_rod - m*g*y within 1e-10
end
"""


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
    top = """\
model top
coord phi, theta, psi
kinetic (theta'^2 + phi'^2*sin(theta)^2)/2 + (psi' + phi'*cos(theta))^2/4
potential 9.81*cos(theta)
start theta = 0.6, phi' = 0.4, psi' = 18
scene nods
  until 1
  record theta'', phi'' every 0.1
end
"""
    path = written(tmp_path, top)
    some, all_ = (
        columns(pkgen("run", path, "--scene", "nods", *o)) for o in ((), ("--no-reduce",))
    )
    for name in ("theta''", "phi''"):
        assert some[name] == pytest.approx(all_[name], abs=1e-7)
        assert max(map(abs, some[name])) > 1


CHAIN = """\
model chain
size N = 30
coord q[1..N]
fixed q[0] = 0, q[N+1] = 0.1*sin(t)
kinetic   sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2, i = 0..N)
observe all = sum(q[i]'', i = 1..N)
start q[i = 1..N] = sin(pi*i/(N+1))
scene s
  until 3
  record q[3], q[2], q[4], q[3]'', q[31]'', all every 1
  expect q[3]'' = q[2] - 2*q[3] + q[4] within 1e-13
end
"""


def test_members_of_families_accelerate(pkgen, tmp_path):
    found = columns(pkgen("run", written(tmp_path, CHAIN), "--scene", "s"))
    for t, a in zip(found["t"], found["q[31]''"], strict=True):
        assert a == pytest.approx(-0.1 * math.sin(t), abs=1e-15)
    assert abs(found["q[3]''"][0]) > 1e-3 and abs(found["all"][2]) > 1e-3
