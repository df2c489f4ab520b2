"""Forces, barriers and ramps of a width that is a small part of a step: seen by adaptive steps,
warned of by fixed ones. Against closed forms, quadratures of mpmath, extrapolated midpoint steps
of a quarter of the width, and the same model by steps that resolve it."""

from __future__ import annotations

import json
import math
import random

import pytest
from mpmath import exp, log, mpf, quad, sqrt

from conftest import ran, seeds

WIDTHS = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
T0, X0 = 5.3, 3.3
PENDULUM = (
    "param w = 0.01\ncoord a, X\nkinetic ((X' + cos(a)*a')^2 + (sin(a)*a')^2)/2 + X'^2/2\n"
    "potential -9.81*cos(a)\nstart a = 0.5\n"
)
BARRIER = (
    "param w = 1\nparam v = 2\ncoord x\nkinetic x'^2/2\npotential 0.8*exp(-((x - 3.3)/w)^2)\n"
    "start x' = {}\nscene s\n  until 10\n  record x, x', energy\nend\n"
)
MODELS = {
    "pulse": "model pulse\nparam w = 1\ncoord x\nkinetic x'^2/2\n"
    "force x = exp(-((t - 5.3)/w)^2)/w/sqrt(pi)\nscene s\n  until 10\n  record x, x'\nend\n",
    "barrier": "model barrier\n" + BARRIER.format("2"),
    "wall": "model wall\n" + BARRIER.format("1"),
    "held": f"model held\n{PENDULUM}scene s\n  hold X = tanh((t - 5.2)/w)/2\n  until 5.5\n"
    "  record a, a'\nend\n",
    "bound": f"model bound\n{PENDULUM}start X = -0.5\nconstraint c: X = tanh((t - 5.2)/w)/2\n"
    "scene s\n  until 5.5\n  record a, a'\nend\n",
}


def barrier(w: float, v: float) -> tuple[float, float, float]:
    """x, x' and the energy at 10, by the time that a unit of x/w takes there."""
    if v * v / 2 > 0.8:
        late = w * quad(lambda s: 1 / sqrt(v * v - mpf(8) / 5 * exp(-s * s)) - 1 / v, [-9, 0, 9])
        return float(v * (10 - late)), v, v * v / 2
    turn = sqrt(log(mpf(8) / 5))  # s = turn + k^2 takes the root away
    slow = quad(
        lambda k: 2 * k / sqrt(abs(1 - mpf(8) / 5 * exp(-((turn + k * k) ** 2)))),
        [0, 1, sqrt(9 - turn)],
    )
    return float(X0 - 9 * w - (10 - (X0 - 9 * w) - 2 * w * slow)), -1.0, 0.5


def ramp(w: float) -> tuple[float, float]:
    """The pendulum's angle and rate at 5.5, by the method of Gragg, Bulirsch and Stoer."""

    def slope(t: float, a: float, b: float) -> tuple[float, float]:
        s = math.tanh((t - 5.2) / w)
        return b, math.cos(a) * s * (1 - s * s) / w**2 - 9.81 * math.sin(a)

    def step(t: float, h: float, y: tuple[float, float]) -> tuple[float, float]:
        rows: list[list[tuple[float, float]]] = []
        for k, m in enumerate((2, 4, 6, 8, 10, 12)):
            d, f = h / m, slope(t, *y)
            z, x = y, (y[0] + h / m * f[0], y[1] + h / m * f[1])
            for j in range(1, m):
                f = slope(t + j * d, *x)
                z, x = x, (z[0] + 2 * d * f[0], z[1] + 2 * d * f[1])
            f = slope(t + h, *x)
            row = [((z[0] + x[0] + d * f[0]) / 2, (z[1] + x[1] + d * f[1]) / 2)]
            for i in range(k):
                r = (m / (2 * (k - i))) ** 2 - 1
                row.append(
                    tuple(p + (p - q) / r for p, q in zip(row[-1], rows[-1][i], strict=True))
                )
            rows.append(row)
        return rows[-1][-1]

    y, t = (0.5, 0.0), 0.0
    for end, length in ((5.2 - 20 * w, 0.05), (min(5.2 + 20 * w, 5.5), w / 4), (5.5, 0.05)):
        count = math.ceil((end - t) / min(length, 0.3 / (1 + abs(y[1])) if t > 5.2 else 1))
        for k in range(count):
            y = step(t + (end - t) * k / count, (end - t) / count, y)
        t = end
    return y


def of_width(name: str, w: float) -> tuple[float, ...]:
    if name in ("held", "bound"):
        return ramp(w)
    return (10 - T0, 1.0) if name == "pulse" else barrier(w, 2.0 if name == "barrier" else 1.0)


