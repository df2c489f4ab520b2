"""x'' and multipliers in outputs, events, records and expectations, beside closed forms and finite
differences of the rates."""

from __future__ import annotations

import pytest

from conftest import table, written


def columns(done) -> dict[str, list[float]]:
    assert done.returncode == 0, done.stderr
    head, rows = table(done.stdout)
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))


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
