"""`pkgen chart`: what it writes, and that its answers are true when they are run again."""

from __future__ import annotations

import csv
import html
import io
import json
import math
import re
import shlex
import statistics
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from conftest import case, ran, written
from pkgen.analysis.chart import chart, points, spectrum, sweep, table
from pkgen.analysis.chart.panel import Curve
from pkgen.analysis.chart.points import ChartedMethod, Point, Track
from pkgen.methods import inline_flags
from pkgen.plot.names import number

PENDULUM = case("chart_pendulum")
METHODS = "euler,verlet,rk4,gauss2,gauss,yoshida4,dop853"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    """A quick chart: what --json says, and the directory with its files."""
    directory = tmp_path_factory.mktemp("chart")
    model = written(directory, PENDULUM)
    # Of eight seconds it needs three; a loaded machine more.
    words = f"--quick --seconds 8 --full --json --methods {METHODS}".split()
    given = ("--set", "w=1.193", "--start", "theta=1.0", "-o", directory)
    done = ran("chart", model, *words, *given)
    return json.loads(done.stdout), directory


def rows_of(directory: Path) -> list[dict[str, str]]:
    with open(directory / "pendulum_chart.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_csv_has_a_row_a_point(made) -> None:
    found, directory = made
    rows = rows_of(directory)
    assert len(rows) == len(found["points"]) > 20
    assert {row["method"] for row in rows} == set(METHODS.split(","))
    for row, point in zip(rows, found["points"], strict=True):
        assert row["status"] == point["status"]
        if point["outcome"] == "done":
            assert float(row["error"]) == point["error"] < 1
            assert float(row["seconds"]) > 0 and int(row["evaluations"]) > 0
            assert float(row["drift(energy)"]) == point["drift(energy)"]
            assert bool(row["step"]) != bool(row["rtol"])


@pytest.mark.parametrize("method, order", [("verlet", 2), ("rk4", 4), ("gauss2", 4)])
def test_the_curves_have_the_order_of_their_methods(made, method: str, order: int) -> None:
    pairs = [
        (math.log(float(row["step"])), math.log(float(row["error"])))
        for row in rows_of(made[1])
        if row["method"] == method and row["outcome"] == "done"
    ]
    pairs = [(h, e) for h, e in pairs if math.log(1e-11) < e < math.log(1e-3)]
    assert len(pairs) >= 3
    slope = statistics.linear_regression(*zip(*pairs, strict=True)).slope
    assert abs(slope - order) < 0.3


def error_of_run(found: dict, words: list[str]) -> float:
    """Of the final state of `pkgen run`, as the chart measures it."""
    done = ran(*words, "--json")
    report = json.loads(done.stdout)["report"]
    exact = zip(
        report["q"] + report["v"],
        found["reference"]["final"],
        found["reference"]["scales"],
        strict=True,
    )
    return max(abs(x - r) / s for x, r, s in exact)


@pytest.mark.needs_addon("pages")
def test_answers_are_commands_that_keep_their_word(made) -> None:
    """Run as the page says, each meets its accuracy; at a much looser setting it does not."""
    found, directory = made
    page = html.unescape((directory / "pendulum_chart.html").read_text(encoding="utf-8"))
    runs = [shlex.split(line)[1:] for line in page.splitlines() if line.startswith("pkgen run")]
    assert [a["accuracy"] for a in found["answers"][::2]] == [1e-3, 1e-6, 1e-9, 1e-12]
    for a in found["answers"][::2]:
        setting = "step" if a["step"] else "rtol"
        (words,) = (w for w in runs if a["method"] in w and repr(a[setting]) in w)
        error = error_of_run(found, words)
        assert 0 < error <= a["accuracy"], a
        assert error == pytest.approx(a["error"], rel=1e-3, abs=1e-15)
        looser = a[setting] * 2.5 if setting == "step" else min(a[setting] * 1e4, 0.9)
        coarse = [repr(looser) if w == repr(a[setting]) else w for w in words]
        assert error_of_run(found, coarse) > a["accuracy"], a


def test_a_worse_method_loses(made) -> None:
    found, _ = made
    named = {a["method"] for a in found["answers"]}
    assert "euler" not in named and "gauss" in named
    steps = {a["accuracy"]: a for a in found["answers"] if a["cheapest_in"] == "work"}
    assert steps[1e-12]["work"] > steps[1e-3]["work"] > 0


def test_points_past_the_limit_are_marked(made) -> None:
    """Verlet is not stable beyond h w = 2; rotations apart, its first step is longer."""
    points = [p for p in made[0]["points"] if p["method"] == "verlet"]
    failed = [p for p in points if p["outcome"] in ("lost", "failed")]  # not those given up: slow
    assert failed and all(p["step"] * 1.193 > 1.0 for p in failed)


class Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name in ("href", "src", "xlink:href"):
                self.links.append(value or "")


@pytest.mark.needs_addon("pages")
def test_the_page_needs_nothing_else(made) -> None:
    text = (made[1] / "pendulum_chart.html").read_text(encoding="utf-8")
    page = Page()
    page.feed(text)
    assert "http" not in text and "@import" not in text and "script" not in page.tags
    assert {"svg", "table", "style"} <= page.tags
    assert page.links and all(link[0] == "#" and link[1:] in page.ids for link in page.links)
    assert len(page.ids) == len(set(page.ids))
    assert all(f">{name}<" in text for name in METHODS.split(","))


def test_the_picture_has_six_methods_at_most_and_the_answers_as_a_sentence(made) -> None:
    found, directory = made
    svg = (directory / "pendulum_chart.svg").read_text(encoding="utf-8")
    named = [name for name in METHODS.split(",") if f">{name}</text>" in svg]
    assert 0 < len(named) <= 6
    said = " ".join(re.findall(r">([^<>]+)</text>", svg))
    assert "Least time for an error of 10⁻³:" in said and "Relative to the largest of" in said
    for answer in found["answers"]:
        if answer["cheapest_in"] == "seconds" and answer["method"]:
            assert f"{number(answer['accuracy'])}: {answer['method']}," in said
            assert answer["method"] in named
    assert (directory / "pendulum_chart.png").read_bytes()[1:4] == b"PNG"


def test_pictures_name_the_model_and_every_curve(made) -> None:
    _, directory = made
    for name in ("pendulum_chart_full", "pendulum_chart_families"):
        svg = (directory / f"{name}.svg").read_text(encoding="utf-8")
        assert "w = 1.193" in svg and "theta(0) = 1" in svg and "10" in svg
        for method in METHODS.split(","):
            assert f">{method}</text>" in svg, (name, method)
        assert (directory / f"{name}.png").read_bytes()[1:4] == b"PNG"


def test_a_reference_that_does_not_hold_cuts_the_chart(tmp_path: Path) -> None:
    """From upright but for the rounding of pi, what __float128 knows of the fall is 1e-6 or so."""
    model = written(tmp_path, PENDULUM.replace("1.1", "3.141592653589793"))
    done = ran(
        "chart", model, "-o", tmp_path, "--points", 8, "--until", 60, "--methods", "gauss", "--json"
    )
    found = json.loads(done.stdout)
    assert found["reference"]["error"] > 1e-13 and 10 < found["reference"]["holds"] < 60
    (last,) = [a for a in found["answers"] if a["accuracy"] == 1e-12 and a["cheapest_in"] == "work"]
    assert last["method"] is None and "reference" in last["reason"]


def test_a_method_named_twice_is_one() -> None:
    assert [m.name for m in chart.methods(["rk4", "gauss", "rk4"])] == ["rk4", "gauss"]
    assert inline_flags(["rk4", "rk4"]) == inline_flags(["rk4"])


def point(setting: float, error: float | None, work: int = 1, status: str = "PK_DONE") -> Point:
    return Point("m", setting, status, "", False, 1.0, error, 1e-6 * work, 1, 0, work, 0, work, 0.0)


RK4 = ChartedMethod("rk4", 4, imaginary=2.8284, real=2.7853)


def test_a_row_of_csv_is_a_point_in_order() -> None:
    track = Track(RK4, (point(0.4, None, 3, "PK_NOT_FINITE"), point(0.2, 1e-2, 20)))
    rows = list(csv.DictReader(io.StringIO(table.as_csv([track]))))
    assert [(r["step"], r["outcome"], r["error"]) for r in rows] == [
        ("0.4", "failed", ""),
        ("0.2", "done", "0.01"),
    ]


def test_limits_are_of_the_nearest_end() -> None:
    found = spectrum.Spectrum(omega=10.0, rho=0.0, until=1.0)
    assert found.limit(RK4) == pytest.approx(0.28284)
    assert replace(found, rho=100.0).limit(RK4) == pytest.approx(0.027853)
    assert found.limit(replace(RK4, imaginary=math.inf)) is None
    assert found.limit(replace(RK4, imaginary=0.0)) is None
    assert found.limit(replace(RK4, flags=("adaptive",))) is None


def test_a_failed_point_stands_where_it_would_have_cost() -> None:
    track = Track(RK4, (point(0.4, None, 3, "PK_NOT_FINITE"), point(0.2, 1e-2, 20)))
    curve = Curve(track, "work", lambda p: p.error, limit=0.25)
    assert curve.failures() == [10.0]
    assert curve.cliff() == pytest.approx((1e-2, 16.0))


def test_steps_go_from_past_the_limit_by_the_measured_slope() -> None:
    found = spectrum.Spectrum(omega=10.0, rho=0.0, until=10.0)
    plan = sweep.Steps(RK4, found, count=14)
    first = plan.first
    assert first == pytest.approx(1.5 * 0.28284, rel=0.05)
    steep = plan.after([point(0.4, 1e-1), point(0.2, 1e-1 / 16)])
    flat = sweep.Steps(RK4, found, count=14).after([point(0.4, 1e-1), point(0.2, 0.5e-1)])
    assert first / steep == pytest.approx(10**0.25, rel=0.05)
    assert steep > 2 * flat


def test_families_follow_from_what_a_method_says_of_itself() -> None:
    of = {
        points.SPLITTING: ChartedMethod("any", 2, ("symplectic",), ("separable",)),
        points.EXPLICIT: ChartedMethod("any", 4),
        points.EMBEDDED: ChartedMethod("any", 5, ("adaptive",)),
        points.SYMMETRIC: ChartedMethod("any", 4, ("implicit", "symmetric")),
        points.IMPLICIT_ADAPTIVE: ChartedMethod("any", 16, ("implicit", "adaptive")),
        points.DISSIPATIVE: ChartedMethod("any", 5, ("implicit",)),
        points.FOREIGN: ChartedMethod("gsl_any", 5, ("adaptive",)),
        points.EXACT: ChartedMethod("any", 0, ("exact",), ("affine",)),
        points.PEER: ChartedMethod("gsl_any", 5, ("adaptive",), peer="package 1.0"),
    }
    assert {family: m.family for family, m in of.items()} == {f: f for f in points.FAMILIES}


def test_steps_are_as_long_as_they_may_be(pkgen, tmp_path: Path) -> None:
    """Of a method that is exact on a linear system one step is all it takes."""
    model = written(
        tmp_path, "model springs\ncoord x\nkinetic x'^2/2\npotential 8*x^2\nstart x = 1\n"
    )
    words = ("--methods", "exponential", "--until", 30, "--seconds", 2, "--points", 5)
    assert pkgen("chart", model, *words, "-o", tmp_path).returncode == 0
    with (tmp_path / "springs_chart.csv").open() as file:
        steps = [float(row["step"]) for row in csv.DictReader(file)]
    assert max(steps) == 30 and min(steps) < 1
