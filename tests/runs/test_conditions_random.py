"""Random conditions, floor, ceil, round, mod: values against Python, motions against SciPy.
SciPy is stopped at each boundary and begins again beyond it with the branch that holds
there."""

import math
import random

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pkgen
from conftest import seeds
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import Source

NAMES = ("x", "y", "x'", "y'", "t")


def number(draw: random.Random, depth: int) -> tuple[str, str]:
    """An expression in the language and in Python."""
    if depth == 0 or draw.random() < 0.2:
        name = draw.choice(NAMES)
        return (
            (name, name.replace("'", "_"))
            if draw.random() < 0.7
            else (str(draw.randint(1, 9)),) * 2
        )
    kind = draw.choice(("if", "if", "max", "min", "floor", "round", "ceil", "mod", "+", "*", "sin"))
    parts = [number(draw, depth - 1) for _ in range(draw.choice((2, 3)))]
    (a, pa), (b, pb) = parts[:2]
    if kind == "if":
        c, pc = condition(draw, depth - 1)
        return f"if({c}, {a}, {b})", f"({pa} if {pc} else {pb})"
    if kind in ("max", "min"):
        return tuple(f"{kind}({', '.join(side)})" for side in zip(*parts, strict=True))
    if kind == "round":
        return f"round({a})", f"math.floor({pa} + 0.5)"
    if kind == "mod":
        return f"mod({a}, {b}^2 + 1)", f"(({pa}) % (({pb})**2 + 1))"
    if kind in ("floor", "ceil", "sin"):
        return f"{kind}({a})", f"math.{kind}({pa})"
    return f"({a} {kind} {b})", f"({pa} {kind} {pb})"


def condition(draw: random.Random, depth: int) -> tuple[str, str]:
    if depth > 0 and draw.random() < 0.5:
        (a, pa), (b, pb) = condition(draw, depth - 1), condition(draw, depth - 1)
        word = draw.choice(("and", "or"))
        deny = draw.choice(("", "not "))
        return f"{deny}({a} {word} {b})", f"({deny}({pa} {word} {pb}))"
    (a, pa), (b, pb) = number(draw, depth - 1 if depth else 0), number(draw, 0)
    sign = draw.choice(("<", "<=", ">", ">="))
    return f"{a} {sign} {b}", f"({pa} {sign} {pb})"


@pytest.mark.parametrize("seed", seeds(range(3), 60))
def test_values_are_those_of_python(seed: int) -> None:
    draw = random.Random(seed)
    pairs = [number(draw, 4) for _ in range(4)]
    text = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n"
    text += "".join(f"observe o{k} = {a}\n" for k, (a, _) in enumerate(pairs))
    e = derive(check_text(Source("m.lag", text))[0])
    for _ in range(20):
        values = [draw.uniform(-3, 3) for _ in NAMES]
        at = dict(zip((n.replace("'", "_") for n in NAMES), values, strict=True))
        symbols = [Symbol(k, i) for k in (Kind.COORDINATE, Kind.RATE) for i in range(2)]
        found = evaluate(
            e.graph, e.observed, dict(zip([*symbols, Symbol(Kind.TIME)], values, strict=True))
        )
        wanted = [eval(p, {"math": math, **at}) for _, p in pairs]
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9), text


@pytest.mark.parametrize(("sign", "equal"), [("<", 0), ("<=", 1), (">", 0), (">=", 1)])
def test_equal_numbers_are_judged_by_the_sign(sign: str, equal: int) -> None:
    text = f"model m\ncoord x, y\nkinetic x'^2 + y'^2\nobserve o = if(x {sign} y, 1, 0)\n"
    e = derive(check_text(Source("m.lag", text))[0])
    state = {Symbol(Kind.COORDINATE, k): 0.5 for k in range(2)}
    assert evaluate(e.graph, e.observed, state) == [equal]


ZEROS = {"if(u > 0, 1, 0)": 0, "if(u >= 0, 1, 0)": 1, "sign(u)": 0, "step(u)": 1}


def test_an_argument_that_stays_zero_has_its_own_value(tmp_path) -> None:
    coords = [f"x{k}" for k in range(len(ZEROS))]
    forces = "".join(f"force {x} = {form}\n" for x, form in zip(coords, ZEROS, strict=True))
    kinetic = "kinetic " + " + ".join(f"{x}'^2/2" for x in coords)
    text = f"model z\ninput u\ncoord {', '.join(coords)}\n{kinetic}\n{forces}"
    (tmp_path / "z.lag").write_text(text)
    m = pkgen.load(str(tmp_path / "z.lag"))
    wanted = pytest.approx([*ZEROS.values()], abs=1e-9)
    for method, step in (("gauss", None), ("dop853", None), ("rk4", 1 / 64), ("gauss2", 1 / 64)):
        r = m.run(until=1, every=1, method=method, step=step)
        assert [r[f"{x}'"][-1] for x in coords] == wanted, method
    r = m.ensemble({"u": np.zeros(9), "x0'": np.arange(9.0)}, until=1, method="dop853")
    for member in range(9):
        rates = [r[f"{x}'"][member] for x in coords]
        assert [rates[0] - member, *rates[1:]] == wanted


