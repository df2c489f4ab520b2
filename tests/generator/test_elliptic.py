"""Elliptic functions and Kepler's equation against mpmath, in Python, as derivatives, and in C."""

import math
import random
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from conftest import ran, run_pkgen
from pkgen.compiler import check_model
from pkgen.front.read import from_text
from pkgen.functions import FUNCTIONS
from pkgen.graph.differentiate import gradient
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import BIT, Graph, Kind, Symbol
from pkgen.source import ModelError

EPS = 2.3e-16


def eccentric(M: float, e: float) -> mp.mpf:
    """The E of E - e sin(E) = M by bisection, in 40 digits."""
    lo, hi = mp.mpf(M) - 1, mp.mpf(M) + 1
    for _ in range(130):
        E = (lo + hi) / 2
        lo, hi = (E, hi) if E - e * mp.sin(E) < M else (lo, E)
    return lo


def points() -> list[tuple[float, float, float, float]]:
    """Random (u, m, M, e), with m and e close to their ends among them."""
    draw = random.Random(48)
    near = [lambda: draw.random(), lambda: 1 - 10 ** -draw.uniform(0, 12)]
    near += [lambda: 10 ** -draw.uniform(0, 12), lambda: draw.choice((0.0, 0.5))]
    found = []
    for k in range(300):
        m, e = near[k % 4](), near[k // 4 % 4]()
        found.append((draw.uniform(-9, 9), m, draw.uniform(-9, 9), e))
    return found


def test_values_and_derivatives() -> None:
    g = Graph()
    symbols = [Symbol(Kind.COORDINATE, k) for k in range(2)]
    x, y = (g.symbol(s) for s in symbols)
    am, E = g.call("am", x, y), g.call("kepler", x, y)
    slopes = [gradient(g, node, BIT[Kind.COORDINATE]) for node in (am, E)]
    with mp.workdps(40):
        for u, m, M, e in points():
            sn, cn, dn = (mp.re(mp.ellipfun(name, u, m=m)) for name in ("sn", "cn", "dn"))
            phi, slope = evaluate(g, [am, slopes[0][x]], {symbols[0]: u, symbols[1]: m})
            assert abs(math.sin(phi) - sn) < 20 * EPS and abs(math.cos(phi) - cn) < 20 * EPS
            assert abs(slope - dn) < 20 * EPS
            # With sine, cosine and a quarter period's count it is the right turn, too.
            K = FUNCTIONS["ellipk"].real(m)
            assert abs(K - mp.ellipk(m)) < 5 * EPS * K
            assert round(phi / math.pi) == round(u / (2 * K)) or abs(math.cos(phi)) < 1e-6
            values = {symbols[0]: M, symbols[1]: e}
            found, by_M, by_e = evaluate(g, [E, slopes[1][x], slopes[1][y]], values)
            true = eccentric(M, e)
            below = 1 - e * mp.cos(true)
            assert abs(found - true) < 3 * EPS * abs(true) / below
            assert abs(by_M * below - 1) < 1e-13 / below**2
            assert abs(by_e * below - mp.sin(true)) < 1e-13 / below**2


def test_ends() -> None:
    am, ellipk, kepler = (FUNCTIONS[name].real for name in ("am", "ellipk", "kepler"))
    assert am(0.7, 1.0) == pytest.approx(2 * math.atan(math.tanh(0.35)), abs=1e-16)
    assert am(0.7, 0.0) == 0.7 and ellipk(0.0) == math.pi / 2 and ellipk(1.0) == math.inf
    assert ellipk(-3.0) == pytest.approx(float(mp.ellipk(-3)), rel=1e-15)
    assert kepler(3.0, 0.0) == 3.0 and kepler(0.0, 0.9) == 0
    with pytest.raises(ValueError):
        kepler(1.0, -0.1)


def test_the_same_in_c(tmp_path: Path) -> None:
    """Each value is an output of a model whose parameters change from member to member."""
    model, members, rows = (tmp_path / x for x in ("c.lag", "members.csv", "rows.csv"))
    forms = {"am": "am(x, m)", "dn": "dn(x, m)", "K": "ellipk(m)", "E": "kepler(y, e)"}
    lines = ["model c", "param m = 0", "param e = 0", "coord x, y", "kinetic x'^2/2 + y'^2/2"]
    model.write_text("\n".join([*lines, *(f"observe {n} = {x}" for n, x in forms.items())]) + "\n")
    given = [*points(), (1.0, -3.0, 2.0, 0.5)]
    lines = [f"{u!r},{m!r},{M!r},{e!r}" for u, m, M, e in given]
    members.write_text("\n".join(["x,m,y,e", *lines]) + "\n")
    options = ["--until", 1, "--every", 1, "--ensemble", members, "--record", "am,dn,K,E"]
    ran("run", model, *options, "-o", rows)
    found = np.genfromtxt(rows, delimiter=",", names=True)
    found = found[found["t"] == 0]
    for row, (u, m, M, e) in zip(found, given, strict=True):
        phi = FUNCTIONS["am"].real(u, m)
        assert abs(row["am"] - phi) < 30 * EPS * (1 + abs(phi))
        dn = math.sqrt(math.cos(phi) ** 2 + (1 - m) * math.sin(phi) ** 2)
        assert abs(row["dn"] - dn) < 60 * EPS
        K, E = FUNCTIONS["ellipk"].real(m), FUNCTIONS["kepler"].real(M, e)
        assert row["K"] == K or abs(row["K"] - K) < 4 * EPS * K
        assert abs(row["E"] - E) < 3 * EPS * abs(E) / (1 - e * math.cos(E))
    for m, e in ((1, 0.5), (1.5, 0.5), (0.5, 1.5), (0.5, -0.1)):
        members.write_text(f"x,m,y,e\n1,{m},1,{e}\n")
        refused = run_pkgen("run", model, *options)
        assert refused.returncode == 2 or "not finite" in refused.stderr + refused.stdout, (m, e)


def test_the_parameter_may_not_move() -> None:
    text = "model a\ncoord x\nkinetic x'^2/2\npotential {}\n"
    for form, at in (("am(x, t)", "4:17"), ("sn(0.5, x)", "4:19"), ("ellipk(x/9)", "4:18")):
        with pytest.raises(ModelError) as said:
            check_model(from_text("a.lag", text.format(form)))
        assert f"a.lag:{at}: error: the m of " in said.value.text()
        assert "moves: its derivative is not known" in said.value.text()
    with pytest.raises(ModelError, match="am has no real value here"):
        check_model(from_text("a.lag", text.format("x^2*am(2, 1.5)")))
