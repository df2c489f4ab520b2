"""All equilibria in reach: of potentials that are sums of double wells, weakly coupled, all 3^n are
known (by the implicit function theorem); of a ring there is a continuum."""

from __future__ import annotations

import itertools
import json
import random
from pathlib import Path

import pytest

from conftest import ran, seeds, written
from pkgen.__main__ import parser_of
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.stability.ask import Asker
from pkgen.analysis.stability.method import StepMap
from pkgen.analysis.stability.predict import MOST, predictions
from pkgen.analysis.stability.rest import Rest
from pkgen.cli.compilation import compile_within_limits
from pkgen.run.build import build_library
from pkgen.scenes import run_settings as parsing
from pkgen.scenes.compile_plan import whole

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


def sought(folder: Path, text: str, tries: int = 100) -> Rest:
    return asker_of(folder, text).rest(tries)


def asker_of(folder: Path, text: str) -> Asker:
    model = written(folder, text)
    options = parser_of("chart").parse_args([str(model)])
    compilation = compile_within_limits(options, unroll=None, use=whole(options))
    library = build_library(compilation.files, compilation.model.name)
    return Asker(library, parsing.settings(options, compilation))


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_every_well_and_saddle_is_found(seed: int, n: int, tmp_path: Path) -> None:
    text, at = wells(seed, n)
    places = [e.q for e in sought(tmp_path, text).equilibria]
    near = {
        tuple(
            min((-1, 0, 1), key=lambda k, x=x, a=a: abs(x - k * a))
            for x, a in zip(q, at, strict=True)
        )
        for q in places
    }
    assert len(places) == len(near) == 3**n
    # Without deflation some four of nine are.
    assert len(sought(tmp_path, text, 5).equilibria) >= 3**n * 3 // 4


def test_of_many_saddles_the_shortest_steps_are_told(tmp_path: Path) -> None:
    text, _ = wells(0, 3)
    asker = asker_of(tmp_path, text)
    rest = asker.rest()
    gauss1 = next(m for m in methods(None) if m.name == "gauss1")
    step = StepMap(gauss1, asker)
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
    model = tmp_path / "model.lag"
    text = f"potential (x^2 + y^2 - 1)^2 + {more}\nstart x = 0.9, y = 0.1\n"
    model.write_text(f"model ring\ncoord x, y\nkinetic (x'^2 + y'^2)/2\n{text}")
    words = ("--quick", "--methods", "verlet", "--until", 20, "--points", "4x3", "-o", tmp_path)
    done = ran("stability", model, *words, "--json")
    assert any(said in x for x in json.loads(done.stdout)["remarks"])