def test_an_argument_that_leaves_zero_is_held_again(tmp_path) -> None:
    begins = {"t": 0, "-t": 1, "t^3": 0, "t - 1/2": 1 / 2, "1/2 - t": 0}  # where y > 0 begins
    text = "model z\n"
    for k, shape in enumerate(begins):
        text += f"coord x{k}, y{k}\nforce y{k} = max({shape}, 0)\nforce x{k} = if(y{k} > 0, 3, 1)\n"
    text += "kinetic " + " + ".join(f"(x{k}'^2 + y{k}'^2)/2" for k in range(len(begins)))
    (tmp_path / "z.lag").write_text(text + "\n")
    m = pkgen.load(str(tmp_path / "z.lag"))
    for method in ("gauss", "dop853"):
        r = m.run(until=1, every=1, method=method)
        wanted = [1 + 2 * (1 - begin) for begin in begins.values()]
        # y leaves 0 as (t - 1/2)^3, whose root is known to the cube root of its rounding.
        found = [r[f"x{k}'"][-1] for k in range(len(begins))]
        assert found == pytest.approx(wanted, abs=2e-6), method


class Boundary:
    """Where a comparison of two numbers turns, or where a floor jumps; `held` is its value."""

    def __init__(self, draw: random.Random):
        a, b = draw.choice(("x", "y", "t/3", "x + y/2")), round(draw.uniform(-0.6, 1.1), 3)
        self.floor = draw.random() < 0.3
        # With 15 a step may cross several pieces.
        self.scale = scale = draw.choice((2, 15))
        self.text = f"floor(({a})*{scale} + {b})" if self.floor else f"{a} > {b}"
        function = eval(f"lambda t, x, y: {a}")
        self.value = lambda t, s: (
            function(t, *s[:2]) * scale + b if self.floor else function(t, *s[:2]) - b
        )

    def now(self, t, s):
        return math.floor(self.value(t, s)) if self.floor else float(self.value(t, s) > 0)

    def event(self, t, s):
        return math.sin(math.pi * self.value(t, s)) if self.floor else self.value(t, s)

    def turned(self, held: float, t, s) -> float:
        if not self.floor:
            return 1 - held
        return held + (1 if round(self.value(t, s)) > held else -1)


def by_scipy(boundaries, force, start, until: float) -> np.ndarray:
    t, s = 0.0, np.array(start)
    held = [b.now(t, s) for b in boundaries]

    def rates(t, s):
        return [s[2], s[3], *force(t, s, held)]

    events = [lambda t, s, b=b: b.event(t, s) for b in boundaries]
    for event in events:
        event.terminal = True
    accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    while t < until:
        beyond = min(t + 1e-7, until)  # off the boundary at which it begins
        s = solve_ivp(rates, (t, beyond), s, **accuracy).y[:, -1]
        found = solve_ivp(rates, (beyond, until), s, events=events, max_step=0.02, **accuracy)
        t, s = found.t[-1], found.y[:, -1]
        for k, at in enumerate(found.t_events):
            if len(at):
                held[k] = boundaries[k].turned(held[k], t, s)
    return s


@pytest.mark.parametrize("seed", seeds(range(200, 203), 37))
def test_motions_are_those_of_scipy_stopped_at_each_boundary(seed: int, tmp_path) -> None:
    draw = random.Random(seed)
    boundaries = [Boundary(draw) for _ in range(draw.randint(1, 3))]
    weights = [[round(draw.uniform(-0.8, 0.8), 3) for _ in boundaries] for _ in range(2)]
    curved = draw.random() < 0.5

    def term(b: Boundary, weight: float) -> str:
        if b.floor:
            return f"{weight}/{b.scale}*{b.text}"
        return f"if({b.text}, {weight}*(1 + x^2*{int(curved)}), 0)"

    forces = [
        f"force {q} = -2*{q} - {r}*{s} + " + " + ".join(map(term, boundaries, w))
        for q, r, s, w in zip("xy", (0.3, 0.2), "yx", weights, strict=True)
    ]
    start = [round(draw.uniform(-1, 1), 3) for _ in range(4)]
    text = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n" + "\n".join(forces)
    text += f"\nstart x = {start[0]}, y = {start[1]}, x' = {start[2]}, y' = {start[3]}\n"

    def force(t, s, held):
        x, y = s[:2]
        bent = [
            h * (1 / b.scale if b.floor else 1 + x * x * curved)
            for b, h in zip(boundaries, held, strict=True)
        ]
        return -2 * x - 0.3 * y + np.dot(weights[0], bent), -2 * y - 0.2 * x + np.dot(
            weights[1], bent
        )

    (tmp_path / "m.lag").write_text(text)
    method = draw.choice(("gauss", "dop853"))
    run = pkgen.load(str(tmp_path / "m.lag")).run(until=4, method=method, rtol=1e-12, every=4)
    wanted = by_scipy(boundaries, force, start, 4.0)
    found = [run[name][-1] for name in ("x", "y", "x'", "y'")]
    assert found == pytest.approx(list(wanted), rel=0, abs=3e-9), text