ADAPTIVE = ["gauss", "dop853", "radau", "gsl_rk8pd"]


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("name", MODELS)
def test_adaptive_steps_see_it(pkgen, write, tmp_path, name: str, method: str, request) -> None:
    ramps = name in ("held", "bound")
    if ramps and method != "gauss" and not request.config.option.markexpr.startswith("long"):
        widths = [1e-3]
    else:
        widths = [w for w in WIDTHS if w >= (1e-3 if method == "radau" else 1e-4) or not ramps]
    sets = tmp_path / "widths.csv"
    sets.write_text("w\n" + "".join(f"{w}\n" for w in widths))
    done = pkgen("run", write(MODELS[name]), "--scene", "s", "--method", method, "--json",
                 "--ensemble", sets)  # fmt: skip
    assert done.returncode == 0 and "warning" not in done.stderr, done.stderr
    found = [row[2:] for row in json.loads(done.stdout)["rows"]]
    for w, row in zip(widths, found, strict=True):
        assert row == pytest.approx(of_width(name, w), rel=1e-6), w


@pytest.mark.parametrize("method", ["rk4", "verlet", "gauss4"])
@pytest.mark.parametrize("name", ["pulse", "barrier", "held"])
def test_fixed_steps_warn(pkgen, write, name: str, method: str) -> None:
    if (name, method) == ("held", "verlet"):
        pytest.skip("not separable")
    path = write(MODELS[name])
    short = ("run", path, "--scene", "s", "--method", method, "--json", "--set", "w=1e-3")
    done = pkgen(*short, "--step", "0.03")
    what = "tanh" if name == "held" else "exp"
    assert f"run: warning: {what}(" in done.stderr, done.stderr
    (passed,) = json.loads(done.stdout)["report"]["passed_over"]
    where = 1.65 if name == "barrier" else T0 if name == "pulse" else 5.2
    assert passed["t"] == pytest.approx(where, abs=0.04) and passed["name"].startswith(what)
    done = pkgen(*short, "--step", "0.0001")
    assert "too long" not in done.stderr and not json.loads(done.stdout)["report"]["passed_over"]
    assert done.returncode == 0


QUOTIENTS = ("(1+s^2)", "(1+s^2)^3", "(1+s^2)^6", "(1+s^4)", "(1+s^8)", "sqrt(1+s^8)")


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("quotient", QUOTIENTS)
def test_walls_that_fade_by_powers(write, tmp_path, quotient: str, method: str) -> None:
    """A bead of energy .5 turns back at .8/(...), where it would pass unless a step ends there."""
    wall = quotient.replace("s", "((x - 3.3)/w)").replace("((x - 3.3)/w)qrt", "sqrt")
    text = f"model wall\nparam w = 1\ncoord x\nkinetic x'^2/2\npotential 0.8/{wall}\nstart x' = 1\n"
    sets = tmp_path / "widths.csv"
    sets.write_text("w\n" + "".join(f"{w}\n" for w in WIDTHS))
    done = ran(
        "run",
        write(text + "scene s\n  until 10\n  record x'\nend\n"),
        "--scene",
        "s",
        "--method",
        method,
        "--json",
        "--ensemble",
        sets,
    )
    for w, row in zip(WIDTHS, json.loads(done.stdout)["rows"], strict=True):
        assert row[2] == pytest.approx(-1, rel=1e-6 if w < 0.01 else 1e-3), w


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("power", [100, 1000])
def test_peaks_of_high_powers(pkgen, write, power: int, method: str) -> None:
    """cos(s/2)^n over one period, by its closed form."""
    logs = math.lgamma((power + 1) / 2) - math.lgamma(power / 2 + 1)
    area = 2 * math.sqrt(math.pi) * math.exp(logs)
    path = write(
        "model m\nparam a = 1\ncoord x\nkinetic x'^2/2\n"
        f"force x = cos((t - 5.2)/2)^{power}/a\nstart x = 0\n"
    )
    done = pkgen("run", path, f"--set=a={area!r}", "--record=x'", "--every=10", "--method", method)
    assert abs(float(done.stdout.split(",")[-1]) - 1) < 2e-7, done.stderr


def test_a_way_back_as_long_as_a_step_ends_it(pkgen, write) -> None:
    """X goes from 0 to 1 at t = 3.14 in .01, by nothing that is followed; the rows see it."""
    text = MODELS["bound"].split("constraint")[0].replace("start X = -0.5\n", "")
    text += "let S = (2*sin(t/4)^2)^300\nlet C = (2*cos(t/4)^2)^300\nconstraint c: X = S/(S + C)\n"
    run = ("run", write(text), "--until", "4", "--every", "4", "--json", "--method")
    ends = []
    for method in (("gauss",), ("gauss", "--max-step", "0.001"), ("dop853",)):
        ends.append(json.loads(pkgen(*run, *method).stdout)["rows"][-1][1:3])
    assert ends[0] == pytest.approx(ends[1], rel=1e-7) and ends[2] == pytest.approx(
        ends[1], rel=1e-7
    )
    done = pkgen(*run, "rk4", "--step", "0.2")
    assert done.returncode == 4
    assert "the constraints cannot be fulfilled here: c is left broken by" in done.stderr


