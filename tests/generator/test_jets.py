"""Taylor coefficients of the kernel `jet` against those that mpmath finds by differences, at 60
digits, of the accelerations along the series so far."""

import ctypes
import random

import mpmath
import pytest
from c_harness import Loaded

from conftest import run_pkgen, seeds
from pkgen.back.c import jet_kernel, lower
from pkgen.front.check import check
from pkgen.graph.differentiate import reachable
from pkgen.graph.graph import Kind, Op, Symbol
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive
from pkgen.middle.derive.states import as_rates
from pkgen.source import Source

ORDER = 14
TERMS = (
    "sin({a} - {b})", "cos({a})*{b}", "exp({a}/3)", "log(2 + {a}^2)", "sqrt(2 + {a}*{b}/4)",
    "tan({a}/3)", "tanh({a} + {b})", "atan({a}*{b})", "sinh({a}/2)", "cosh({b}/2)", "{a}^3*{b}",
    "(3 + {a}*{b}/5)^(2/3)", "1/(3 + {a})", "{a}^2*sin(2*t)", "{b}/(4 + t + {a}^2)", "{a}*{b}",
    "abs({a} - 0.3)*{b}", "max({a}, {b}/2)^2", "min({b}, 0.1 + {a})*{a}",
)  # fmt: skip


def drawn(dice: random.Random) -> str:
    """A model of up to three coordinates and a state, with a diagonal or a dense M."""
    n = dice.randint(1, 3)
    q = [f"q{k}" for k in range(n)]

    def term() -> str:
        a, b = dice.choice(q), dice.choice(q)
        return f"{dice.uniform(-1, 1):.3f}*k*{dice.choice(TERMS).format(a=a, b=b)}"

    masses = [f"(2 + cos({dice.choice(q)})*k)*{x}'^2" if dice.random() < 0.5 else f"k*{x}'^2"
              for x in q]  # fmt: skip
    if n > 1 and dice.random() < 0.6:
        masses.append(f"0.4*sin({q[-1]})*{q[0]}'*{q[1]}'")
    text = f"model drawn\nparam k = {dice.uniform(0.5, 1.5):.3f}\ncoord {', '.join(q)}\n"
    text += f"kinetic {' + '.join(masses)}\npotential {term()} + {term()} + {q[0]}^2\n"
    text += dice.choice(("", f"dissipation k*{q[0]}'^2*{q[-1]}^2\n"))
    if dice.random() < 0.5:
        text += f"state z\nrate z = {q[0]}' - z*{term()}\nforce {q[-1]} = z\n"
    return text


def value(g, nodes, of):
    """The values of nodes, by mpmath; `of` has those of symbols."""
    found = {}
    for n in reachable(g, nodes):
        x = [found[a] for a in g.args[n]]
        data = g.data[n]
        if g.op[n] is Op.NUMBER:
            found[n] = mpmath.mpf(data.numerator) / data.denominator
        elif g.op[n] is Op.SYMBOL:
            found[n] = of(data)
        elif g.op[n] is Op.POWER:
            found[n] = x[0] ** (mpmath.mpf(data.numerator) / data.denominator)
        elif g.op[n] is Op.CALL:
            ways = {"pow": lambda a, b: a**b, "reciprocal": lambda a: 1 / a, "abs": abs}
            ways |= {"max": max, "min": min, "step": lambda a: mpmath.mpf(a > 0)}
            found[n] = ways.get(data, getattr(mpmath, data, None))(*x)
        else:
            found[n] = x[0] + x[1] if g.op[n] is Op.ADD else x[0] * x[1]
    return [found[n] for n in nodes]


def expected(e, t, q, v, order):
    """The coefficients of q and of v, by order."""
    g, n, own = e.graph, len(v), len(q)
    parameters = {k: g.value(slot.default) for k, slot in enumerate(e.parameters)}
    series = [[mpmath.mpf(x)] for x in (*q, *v)]

    def rates(s, row):
        def of(symbol: Symbol):
            if symbol.kind is Kind.PARAMETER:
                x = parameters[symbol.index]
                return mpmath.mpf(x.numerator) / x.denominator
            if symbol.kind is Kind.TIME:
                return t + s
            if symbol.kind is Kind.PI:
                return +mpmath.pi
            of_v = own if symbol.kind is Kind.RATE else 0
            return mpmath.polyval(series[of_v + symbol.index][::-1], s)

        return value(g, [e.acceleration[row]], of)[0]

    for k in range(order):
        new = [mpmath.taylor(lambda s, i=i: rates(s, i), 0, k)[k] / (k + 1) for i in range(n)]
        old = [series[own + i][k] / (k + 1) for i in range(own)]
        for x, more in zip(series, [*old, *new], strict=True):
            x.append(more)
    return [[float(x[k]) for x in series] for k in range(order + 1)]


def jet(loaded, t, q, v, order):
    count = len(q) + len(v)
    out = (ctypes.c_double * (count * (order + 1)))()
    state = [(ctypes.c_double * len(x))(*x) for x in (q, v)]
    function = loaded.function("jet", ctypes.c_int)
    arguments = loaded.params, ctypes.c_double(t), *state, None, order, out
    return function(*arguments), [list(out[k * count : (k + 1) * count]) for k in range(order + 1)]


def loaded(text, directory):
    model, _ = check.check_text(Source("model.lag", text))
    equations = derive.derive(model)
    e, structure = as_rates(equations, analyze.analyze(equations), None)
    program = lower.lower(e, structure, frozenset({"acceleration", "jet"}))
    if not program.jet:
        pytest.skip("a kink that a run does not locate")
    made = Loaded(program, directory, optimise="-O0")
    assert made.prepare() == 0
    return e, made


@pytest.mark.parametrize("seed", seeds(range(8), turning=4))
def test_coefficients_are_those_of_mpmath(seed, tmp_path, monkeypatch):
    dice = random.Random(seed)
    # straight-line code up to the order wanted, up to a part of it, or none
    monkeypatch.setattr(jet_kernel, "FITS", dice.choice((0, 300, 1e4)))
    text = drawn(dice)
    e, made = loaded(text, tmp_path)
    t = dice.uniform(0, 2)
    q, v = ([dice.uniform(-1, 1) for _ in range(n)] for n in (e.own, len(e.force)))
    with mpmath.workdps(80):
        wanted = expected(e, t, q, v, ORDER)
    status, found = jet(made, t, q, v, ORDER)
    assert status == 0
    for k, (one, other) in enumerate(zip(found, wanted, strict=True)):
        size = max(map(abs, other))
        assert one == pytest.approx(other, rel=1e-11, abs=1e-12 * size), f"order {k}\n{text}"


def test_a_model_without_series_is_refused(tmp_path):
    model = tmp_path / "m.lag"
    model.write_text("model m\ncoord x\nkinetic x'^2/2\npotential x^2\nforce x = asin(x)\n")
    found = run_pkgen(model, "--kernels", "jet", "-o", tmp_path)
    assert found.returncode == 2 and "nor with functions other than sin" in found.stderr
    assert not (tmp_path / "m.c").exists()


def test_orders_and_failures(tmp_path):
    _, made = loaded("model m\ncoord x\nkinetic (1 + x)*x'^2/2\npotential x^2\n", tmp_path)
    assert jet(made, 0, [0.3], [1.0], 0)[0] == 0 and jet(made, 0, [0.3], [1.0], 30)[0] == 0
    assert jet(made, 0, [0.3], [1.0], 31)[0] == 1
    assert jet(made, 0, [-2.0], [1.0], 3)[0] != 0
