"""The canonical form against the kernels of the Lagrangian one, and the motion that it gives."""

import random
from pathlib import Path

import pytest
from c_harness import MASS, ODD, Loaded, failed

from conftest import MODELS, case, ran
from pkgen.back.c import lower
from pkgen.front.check import check
from pkgen.middle.analyze import analyze
from pkgen.middle.derive import derive
from pkgen.middle.derive.canonical import with_hamiltonian
from pkgen.source import ModelError, Source

# Terms of first degree in the rates, explicit time, a force, friction: all that H has to carry.
GENERAL = case("general")
TEXTS = [*((path.stem, path.read_text()) for path in MODELS), ("odd", ODD), ("general", GENERAL)]


def loaded(text: str, directory: Path) -> Loaded:
    model, _ = check.check_text(Source("model.lag", text))
    equations = derive.derive(model)
    structure = analyze.analyze(equations, with_claims=True)
    return Loaded(lower.lower(with_hamiltonian(equations, structure), structure), directory)


@pytest.mark.parametrize(("name", "text"), TEXTS, ids=[name for name, _ in TEXTS])
def test_h_is_the_energy_and_its_gradients_are_the_motion(name: str, text: str, tmp_path) -> None:
    system = loaded(text, tmp_path)
    e = system.program.equations
    n, random_ = len(e.coordinates), random.Random(name)
    applied = 0.0
    for _ in range(4):
        t, *u = (random_.uniform(-1, 1) for _ in range(1 + len(e.inputs)))
        q, v = ([random_.uniform(0.3, 1.2) for _ in range(n)] for _ in range(2))
        _, (p, pdot) = system.call("canonical", t, q, v, u)
        status, ((h,),) = system.call("hamiltonian", t, q, p, u)
        energy, _ = system.call("energy", t, q, v, u)
        _, (by_q, by_p) = system.call("hamilton", t, q, p, u)
        _, (gradient,) = system.call("gradient", t, q, v, u)
        assert status == 0
        assert h == pytest.approx(energy, rel=1e-12, abs=1e-12)
        assert by_p == pytest.approx(v, rel=1e-11, abs=1e-12)
        assert [-x for x in by_q] == pytest.approx(gradient, rel=1e-11, abs=1e-12)
        assert max(map(abs, p)) > 0.01
        force = [a - b for a, b in zip(pdot, gradient, strict=True)]
        if system.program.kernel("hamilton_force"):
            _, (besides,) = system.call("hamilton_force", t, q, p, u)
            assert besides == pytest.approx(force, rel=1e-11, abs=1e-12)
            applied = max(applied, *map(abs, besides))
        else:
            assert force == [0.0] * n
    assert (applied > 0.01) == (name in ("odd", "general"))


def test_the_gradients_are_those_of_h(tmp_path) -> None:
    """By central differences of H, which knows nothing of L."""
    system = loaded(GENERAL, tmp_path)
    q, p, d = [0.4, -0.7, 1.1], [0.9, 0.2, -0.6], 1e-5
    _, rows = system.call("hamilton", 0.3, q, p)
    for side in range(2):
        for i in range(3):
            ends = []
            for sign in (1, -1):
                at = [list(q), list(p)]
                at[side][i] += sign * d
                ends.append(system.call("hamiltonian", 0.3, *at)[1][0][0])
            assert rows[side][i] == pytest.approx((ends[0] - ends[1]) / (2 * d), abs=1e-9)


def flow(system: Loaded, q: list[float], p: list[float], until: float, steps: int) -> list[float]:
    """Hamilton's equations by the classical Runge-Kutta method."""
    n, h = len(q), until / steps
    forced = system.program.kernel("hamilton_force") is not None

    def slope(t: float, y: list[float]) -> list[float]:
        _, (by_q, by_p) = system.call("hamilton", t, y[:n], y[n:])
        force = system.call("hamilton_force", t, y[:n], y[n:])[1][0] if forced else [0.0] * n
        return [*by_p, *(f - x for f, x in zip(force, by_q, strict=True))]

    y = [*q, *p]
    for k in range(steps):
        t, stages = k * h, []
        for c in (0, 0.5, 0.5, 1):
            moved = [a + c * h * b for a, b in zip(y, stages[-1], strict=True)] if stages else y
            stages.append(slope(t + c * h, moved))
        a, b, c, d = stages
        y = [x + h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]) for i, x in enumerate(y)]
    return y


