"""Whether a chart's answers are the cheapest: each beside a much denser scan of every method.

`python -m bench answers [--only TEXT] [--seconds S] [--docs]`

A method's steps (tolerances) go from loose to tight, a cost some 3% above the last, for as long as
it may be cheaper than the answer. A point counts where it and what is up to 13% finer (a tolerance:
down to 0.3 of it) keep the accuracy. Evaluations are the same each time; what may be faster than
the answer is timed again in turns with it, and medians compared. Of the chart its reference is
taken, and its answers, which are what is judged: one that costs a tenth more than the cheapest
point of the scan fails, and so does a "none" beside a point that keeps the accuracy.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from dataclasses import dataclass

from pkgen.__main__ import parser_of
from pkgen.analysis.chart import chart as charts
from pkgen.analysis.chart.answer import Answer
from pkgen.analysis.chart.chart import Chart
from pkgen.analysis.chart.measure import Program
from pkgen.analysis.chart.points import ChartedMethod, Point
from pkgen.cli.chart import _effort
from pkgen.cli.compilation import compile_within_limits
from pkgen.run.build import build_library
from pkgen.scenes import run_settings as parsing
from pkgen.scenes.compile_plan import whole
from pkgen.system.progress import unseen

from . import machine
from .chosen import chosen
from .models import ROOT
from .tables import table

WITHIN = 1.10
PAGE = ROOT / "docs/dev/results/answers.md"
MARK = "<!-- python -m bench answers --docs -->\n"
NEXT = {True: 1 / 1.03, False: 1 / 1.2}  # of a step, of a tolerance, to the next one
FINER = {True: 0.87, False: 0.3}
LOOSEST = {True: 0.1, False: 1e-2}  # of the time to go
ROUNDS, LAP = 9, 0.01
TIGHTEST = 3e-15
CAP = 0.2  # seconds of a point: slower ones are no rivals


@dataclass(frozen=True)
class Case:
    name: str
    model: str
    words: tuple[str, ...] = ()


OURS = "bench/lag/answers"
CASES = [
    *(
        Case(name, f"models/{name}.lag")
        for name in (
            "bead_on_hoop", "coupled_oscillators", "double_pendulum", "elastic_pendulum",
            "heavy_top",
        )
    ),
    # Of no model of the collection: what charts answer was not made with them.
    Case("Kepler, e = .9", f"{OURS}/kepler.lag", ("--until", "62")),
    Case("stiff spring pendulum", f"{OURS}/stiff_spring.lag", ("--until", "10")),
    Case("van der Pol, mu = 5", f"{OURS}/van_der_pol.lag", ("--until", "30")),
    Case("Duffing, driven", f"{OURS}/duffing.lag", ("--until", "40")),
    Case("Arenstorf", "bench/lag/published/arenstorf.lag", ("--until", "17.06521656015796")),
    Case("elastic, k = 9", "models/elastic_pendulum.lag", ("--set", "k=9", "--until", "20")),
    Case("ion in a Penning trap", f"{OURS}/penning.lag", ("--until", "30")),
    Case("double pendulum on a cart", f"{OURS}/cart.lag", ("--until", "10")),
]  # fmt: skip


@dataclass(frozen=True)
class Judged:
    answer: Answer
    scanned: int
    rival: Point | None  # the cheapest of the scan, if it is cheaper than the answer
    ratio: float  # the answer's cost over the rival's

    @property
    def well(self) -> bool:
        return self.ratio <= WITHIN


def measured(case: Case, seconds: float) -> tuple[Chart, Program, list[ChartedMethod]]:
    words = [str(ROOT / case.model), "--seconds", str(seconds), "-o", "unused", *case.words]
    options = parser_of("chart").parse_args(words)
    compilation = compile_within_limits(options, unroll=None, use=whole(options))
    settings = parsing.settings(options, compilation)
    methods = charts.methods(None)
    chart = charts.measure(compilation, settings, methods, _effort(options), unseen)
    program = build_library(compilation.files, compilation.model.name, *(m.name for m in methods))
    able = [track.method for track in chart.tracks]
    return chart, Program(program, settings), able


class Scan:
    """Points of one motion, none measured twice."""

    def __init__(self, program: Program, chart: Chart):
        self.program, self.chart = program, chart
        self.known: dict[tuple[str, float], Point] = {}

    def point(self, method: ChartedMethod, setting: float, lap: float = 0.0) -> Point:
        measure = self.chart.reference.measure(self.chart.kind)
        if method.fixed:
            setting = self.chart.until / math.ceil(self.chart.until / setting * (1 - 1e-12))
        key = method.name, setting
        if lap or key not in self.known:
            found = self.program.point(method, setting, lap, CAP, measure)
            if lap:
                return found
            self.known[key] = found
        return self.known[key]

    def all_of(self, method: ChartedMethod, most: dict[str, float]) -> list[Point]:
        """From loose to tight, until both costs are past the most that matters, and a little more
        to tell luck."""
        setting, over, found = (
            LOOSEST[method.fixed] * (self.chart.until if method.fixed else 1),
            0,
            [],
        )
        while over < math.log(FINER[method.fixed]) / math.log(NEXT[method.fixed]) + 1:
            point = self.point(method, setting)
            if point.slow or point.refused or (not method.fixed and setting < TIGHTEST):
                break
            if not found or found[-1].setting != point.setting:
                found.append(point)
            past = all((point.cost(axis) or 0.0) > most[axis] for axis in most)
            over = over + 1 if past and point.arrived else 0
            setting = min(setting * NEXT[method.fixed], point.setting * (1 - 1e-9))
        return found


def keeps(point: Point, accuracy: float) -> bool:
    return point.good and point.error <= accuracy


def robust(points: list[Point], accuracy: float, share: float) -> list[Point]:
    found = []
    last = points[-1].setting if points else 0.0
    for k, p in enumerate(points):
        if last > share * p.setting:
            break  # nothing finer to tell luck by
        near = [x for x in points[k:] if x.setting >= share * p.setting] + points[k + 1 : k + 3]
        if all(keeps(x, accuracy) for x in near):
            found.append(p)
    return found


def judged(case: Case, seconds: float) -> list[Judged]:
    chart, program, methods = measured(case, seconds)
    answers = [a for a in chart.answers if a.accuracy > 10 * chart.reference.error]
    most = {
        axis: max(a.point.cost(axis) if a.point else 1e6 for a in answers if a.axis == axis)
        for axis in ("seconds", "work")
    }
    scan = Scan(program, chart)
    points = {m.name: (m, scan.all_of(m, most)) for m in methods}
    return [_judge(scan, a, points) for a in answers]


def _judge(
    scan: Scan, answer: Answer, points: dict[str, tuple[ChartedMethod, list[Point]]]
) -> Judged:
    axis = answer.axis
    count = sum(len(found) for _, found in points.values())
    able = [p for m, f in points.values() for p in robust(f, answer.accuracy, FINER[m.fixed])]
    if answer.point is None:
        return Judged(answer, count, able[0] if able else None, math.inf if able else 1.0)
    mine = answer.point.cost(axis)
    rivals = sorted(
        (
            p
            for p in able
            if p.cost(axis) and p.cost(axis) < mine * (1.5 if axis == "seconds" else 1)
        ),
        key=lambda p: p.cost(axis),
    )
    if not rivals:
        return Judged(answer, count, None, 1.0)
    if axis == "work":
        return Judged(answer, count, rivals[0], mine / rivals[0].cost(axis))
    runs = [(answer.method, answer.point)] + [(points[p.method][0], p) for p in rivals[:6]]
    times: list[list[float]] = [[] for _ in runs]
    for _ in range(ROUNDS):
        for k, (method, p) in enumerate(runs):
            times[k].append(scan.point(method, p.setting, LAP).seconds)
    own, *others = map(statistics.median, times)
    best = min(range(len(others)), key=others.__getitem__)
    return Judged(answer, count, runs[best + 1][1], max(1.0, own / others[best]))


HEAD = ("model", "accuracy", "by", "answer", "its cost", "points", "cheapest of them", "ratio")


def cells(case: Case, one: Judged) -> tuple[str, ...]:
    def named(p: Point | None) -> str:
        return f"{p.method} {p.setting:.4g}" if p else "none cheaper"

    a = one.answer
    cost = "" if a.point is None else f"{a.point.cost(a.axis):.4g}"
    said = named(a.point) if a.point else "none"
    return (
        *(case.name, f"{a.accuracy:.0e}", "time" if a.axis == "seconds" else "evaluations", said),
        *(cost, f"{one.scanned:,}", named(one.rival), f"{one.ratio:.2f}"),
    )


def summary(found: list[Judged]) -> str:
    """How many are right, by evaluations and by time."""
    told = []
    for axis, name in (("work", "evaluations"), ("seconds", "time")):
        mine = [one for one in found if one.answer.axis == axis]
        well = sum(one.well for one in mine)
        told.append(f"by {name} {well} of {len(mine)} within 10%")
    return "; ".join(told)


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench answers", description=__doc__)
    parser.add_argument("--only", default="", help="motions whose name has this")
    parser.add_argument("--seconds", type=float, default=60.0, help="of a chart's measuring")
    parser.add_argument("--docs", action="store_true", help="write its page")
    arguments = parser.parse_args(words)
    rows, found, failed, began = [], [], [], time.monotonic()
    for case in chosen(CASES, arguments.only, lambda case: case.name):
        for one in judged(case, arguments.seconds):
            found.append(one)
            rows.append(cells(case, one))
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
            if not one.well:
                failed.append(" | ".join(rows[-1]))
    text = f"{summary(found)}; {time.monotonic() - began:.0f} s.\n\n{table(HEAD, rows)}\n"
    print(text)
    if arguments.docs:
        before = PAGE.read_text().partition(MARK)[0]
        here = "; ".join(machine.describe().lines())
        PAGE.write_text(f"{before}{MARK}\n{here}\n\n{text}")
    for why in failed:
        print(f"bench: failed: {why}", file=sys.stderr)
    return 1 if failed else 0