def test_rows_turn_back_where_steps_do(pkgen, write) -> None:
    """Width .03: no row is behind the barrier, and the energy is kept in each."""
    done = pkgen("run", write(MODELS["wall"]), "--scene", "s", "--set", "w=0.03", "--every", "0.01",
                 "--json")  # fmt: skip
    rows = json.loads(done.stdout)["rows"]
    assert max(x for _, x, _, _ in rows) < X0 and rows[-1][2] == pytest.approx(-1, rel=1e-9)
    assert all(e == pytest.approx(0.5, rel=1e-6) for *_, e in rows)


PLACES = {
    "potential": "potential A*F(x - S)",
    "force": "force y = A*F(t - S)/w",
    "force of rates": "force y = A*F(x - S)*x'/w",
    "mass": "kinetic A*F(x - S)^2*y'^2",
    "let": "let p = x - S + 0.1*y\npotential A*F(p)",
    "moving": "potential A*F(x - S + 0.2*sin(3*t))",
    "pillar": "potential A*F(100*((x - S)^2 + (0.02*y)^2))",
    "state": "state e\nrate e = -e + A*F(x - S)/w\nforce y = e",
    "constraint": "constraint c: z = A*F(x - S)\nstart z = A*F(-S)",
    "constraint in t": "constraint c: z = A*F(t - S)\nstart z = A*F(-S)",
    "rolling": "rolling r: z' = A*F(x - S)\nstart z' = A*F(-S)",
    "hold": "HELD hold z = A*F(t - S)",
    "input": "force y = u/w\nHELD set u = A*F(t - S)",
}
# Beyond u = 236 cosh(u)^3, which second derivatives have, is no number.
FUNCTIONS = (
    "exp(-(({0})/w)^2)",
    "tanh(({0})/w)",
    "1/cosh(({0})/w)",
    "1/(1 + exp(({0})/w))",
    "1/(1 + (({0})/w)^2)",
    "1/(1 + (({0})/w)^2)^3",
    "1/sqrt(1 + (({0})/w)^8)",
    "((({0})/w)/(1 + (({0})/w)^4)^(1/4))",
)


def model_of(place: str, function: str, start: float) -> str:
    text, _, clause = PLACES[place].partition("HELD ")
    more = "input u\n" if place == "input" else ""
    text = (
        "model m\nparam w = 8e-3\nparam A = 0.3\ncoord x, y, z\n"
        f"{more}kinetic (x'^2 + y'^2 + z'^2)/2 + 0.2*y'*z' + 0.3*x'*z'\n"
        f"potential y^2/2\n{text}\nstart x' = 1.5, y = 0.2\nscene s\n  until 1.6\n  {clause}\nend\n"
    )
    while "F(" in text:
        first = text.index("F(")
        end, depth = first + 2, 1
        while depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        text = text[:first] + function.format(text[first + 2 : end - 1]) + text[end:]
    return text.replace("S", str(start))


@pytest.mark.parametrize("seed", seeds(range(3), 17))
def test_wherever_it_stands(pkgen, write, seed: int) -> None:
    """Random places and functions, by default settings and by steps of a third of the width."""
    draw = random.Random(seed)
    for place in draw.sample(sorted(PLACES), 2):
        # Those that fade by powers have a rate where constraints are to start.
        flat = 4 if place in ("constraint", "constraint in t", "rolling") else 8
        function = draw.choice(FUNCTIONS[: 2 if place == "pillar" else flat])
        path = write(model_of(place, function, draw.uniform(0.9, 1.3)))
        every = ("run", path, "--scene", "s", "--every", "1.6", "--json")
        ends = []
        resolved = ("--method", "dop853", "--rtol", "1e-12", "--max-step", "2.5e-3")
        for more in ((), resolved, (*resolved, "--set", "A=0")):
            done = pkgen(*every, *more)
            assert done.returncode == 0, (path.read_text(), done.stderr)
            ends.append(json.loads(done.stdout)["rows"][-1][1:7])
        found, right, without = ends
        assert max(abs(x - y) for x, y in zip(right, without, strict=True)) > 1e-5, path.read_text()
        assert found == pytest.approx(right, rel=1e-6, abs=1e-6), path.read_text()