def test_the_motion_is_that_of_the_lagrangian_form(tmp_path: Path) -> None:
    system = loaded(GENERAL, tmp_path)
    q, v = [0.3, 0.0, 0.9], [0.0, 0.5, -0.2]
    _, (p, _) = system.call("canonical", 0.0, q, v)
    end = flow(system, q, p, 2.0, 400)
    path = tmp_path / "general.lag"
    path.write_text(GENERAL)
    done = ran("run", path, "--until", "2", "--every", "2", "--rtol", "1e-13")
    last = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert end[:3] == pytest.approx(last[1:4], abs=1e-9)
    assert max(abs(a - b) for a, b in zip(end, q, strict=False)) > 0.1


@pytest.mark.parametrize("friction", [0.0, 0.31])
def test_liouville(friction: float, tmp_path: Path) -> None:
    """The flow keeps volumes in phase space, but for friction: they shrink as e^-(tr dQ/dp) t."""
    text = GENERAL.replace("param c = 0.31", f"param c = {friction}")
    text = text.replace("force y = 0.4*cos(t)*x'\n", "")
    system = loaded(text, tmp_path)
    start, d, until = [0.3, 0.1, 0.9, 0.2, 0.5, -0.2], 1e-4, 1.0
    columns = []
    for i in range(6):
        ends = []
        for sign in (1, -1):
            at = list(start)
            at[i] += sign * d
            ends.append(flow(system, at[:3], at[3:], until, 50))
        columns.append([(a - b) / (2 * d) for a, b in zip(*ends, strict=True)])
    volume = determinant(columns)
    if friction:
        assert 0.5 < volume < 0.95
    else:
        assert volume == pytest.approx(1, abs=1e-6)
        assert max(abs(columns[i][i] - 1) for i in range(6)) > 0.1


def determinant(rows: list[list[float]]) -> float:
    rows, value = [list(row) for row in rows], 1.0
    for k in range(len(rows)):
        pivot = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
        if pivot != k:
            rows[k], rows[pivot], value = rows[pivot], rows[k], -value
        value *= rows[k][k]
        for row in rows[k + 1 :]:
            factor = row[k] / rows[k][k]
            row[k:] = [a - factor * b for a, b in zip(row[k:], rows[k][k:], strict=True)]
    return value


def test_what_has_no_closed_form_is_refused(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "relativistic.lag"
    path.write_text("model relativistic\ncoord x\nlagrangian -sqrt(1 - x'^2) - x^2/2\n")
    done = pkgen(path, "--canonical", "-o", tmp_path)
    assert done.returncode == 1
    assert "relativistic.lag:3:12: error: there is no canonical form" in done.stderr
    model, _ = check.check_text(Source("relativistic.lag", path.read_text()))
    equations = derive.derive(model)
    with pytest.raises(ModelError):
        with_hamiltonian(equations, analyze.analyze(equations))


def test_singular_m_is_a_status(tmp_path: Path) -> None:
    system = loaded("model m\ncoord r, phi\nkinetic (r'^2 + r^2*phi'^2)/2\npotential r\n", tmp_path)
    assert system.call("hamiltonian", 0.0, [0.0, 1.0], [1.0, 1.0]) == (failed(MASS, 1), [[9.875]])
    assert system.call("hamilton", 0.0, [0.0, 1.0], [1.0, 1.0])[0] == failed(MASS, 1)


def test_explain_shows_it(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "pendulum.lag"
    path.write_text("model m\nparam l = 2\ncoord a\nkinetic l^2*a'^2/2\npotential -l*cos(a)\n")
    done = pkgen("explain", path, "--canonical")
    assert "  H = -l*cos(a) + p_a^2/(2*l^2)\n" in done.stdout
    assert "  dH/d(a) = l*sin(a)\n  dH/d(p_a) = p_a/l^2\n" in done.stdout
    assert "Canonical" not in pkgen("explain", path).stdout


def test_c_of_a_scene_has_the_momenta_of_its_starts(pkgen, tmp_path: Path) -> None:
    path = tmp_path / "one.lag"
    path.write_text(case("one"))
    for options, there in ([], False), (["--canonical"], True):
        assert pkgen(path, "--scene", "still", *options, "-o", tmp_path).returncode == 0
        header = (tmp_path / "one_still.h").read_text()
        assert ("one_still_hamilton(" in header) is there
        assert ("one_still_canonical(" in header) is there  # p of the start; rk4 does without
