"""Maps of linear models, of starts of zeros, and of what there was no time to measure."""

from __future__ import annotations

import cmath
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy
import pytest
from stability_asker import PENDULUM, asker, mapped, start

from conftest import case, run_pkgen, seeds, written
from pkgen.__main__ import main
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.stability import map as maps
from pkgen.analysis.stability import measure, text
from pkgen.analysis.stability.measure import FAILED
from pkgen.analysis.stability.method import StepMap
from pkgen.analysis.stability.predict import predictions
from pkgen.compiler import compile_model
from pkgen.front.read import from_text
from pkgen.middle.analyze import affine

PAIR = case("stability_linear_pair")
R: dict[str, Callable[[complex], complex]] = {  # what a step makes of exp(z)
    "euler": lambda z: 1 + z,
    "rk4": lambda z: 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24,
    "gauss1": lambda z: (1 + z / 2) / (1 - z / 2),
    "gauss2": lambda z: (1 + z / 2 + z**2 / 12) / (1 - z / 2 + z**2 / 12),
    "radau5": lambda z: (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60),
}


@pytest.mark.parametrize("seed", seeds(range(3), 37))
def test_linear_models_grow_where_a_multiplier_is_outside(seed: int) -> None:
    """Beside the eigenvalues of the equations, put through the method's own function."""
    draw = random.Random(seed)
    names = "m", "k", "l", "f", "w", "x", "y"
    values = {name: 10 ** draw.uniform(-1, 1) for name in names}
    damped = draw.choice((0.0, 0.1, 1.0))
    values |= {name: damped * draw.random() for name in "cd"}
    values["f"] *= draw.choice((0, 1, 1))
    m, k, spring, c, d = (values[name] for name in "mklcd")
    inverse = numpy.diag([1, 1 / m])
    stiff = inverse @ [[k + spring, -spring], [-spring, spring]]
    drag = inverse @ [[c + d, -d], [-d, d]]
    rates = numpy.linalg.eigvals(numpy.block([[0 * stiff, numpy.eye(2)], [-stiff, -drag]]))
    pair = asker(PAIR.format(**values), until=40 / min(abs(rates)))
    hs = [10 ** draw.uniform(-0.7, 1) / max(abs(rates)) for _ in range(4)]
    _, motion, points = measure.row(pair, dict.fromkeys(R, hs), None, 1, linear=True)
    assert motion.judges
    for point in points:
        most = max(abs(R[point.method](point.h * z)) for z in rates)
        found = measure.radius(pair, point.method, point.h)
        assert found == pytest.approx(most, rel=1e-8), point
        if most <= 1:
            assert point.kind not in FAILED, point
        elif most ** (point.steps / 8) > 1e6:
            assert point.kind in FAILED, point


def test_the_wrong_amplitude_of_a_driven_model_is_no_growth() -> None:
    """Steps between the turns of what drives it, by methods without a limit."""
    values = {"m": 0.05, "k": 40, "l": 1.8, "c": 0.2, "d": 0.06, "f": 0.1, "w": 6, "x": 0, "y": 0}
    damper = asker(PAIR.format(**values), until=52.36)
    steps = {"gauss1": [0.6708521802631772], "gauss2": [0.5750161545112947]}
    _, _, points = measure.row(damper, steps, None, 1, linear=True)
    assert [p.kind for p in points] == ["wrong amplitude"] * 2


def test_no_resonances_of_linear_models_are_predicted() -> None:
    model = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential x^2 + 2*y^2 + x*y/5 + {more}"
    model += "\nstart x = 1, y = 0.3\n"
    (verlet,) = methods(["verlet"])
    for more, linear in (("0", True), ("x^2*y/50", False)):
        compilation = compile_model(from_text("m.lag", model.format(more=more)), unroll=None)
        assert affine.linear(compilation.equations) == linear
        asked = asker(model.format(more=more))
        step = StepMap(verlet, asked, linear=linear)
        kinds = {p.kind for p in predictions(step, asked.rest(), 0)}
        assert ("1:3" in kinds) != linear and "limit" in kinds


def test_a_start_of_zeros_is_one_row_or_refused(tmp_path: Path) -> None:
    values = {"m": 1, "k": 1, "l": 1, "c": 0.1, "d": 0.1, "w": 2, "x": 0, "y": 0}
    words = "--methods", "gauss1", "--points", "4x5"
    made = mapped(tmp_path, PAIR.format(f=1, **values), *words)
    assert len({p["x"] for p in made["points"]}) == 1
    assert any("start is 0" in remark for remark in made["remarks"])
    done = run_pkgen("stability", written(tmp_path, PAIR.format(f=0, **values)), *words)
    assert done.returncode == 2 and "nothing moves" in done.stderr


def test_what_was_not_measured_is_not_as_predicted(tmp_path: Path, monkeypatch) -> None:
    kept = []
    make = maps.make
    monkeypatch.setattr(maps, "make", lambda *given: kept.append(make(*given)) or kept[0])
    few = ("--quick", "--methods", "rk4", "--points", "2x1", "--steps", "0.1..0.2")
    assert main(["stability", str(written(tmp_path, PENDULUM)), "-o", str(tmp_path), *few]) == 0
    made = replace(kept[0], measured=(), growths=())
    assert text.sentences(made)[0].startswith(
        "0 of 1 predictions are measured; not measured: limit"
    )
    assert "growth rates" in text.sentences(made)[0]
    assert not any("not measured" in line for line in text.sentences(kept[0]))


def test_states_by_whole_turns_are_one() -> None:
    """Verlet's pendulum, which goes round by whole turns a step, is a fixed point, no 2-cycle."""
    pendulum = start(asker(PENDULUM), 0.5)
    found = pendulum.orbits(method="verlet", h=1.9792, first=1, count=2, tries=16)
    assert any(o.steps == 1 for o in found)
    for o in (o for o in found if o.steps == 2):
        (q, v), (r, w) = o.states
        assert abs(cmath.exp(1j * q) - cmath.exp(1j * r)) + abs(v - w) > 1e-6
