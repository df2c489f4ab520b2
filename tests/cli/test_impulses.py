"""Where L or a constraint jumps the rates do: against closed forms, and against the same model with
ramps of width w in place of what bends and jumps, whose error falls with w."""

from __future__ import annotations

import json
import math
import re

import mpmath
import pytest

from conftest import case, ran

PLANE = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2 + 0.3*x'*y'\n"
STEP = "model m\ncoord x\nkinetic x'^2/2\npotential {}*step(x - 1)\nstart x' = 1\n"
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


@pytest.mark.parametrize(
    "method", ["rk4", "dop853", "gauss", "gauss4", "rattle", "radau", "verlet"]
)
def test_a_step_of_a_potential(pkgen, write, method: str) -> None:
    """v'^2 = v^2 - 2 V/m behind it, or it turns back."""
    more = ["--method", method]
    adaptive = method in ("dop853", "gauss", "radau")
    more += ["--rtol", "1e-12"] if adaptive else ["--step", "0.03"]
    after = math.sqrt(0.4)
    x, v, energy = last(pkgen, write(STEP.format(0.3)), *more)
    assert (x, v, energy) == pytest.approx((1 + after, after, 0.5), rel=3e-14)
    x, v, energy = last(pkgen, write(STEP.format(0.7)), *more)
    assert (x, v, energy) == pytest.approx((0, -1, 0.5), abs=3e-14)


@pytest.mark.parametrize("name", ["hold", "roof", "wire that moves", "rotation"])
def test_methods_agree(pkgen, write, name: str) -> None:
    path = write(written_with(RAMPS[name], None))
    found = last(pkgen, path, "--rtol", "1e-12")
    for method in ("rk4", "gauss4", "rattle6", "lie_midpoint6", "dop853", "radau"):
        adaptive = method in ("dop853", "radau")
        more = ("--rtol", "1e-11") if adaptive else ("--step", "0.005")
        assert off(last(pkgen, path, "--method", method, *more), found) < 3e-8, method


def test_a_pivot_that_starts_with_a_jerk(pkgen, write) -> None:
    """A pendulum at rest gets a' = -1 of its pivot: from then on sin(a/2) = -sn(t - 1 | 1/4)/2."""
    text = DRIVEN.replace("input u", "coord u").replace("kinetic (", "kinetic (u'^2 + ")
    exact = -2 * math.asin(float(mpmath.ellipfun("sn", 2, m=0.25)) / 2)  # -1.00461
    for way in ("constraint c: u = max(0, t - 1)\n", HELD.format("hold u = max(0, t - 1)", "a")):
        path = write(text + way)
        scene = ("--scene", "s") if "scene" in way else ()
        done = pkgen("run", path, "--until", "3", "--every", "3", "--json", *scene, "--record", "a")
        assert json.loads(done.stdout)["rows"][-1][1] == pytest.approx(exact, abs=1e-9)
        done = pkgen("explain", path, *scene)
        assert "impulses         where t - 1 vanishes: the rates may jump there" in done.stdout


def test_what_an_impulse_leaves_is_still_proved(write) -> None:
    """The momentum that it is not along, and the energy where nothing moves by itself."""
    for text in (
        "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nconstraint r: x = max(0, t - 1)\n"
        "conserve A = y'\n",
        PLANE + "constraint r: x = abs(y)\nconserve A = energy\n",
    ):
        ran("check", write(text))


STOPPED = {
    "rolling r: x' = 5*step(y - 1)\nstart y' = 1": "turns the motion back",
    "potential step(x - 1) + step(x*y - 1)\nstart x' = 2, y' = 1.1, y = 0.45": "at once",
    "potential 0.2*step(y - 1)\nrolling r: x' = 0.2*step(y - 1)\nstart y' = 1": "both jump",
    "constraint r: x = exp(step(y^3 + y - 2)) - 1\nstart y' = 1": "r jumps",
    "rolling r: x' = y'*sqrt(2*step(y - 1) + 1)\nstart y' = 1, x' = 1": "the rates in r jumps",
}


@pytest.mark.parametrize("text", STOPPED)
def test_what_is_not_determined_ends_the_run(pkgen, write, text: str) -> None:
    done = pkgen("run", write(f"{PLANE}{text}\n"), "--until", "3", "--json")
    assert done.returncode == 4, done.stdout
    report = json.loads(done.stdout)["report"]
    assert report["status"] == "PK_NO_IMPULSE" and 0.4 < report["t"] < 1.5
    assert STOPPED[text] in done.stderr and "last valid time" in done.stderr


def test_what_does_not_locate_switches_says_so(pkgen, write, tmp_path) -> None:
    path = write(STEP.format(0.3))
    done = pkgen("stability", path, "-o", tmp_path, "--quick")
    assert done.returncode == 2 and "the rates jump where x - 1 vanishes" in done.stderr
    done = pkgen("run", path, "--until", "2", "--diagnose", "reversal,lyapunov", "--json")
    said = json.loads(done.stdout)["report"]["diagnostics"]
    assert all(said[name].get("status") != "PK_DONE" for name in ("reversal", "lyapunov"))


def test_two_at_once_that_do_not_meet_commute(pkgen, write) -> None:
    text = PLANE.replace(" + 0.3*x'*y'", "") + "potential 0.3*step(x - 1) + 0.2*step(y - 1)\n"
    found = last(pkgen, write(text + "start x' = 1, y' = 1\n"), "--method", "rk4", "--step", "0.07")
    after = math.sqrt(0.4), math.sqrt(0.6)
    assert found[2:4] == pytest.approx(after, rel=1e-14)


def test_a_bound_ball_bounces_for_ever(pkgen, write) -> None:
    """In a box of walls that are steps: twenty turns, and the energy to rounding."""
    text = STEP.format(5).replace("step(x - 1)", "(step(x - 1) + step(-1 - x))")
    done = pkgen("run", write(text), "--until", "40", "--every", "40", "--json", "--method", "rk4",
                 "--step", "0.1")  # fmt: skip
    found = json.loads(done.stdout)
    assert found["rows"][-1][1:] == pytest.approx([0, 1, 0.5], abs=1e-12)
    assert sum(s["count"] for s in found["report"]["switches"]) == 20


@pytest.mark.parametrize("method", ["verlet", "rk4", "gauss"])
def test_a_row_at_the_switch_changes_nothing(pkgen, write, method: str) -> None:
    """A step ends on the zero itself, and the grid of steps begins anew there."""
    more = ["--method", method] + (["--step", "0.25"] if method != "gauss" else [])
    for height, last_row in ((0.3, [1 + math.sqrt(0.4), math.sqrt(0.4)]), (0.7, [0, -1])):
        path = write(STEP.format(height))
        done = pkgen("run", path, "--until", "2", "--every", "0.5", "--json", *more)
        rows = json.loads(done.stdout)["rows"]
        assert rows[2][:2] == pytest.approx([1, 1]) and rows[-1][1:3] == pytest.approx(
            last_row, abs=1e-14
        )
