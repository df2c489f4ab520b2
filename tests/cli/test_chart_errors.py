"""`pkgen chart --error` and `--starts`, beside closed forms of the harmonic oscillator.

Verlet on x'' = -x keeps x^2 (1 - h^2/4) + v^2 and turns by 2 arcsin(h/2) a step (E. Hairer,
C. Lubich, G. Wanner, Geometric Numerical Integration, I.5), from x = 1, v = 0.
"""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy
import pytest

from conftest import case, ran, written
from pkgen.__main__ import parser_of
from pkgen.analysis.chart.errors import KINDS, ErrorKind, Measure
from pkgen.analysis.chart.measure import Program
from pkgen.analysis.chart.points import ChartedMethod
from pkgen.analysis.chart.rows import Rows
from pkgen.cli.compilation import compile_within_limits
from pkgen.run.build import build_library
from pkgen.run.library import Run
from pkgen.scenes import run_settings as asked
from pkgen.scenes.compile_plan import whole

MODEL = case("oscillator")
UNTIL, TIMES = 20.0, 100


def verlet(h: float, t: float) -> tuple[float, float]:
    """At t: by closed form to the last whole step, from there by a shorter one."""
    whole = math.floor(t / h + 1e-9)
    angle, rest = 2 * math.asin(h / 2) * whole, t - whole * h
    x, v = math.cos(angle), -math.sqrt(1 - h * h / 4) * math.sin(angle)
    v -= rest / 2 * x
    x += rest * v
    return x, v - rest / 2 * x


def far(h: float, t: float) -> float:
    x, v = verlet(h, t)
    return max(abs(x - math.cos(t)), abs(v + math.sin(t)))


def times() -> list[float]:
    return [k * UNTIL / TIMES for k in range(TIMES + 1)]


EXPECTED = {
    "final": lambda h: far(h, UNTIL),
    "max": lambda h: max(far(h, t) for t in times()),
    "mean": lambda h: sum(far(h, t) for t in times()) / (TIMES + 1),
    # The energy is (1 - (1 - x^2) h^2/4)/2, its parts L and v p are 3/2 at most.
    "energy": lambda h: h * h / 12,
    "phase": lambda h: 2 * math.asin(h / 2) / h - 1,
}


def charted(folder: Path, *words: object) -> tuple[dict, list[dict[str, str]]]:
    model = written(folder, MODEL)
    # Of four seconds it needs one; a loaded machine more.
    fixed = f"--quick --until {UNTIL} --methods verlet --points 6 --seconds 4 --json".split()
    done = ran("chart", model, *fixed, "-o", folder, *words)
    with (folder / "oscillator_chart.csv").open() as file:
        return json.loads(done.stdout), list(csv.DictReader(file))


@pytest.mark.parametrize("kind", EXPECTED)
def test_errors_are_those_of_closed_forms(kind: str, tmp_path: Path) -> None:
    told, rows = charted(tmp_path, "--error", kind)
    assert told["error"] == kind and told["starts"] == 1
    seen = 0
    for row in rows:
        h = float(row["step"])
        if row["outcome"] != "done" or h > 0.2:
            continue
        seen += 1
        within = {"phase": 0.05, "energy": 0.02}.get(kind, 1e-4)
        assert float(row["error"]) == pytest.approx(EXPECTED[kind](h), rel=within)
    assert seen > 2


@pytest.mark.parametrize("kind", [kind for kind in KINDS.values() if kind.path])
def test_states_on_the_way_that_end_early_are_given_up(kind: ErrorKind, tmp_path: Path) -> None:
    """A cap that only the run with rows meets, as on a machine that is busy at that moment."""
    model = written(tmp_path, MODEL)
    options = parser_of("chart").parse_args([str(model), "--until", str(UNTIL)])
    compilation = compile_within_limits(options, unroll=None, use=whole(options))
    library = build_library(compilation.files, compilation.model.name, "verlet")
    program = Program(library, asked.settings(options, compilation))
    t = numpy.array(times())
    states = Rows(t, numpy.column_stack([numpy.cos(t), -numpy.sin(t)]), numpy.zeros((len(t), 2)))
    measure, verlet = Measure(kind, states, numpy.ones(2), 1), ChartedMethod("verlet", 2)

    whole_run = program.run

    def late(method: str, setting: float, cap: float, **more: Any) -> Run:
        return whole_run(method, setting, cap=1e-9 if more["but"]["every"] else cap, **more)

    before = program.point(verlet, 1e-5, 0.0, 60.0, measure)
    assert before.outcome == "done" and before.error < 1e-9
    program.run = late
    after = program.point(verlet, 1e-5, 0.0, 60.0, measure)
    assert (after.outcome, after.error) == ("given up", None)


def test_several_starts_give_a_median_and_a_spread(tmp_path: Path) -> None:
    one = charted(tmp_path)[1]
    told, rows = charted(tmp_path, "--starts", 5)
    assert told["starts"] == 5
    alone = {row["step"]: row["error"] for row in one}
    moved = 0
    for row in rows:
        if row["outcome"] == "done":
            least, error, most = (float(row[name]) for name in ("least", "error", "most"))
            assert 0 < least < error < most
            moved += row["step"] in alone and row["error"] != alone[row["step"]]
            if row["step"] in alone:
                assert least <= float(alone[row["step"]]) <= most
    assert moved > 2
    assert all(row["least"] == row["most"] == "" for row in one)
