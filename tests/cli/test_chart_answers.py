"""What a chart answers, over methods whose errors are given: beside a scan of every setting."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from conftest import seeds
from pkgen.analysis.chart import answer, scale
from pkgen.analysis.chart.points import ChartedMethod, Point, Track
from pkgen.analysis.chart.sweep import Effort

UNTIL = 10.0
Error = Callable[[float], float]


@dataclass
class Invented:
    """A bench where a step costs one evaluation, a tolerance tol^(-1/order) of them, and a second
    is `pace` evaluations; `noise` times a second is what else the machine does."""

    errors: dict[str, Error]
    pace: dict[str, float]
    floor: float = 1e-18
    until: float = UNTIL
    effort: Effort = field(default_factory=lambda: Effort(16, 0.0, 60.0))
    noise: float = 0.0
    asked: int = 0
    random: random.Random = field(default_factory=lambda: random.Random(1))

    def point(self, method: ChartedMethod, setting: float, cap: float, lap: float = 0.0) -> Point:
        self.asked += 1
        error = self.errors[method.name](setting)
        steps = UNTIL / setting if method.fixed else 30 * setting ** (-1 / method.order)
        work = math.ceil(steps * (1 - 1e-12))
        seconds = work / self.pace[method.name] * (1 + self.noise * self.random.random())
        told = method.name, setting, "PK_DONE", "", False, UNTIL, error, seconds
        return Point(
            *told, steps=1, rejections=0, evaluations=work, jacobians=0, work=work, took=1e-4
        )


def swept(bench: Invented, methods: list[ChartedMethod]) -> list[Track]:
    """Each from coarse to fine, steps a quarter shorter and tolerances of a fifth."""
    tracks = []
    for m in methods:
        settings = (
            [UNTIL / round(10 * 1.33**k) for k in range(24)]
            if m.fixed
            else [10 ** (-2 - 0.7 * k) for k in range(18)]
        )
        tracks.append(Track(m, tuple(bench.point(m, s, 1.0) for s in settings)))
    return tracks


def invented(seed: int) -> tuple[Invented, list[ChartedMethod]]:
    """Five methods: errors of powers of the step with lobes, zeros and round-off."""
    chance = random.Random(seed)
    methods, errors, pace = [], {}, {}
    for k in range(5):
        order = chance.choice([2, 4, 5, 6, 8, 10])
        flags = ("adaptive",) if chance.random() < 0.4 else ()
        m = ChartedMethod(f"m{k}", order, flags)
        size, wave, bed = (
            10 ** chance.uniform(-2, 2),
            chance.uniform(1, 20),
            chance.choice([chance.uniform(-16, -13), -11]),
        )
        salt = chance.randrange(10**6)

        def error(x: float, m=m, size=size, wave=wave, bed=10**bed, salt=salt) -> float:
            smooth = size * (x**m.order if m.fixed else x)
            lobes = abs(math.cos(wave * math.log(x))) + 0.3
            rounding = bed * random.Random(hash((round(x, 15), salt))).uniform(0.05, 1.0)
            return smooth * lobes + rounding

        methods.append(m)
        errors[m.name], pace[m.name] = error, 10 ** chance.uniform(5, 6)
    return Invented(errors, pace), methods


def dense(bench: Invented, method: ChartedMethod, accuracy: float, axis: str) -> float:
    """The least cost of what keeps the accuracy with all that is so little finer: a scan."""
    share = 0.87 if method.fixed else 0.3
    settings = (
        [UNTIL / n for n in dict.fromkeys(round(10 * 1.02**k) for k in range(465))]
        if method.fixed
        else [10 ** (-2 - 0.04 * k) for k in range(325)]
    )
    noise, bench.noise = bench.noise, 0.0
    found = [bench.point(method, s, 1.0) for s in settings]
    bench.noise = noise
    best, kept = math.inf, 0
    for k, p in enumerate(found):
        near = [q for q in found[k:] if q.setting >= share * p.setting * (1 - 1e-9)]
        if all(q.error <= accuracy for q in near) and found[-1].setting < share * p.setting:
            best, kept = min(best, p.cost(axis)), kept + 1
    return best


@pytest.mark.parametrize("seed", seeds(range(3), 5))
def test_an_answer_is_the_cheapest_of_a_dense_scan(seed: int) -> None:
    bench, methods = invented(seed)
    found, tracks = answer.answers(bench, swept(bench, methods))
    marked = {(p.method, p.setting): p.lucky for t in tracks for p in t.points}
    for a in found:
        least = min(dense(bench, m, a.accuracy, a.axis) for m in methods)
        if a.point is None:
            assert least == math.inf or least > 1e4, a
            continue
        assert a.point.error <= a.accuracy
        assert a.point.cost(a.axis) <= 1.15 * least, (a, least)
        for t in tracks:
            for p in t.points:
                if p.error <= a.accuracy and p.cost(a.axis) < a.point.cost(a.axis):
                    assert marked[p.method, p.setting]
    assert any(a.point for a in found)


def test_a_lone_lucky_point_is_no_answer_and_says_so() -> None:
    """Error 1e-4 everywhere but at one step of the sweep."""
    method = ChartedMethod("m", 4)
    lucky = UNTIL / 13
    bench = Invented({"m": lambda h: 1e-14 if math.isclose(h, lucky) else 1e-4}, {"m": 1e6})
    tracks = [Track(method, tuple(bench.point(method, UNTIL / n, 1.0) for n in (10, 13, 18, 24)))]
    found, tracks = answer.answers(bench, tracks)
    assert [a.point is None for a in found] == [False, False] + 6 * [True]
    assert all("luck" in a.reason and "m, with 1.0e-14" in a.reason for a in found[2:])
    assert [p.setting for p in tracks[0].points if p.lucky] == [lucky]


def test_an_accuracy_past_the_reference_is_not_told() -> None:
    method = ChartedMethod("m", 4)
    bench = Invented({"m": lambda h: 1e-15}, {"m": 1e6}, floor=3e-13)
    found, _ = answer.answers(bench, swept(bench, [method]))
    assert [bool(a.point) for a in found] == [True] * 6 + [False] * 2
    assert all("cannot be told" in a.reason for a in found[6:])


def test_none_names_the_most_accurate() -> None:
    method = ChartedMethod("m", 2)
    bench = Invented({"m": lambda h: 1e-5 + h**2}, {"m": 1e6})
    found, _ = answer.answers(bench, swept(bench, [method]))
    assert [bool(a.point) for a in found] == [True, True] + 6 * [False]
    assert "none; the most accurate is m, with 1." in found[2].reason


def test_a_sweep_cut_short_goes_on() -> None:
    """Where nothing has the accuracy yet but errors still fall."""
    method = ChartedMethod("m", 4)
    bench = Invented({"m": lambda h: h**4}, {"m": 1e6})
    tracks = [Track(method, tuple(bench.point(method, UNTIL / n, 1.0) for n in (20, 40, 80, 4000)))]
    found, _ = answer.answers(bench, tracks)
    assert found[6].point is not None and found[6].point.error <= 1e-12


def cut_short(seconds: float) -> tuple[list[answer.Answer], list[Track]]:
    """Of a slow method that was swept to its end, a fast one of one point and one that is dear."""
    methods = [ChartedMethod("slow", 4), ChartedMethod("fast", 8, ("adaptive",))]
    methods.append(ChartedMethod("dear", 4))
    errors = {"slow": lambda h: h**4, "fast": lambda tol: tol, "dear": lambda h: h**4}
    pace = {"slow": 1e6, "fast": 1e6, "dear": 1e2}
    bench = Invented(errors, pace, effort=Effort(16, 0.0, seconds))
    first = [Track(m, (bench.point(m, 0.01, 1.0),)) for m in methods[1:]]
    return answer.answers(bench, [*swept(bench, methods[:1]), *first])


def test_a_method_that_was_cut_short_is_taken_on_where_it_could_be_cheaper() -> None:
    found, _ = cut_short(60.0)
    assert [a.method.name for a in found[2:]] == ["fast"] * 6
    assert not any(a.unmeasured for a in found)


def test_an_answer_names_what_there_was_no_time_for_and_could_be_cheaper() -> None:
    found, _ = cut_short(0.0)
    assert [a.method.name for a in found[2:6]] == ["slow"] * 4
    assert all("fast" in a.unmeasured for a in found[2:])
    assert not any("dear" in a.unmeasured for a in found[:6] if a.axis == "seconds")


def test_the_budget_of_a_chart_is_of_the_processor() -> None:
    """What the machine does besides takes none of it."""
    effort = Effort(16, 0.0, 60.0)
    left = effort.left()
    time.sleep(0.3)
    assert left - effort.left() < 0.1


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_times_with_noise_are_timed_again(seed: int) -> None:
    """By a third of the time more at random: the answer's method is right to 10% of the truth."""
    bench, methods = invented(seed)
    bench.noise = 0.33
    found, _ = answer.answers(bench, swept(bench, methods))
    for a in found:
        if a.axis == "seconds" and a.point is not None:
            least = min(dense(bench, m, a.accuracy, a.axis) for m in methods)
            true = a.point.work / bench.pace[a.point.method]
            assert true <= 1.2 * least and a.point.seconds <= 1.34 * true


def test_without_time_the_next_finer_point_judges() -> None:
    method = ChartedMethod("m", 4)
    errors = {0.5: 1e-7, 0.25: 1e-4, 0.125: 1e-8, 0.0625: 1e-9}
    bench = Invented({"m": errors.__getitem__}, {"m": 1e6}, effort=Effort(16, 0.0, 0.0))
    tracks = [Track(method, tuple(bench.point(method, h, 1.0) for h in errors))]
    found, tracks = answer.answers(bench, tracks)
    assert [a.point.setting for a in found[2:4]] == [0.125] * 2
    assert [p.lucky for p in tracks[0].points] == [True, False, False, False]


def test_tolerances_of_an_answer_have_two_digits() -> None:
    assert scale.two_digits(6.039e-6) == 6.0e-6
    assert scale.two_digits(9.99e-6) == 9.9e-6
    assert scale.two_digits(1e-9) == 1e-9
