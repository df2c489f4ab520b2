"""All equilibria in reach: of potentials that are sums of double wells, weakly coupled, all 3^n are
known (by the implicit function theorem); of a ring there is a continuum."""

from __future__ import annotations

import itertools
import random
from pathlib import Path

import pytest
from stability_asker import asker, mapped

from conftest import seeds
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.stability.method import StepMap
from pkgen.analysis.stability.predict import MOST, predictions

NAMES = "xyz"


def wells(seed: int, n: int) -> tuple[str, list[float]]:
    chance = random.Random(seed)
    at = [round(chance.uniform(0.3, 3.0), 3) for _ in range(n)]
    terms = [
        f"{chance.uniform(0.5, 2):.3f}*({c}^2 - {a}^2)^2" for c, a in zip(NAMES, at, strict=False)
    ]
    least = min(at) ** 4
    terms += [
        f"{0.02 * least * chance.choice((-1, 1)):.5f}*sin({a} + 2*{b})"
        for a, b in itertools.combinations(NAMES[:n], 2)
    ]
    kinetic = " + ".join(f"{c}'^2/2" for c in NAMES[:n])
    start = ", ".join(f"{c} = {0.9 * a:.4g}" for c, a in zip(NAMES, at, strict=False))
    text = f"model wells\ncoord {', '.join(NAMES[:n])}\nkinetic {kinetic}\n"
    return f"{text}potential {' + '.join(terms)}\nstart {start}\n", at


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_every_well_and_saddle_is_found(seed: int, n: int) -> None:
    text, at = wells(seed, n)
    places = [e.q for e in asker(text).rest(100).equilibria]
    near = {
        tuple(
            min((-1, 0, 1), key=lambda k, x=x, a=a: abs(x - k * a))
            for x, a in zip(q, at, strict=True)
        )
        for q in places
    }
    assert len(places) == len(near) == 3**n
    # Without deflation some four of nine are.
    assert len(asker(text).rest(5).equilibria) >= 3**n * 3 // 4


def test_of_many_saddles_the_shortest_steps_are_told() -> None:
    text, _ = wells(0, 3)
    asked = asker(text)
    rest = asked.rest()
    gauss1 = next(m for m in methods(None) if m.name == "gauss1")
    step = StepMap(gauss1, asked)
    primary = next(k for k, e in enumerate(rest.equilibria) if e.stable)
    grow = sorted(max(m.growth for m in e.modes) for e in rest.equilibria if not e.stable)
    assert len({round(g, 6) for g in grow}) > 2 * MOST
    told = [p.h for p in predictions(step, rest, primary) if p.kind == "branch"]
    assert len(told) == MOST and min(told) == pytest.approx(2 / grow[-1], rel=1e-5)


@pytest.mark.parametrize(
    ("more", "said"), [("y^2", "found 5, sought from 101"), ("0", "continuum")]
)
def test_a_map_says_what_was_sought(more: str, said: str, tmp_path: Path) -> None:
    """Of V = (r^2 - 1)^2 + y^2: (0, 0), (+-1, 0), (0, +-sqrt(1/2)); a ring of them without y^2."""
    text = "model ring\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nstart x = 0.9, y = 0.1\n"
    text += f"potential (x^2 + y^2 - 1)^2 + {more}\n"
    words = ("--methods", "verlet", "--until", 20, "--points", "4x3")
    assert any(said in x for x in mapped(tmp_path, text, *words)["remarks"])
