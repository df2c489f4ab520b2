"""Where L or a constraint jumps the rates do: against closed forms, and against the same model with
ramps of width w in place of what bends and jumps, whose error falls with w."""

from __future__ import annotations

import json
import re

import pytest

from conftest import case

PLANE = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2 + 0.3*x'*y'\n"
PIVOT = case("impulses_m2")
CHAIN = case("impulses_m")
DRIVEN = "model m\ncoord a\ninput u\nkinetic (u'^2 + 2*u'*cos(a)*a' + a'^2)/2\npotential -cos(a)\n"
HELD = "scene s\n  {}\n  until 2\n  record {}\nend\n"
# In each BEND(s) is max(0, s), JUMP(s) step(s).
RAMPS = {
    "hold": PIVOT + HELD.format("hold X = BEND(t - 1)", "a, a'"),
    "constraint": PIVOT + "constraint c: X = BEND(t - 1)\n",
    "fixed": CHAIN,
    "input": DRIVEN + HELD.format("set u = BEND(t - 1) + BEND(t - 1.5)", "a, a'"),
    "input that comes back": DRIVEN
    + HELD.format("set u = 2*BEND(sin(2*t + 0.5)) - sin(2*t + 0.5)", "a, a'"),
    "hold in a jumping M": PLANE
    + "kinetic JUMP(t - 1)*(x' + y)^2/2\n"
    + HELD.format("hold y = 2*BEND(t - 1)", "x, x'"),
    "potential": "model m\ncoord x, y\nkinetic (1 + y^2)*x'^2/2 + 0.4*x'*y' + y'^2\n"
    "potential 0.3*JUMP(x + 0.5*y^2 - 1) + 0.1*x*y\nstart x = 0.1, x' = 1.2, y' = 0.3\n",
    "barrier": "model m\ncoord x, y\nkinetic (1 + y^2)*x'^2/2 + 0.4*x'*y' + y'^2\n"
    "potential 3*JUMP(x + 0.5*y^2 - 1) + 0.1*x*y\nstart x = 0.1, x' = 1.2, y' = 0.3\n",
    "moving step": "model m\ncoord x\nkinetic x'^2/2\npotential 0.1*JUMP(x - 0.5*t - 0.3)\n"
    "start x' = 1\n",
    "overtaken": "model m\ncoord x\nkinetic x'^2/2\npotential 0.5*JUMP(0.5*t - x - 0.3)\n"
    "start x' = -0.1\n",
    "mass in q": "model m\ncoord x, y\nkinetic (1 + JUMP(x - 1))*x'^2/2 + (2 + JUMP(x - 1))*y'^2/4"
    " + 0.3*x'*y'\nstart x' = 1, y' = 0.7\n",
    "wire": PLANE + "potential y/2\nconstraint c: y = 0.7*BEND(x - 1)\nstart x' = 2\n",
    "roof": "model m\ncoord x, y, z\nkinetic (x'^2 + y'^2 + z'^2)/2 + 0.2*x'*y'\npotential z/2\n"
    "constraint c: z = 0.7*BEND(x - 1 + 0.3*y) + 0.1*y^2\nstart x' = 2, y' = 0.4\n",
    "wire that moves": PLANE + "potential y^2/2\nconstraint c: x + 0.2*y = BEND(y - 0.5*t)\n"
    "start y = -0.5, y' = 2, x' = -0.4, x = 0.1\n",
    "beside a constraint": "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
    "potential 0.4*JUMP(x - 0.6) + y\nconstraint c: x^2 + y^2 = 1\nstart y = -1, x' = 2\n",
    "rolling in t": PLANE + "potential y^2/2 + x*y\nrolling r: x' = JUMP(t - 1)/2 + 0.2*y*y'\n"
    "start y = 1\n",
    "rolling in q": PLANE + "potential x*y\nrolling r: x' = JUMP(y - 2)/2\nstart y = 1, y' = 1.4\n",
    "beside a rolling": PLANE + "potential x*y + 0.2*JUMP(y - 2)\nrolling r: x' = 0.5*y' - 0.1\n"
    "start y = 1, y' = 2, x' = 0.9\n",
    "rates under a root": "model m\ncoord x\nlagrangian -4*sqrt(1 - x'^2/4) - 3*JUMP(x - 1)\n"
    "start x' = 1.2\n",
    "rotation": "model m\nrotation R\nlet n = R*[0, 0.6, 0.8]\nlet w = omega(R)\n"
    "kinetic (w.x^2 + 2*w.y^2 + 2.5*w.z^2)/2\npotential 0.3*JUMP(n.x - 0.5)\n"
    "start omega(R) = [0.3, 1.1, 0.2]\n",
    "turned by hand": "model m\nrotation R\ncoord b\nlet w = omega(R)\n"
    "kinetic (w.x^2 + 2*w.y^2 + 2.5*w.z^2)/2 + (b' + w.z + 0.5*w.x)^2/2\n"
    "start omega(R) = [0.3, 1.1, 0.2]\n" + HELD.format("hold b = BEND(t - 1)", "R, omega(R)"),
    "a mass that is lost": "model m\ncoord x\nstate z\nkinetic (1 + z)*(x' + JUMP(t - 1)/2)^2/2\n"
    "potential x^2/2\nrate z = -0.2*z\nstart z = 1, x' = 0.4\n",
}


def written_with(text: str, w: float | None) -> str:
    """The model with what bends and jumps, or with ramps of that width."""
    bend, jump = "max(0, {0})", "step({0})"
    if w is not None:
        bend, jump = f"({{0}})*(1 + tanh(({{0}})/{w}))/2", f"(1 + tanh(({{0}})/{w}))/2"
    for word, made in (("BEND", bend), ("JUMP", jump)):
        while word in text:
            first = text.index(word)
            end, depth = first + len(word) + 1, 1
            while depth:
                depth += {"(": 1, ")": -1}.get(text[end], 0)
                end += 1
            inner = text[first + len(word) + 1 : end - 1]
            text = text[:first] + made.format(inner) + text[end:]
    return text


def last(pkgen, path, *more: str) -> list[float]:
    named = re.search(r"^scene (\w+)", path.read_text(), re.MULTILINE)
    scene = ("--scene", named.group(1)) if named else ()
    done = pkgen("run", path, "--until", "2", "--every", "2", "--json", *scene, *more)
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stdout)["rows"][-1][1:]


def off(a: list[float], b: list[float]) -> float:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


QUICK = ("hold", "wire that moves", "potential")


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.long) for n in RAMPS]
)
def test_it_is_the_limit_of_steep_ramps(pkgen, write, name: str) -> None:
    found = last(pkgen, write(written_with(RAMPS[name], None)), "--rtol", "1e-12")
    ramps = []
    for w in (4e-3, 2e-3):
        more = ("--method", "dop853", "--rtol", "1e-11", "--max-step", str(w / 3))
        ramps.append(last(pkgen, write(written_with(RAMPS[name], w)), *more))
    wide, narrow = (off(found, x) for x in ramps)
    limit = [2 * b - a for a, b in zip(*ramps, strict=True)]  # of errors that are as w is
    assert 1e-9 < narrow < 0.6 * wide < 0.1
    assert narrow < 0.3 * wide or off(found, limit) < 0.25 * narrow
    kinks = last(pkgen, write(re.sub(r"(BEND|JUMP)\(", "0*(", RAMPS[name])))
    assert off(found, kinks) > 0.02  # without it the motion is another one
