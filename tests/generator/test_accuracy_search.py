"""The search of a setting, the table of candidates, and how far a reference is trusted, on methods
that are made up: errors and times are formulas."""

import math
from dataclasses import dataclass

import pytest

from pkgen.analysis.chart.points import ChartedMethod
from pkgen.analysis.choose import reference, search
from pkgen.analysis.choose.candidates import TABLE, Candidate, candidates
from pkgen.analysis.choose.trials import DENSE, LAND, Trial


def method(name: str, order: int, *flags: str, requires: tuple[str, ...] = ()) -> ChartedMethod:
    return ChartedMethod(name, order, flags, requires)


FIXED = Candidate(method("rk4", 4), LAND, "")
ADAPTIVE = Candidate(method("dop853", 8, "adaptive"), LAND, "")


def trial(candidate: Candidate, setting: float, error: float, seconds: float, **more) -> Trial:
    usual = {
        "refused": False,
        "reason": "",
        "arrived": True,
        "slow": False,
        "t": 10.0,
        "took": seconds,
        "steps": 1000,
        "compared": 11,
        "holds": 10.0,
    }
    said = {**usual, **more}
    return Trial(candidate.name, candidate.rows, setting, error=error, seconds=seconds, **said)


@dataclass
class Made:
    """A method whose error is c setting^power, and its time in steps."""

    c: float
    power: float
    seconds: float = 1e-6
    tries: int = 0

    def __call__(self, candidate: Candidate, setting: float) -> Trial:
        self.tries += 1
        cost = 1 / setting if candidate.method.fixed else setting ** (-1 / 8)
        return trial(candidate, setting, self.c * setting**self.power, self.seconds * cost)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("power", [3.5, 4.0, 4.6])
def test_a_fixed_step_is_the_longest_that_keeps_the_accuracy(accuracy, power) -> None:
    made = Made(2.0, power)
    found = search.loosest(FIXED, accuracy, 0.5, 0.5, math.inf, made)
    count = math.ceil(0.5 / (accuracy / 2.0) ** (1 / power))
    assert found.kept is not None and found.kept.error <= accuracy
    assert count <= round(0.5 / found.kept.setting) <= 1.06 * count + 1
    assert made.tries <= search.TRIALS


@pytest.mark.parametrize("accuracy", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize(("c", "power"), [(30.0, 1.0), (0.02, 1.0), (5.0, 0.8)])
def test_a_tolerance_is_nearly_the_loosest(accuracy, c, power) -> None:
    found = search.loosest(ADAPTIVE, accuracy, accuracy, 0.5, math.inf, Made(c, power))
    loosest = min((accuracy / c) ** (1 / power), search.LOOSEST)
    assert found.kept is not None and found.kept.error <= accuracy
    assert found.kept.setting > loosest / 1.6


def test_a_method_that_would_be_slower_is_given_up_by_a_trial() -> None:
    made = Made(2.0, 4.0)
    needed = made(FIXED, 0.5 / math.ceil(0.5 / (1e-9 / 2.0) ** 0.25)).seconds
    slower = search.loosest(FIXED, 1e-9, 0.5, 0.5, needed / 4, made)
    assert slower.kept is None and slower.verdict == "slower"
    # Not by the error of a first step so long that it says nothing.
    steep = Made(900.0, 12.0)
    faster = search.loosest(FIXED, 1e-9, 0.5, 0.5, 2 * steep(FIXED, 0.1).seconds, steep)
    assert faster.kept is not None and faster.kept.setting == pytest.approx(0.1)


def test_a_first_step_whose_equations_take_long_is_not_the_last() -> None:
    implicit = Candidate(method("radau5", 5, "implicit"), LAND, "")

    def made(candidate: Candidate, setting: float) -> Trial:
        return trial(candidate, setting, setting**5, 1.0 if setting > 0.2 else 1e-3 / setting)

    found = search.loosest(implicit, 1e-6, 0.5, 0.5, 0.05, made)
    assert found.kept is not None and 0.04 < found.kept.setting < 0.064
    assert search.loosest(FIXED, 1e-6, 0.5, 0.5, 0.05, made).verdict == "slower"


def test_a_run_without_any_error_says_nothing_of_how_errors_fall() -> None:
    errors = iter([1e-2, 1e-3, 0.0, *[1e-7] * search.TRIALS])

    def made(candidate: Candidate, setting: float) -> Trial:
        return trial(candidate, setting, next(errors), 1e-3)

    assert search.loosest(FIXED, 1e-6, 0.5, 0.5, math.inf, made).kept is not None


def test_what_is_refused_or_never_arrives_says_why() -> None:
    def refused(candidate: Candidate, setting: float) -> Trial:
        return trial(
            candidate,
            setting,
            math.inf,
            math.inf,
            refused=True,
            reason="needs da/dq",
            arrived=False,
        )

    def broken(candidate: Candidate, setting: float) -> Trial:
        return trial(
            candidate,
            setting,
            math.inf,
            math.inf,
            reason="no longer finite",
            arrived=False,
        )

    assert search.loosest(FIXED, 1e-6, 0.5, 0.5, math.inf, refused).verdict == "needs da/dq"
    assert search.loosest(FIXED, 1e-6, 0.5, 0.5, math.inf, broken).verdict == "no longer finite"


@dataclass(frozen=True)
class Structure:
    smooth: bool = True
    separable: bool = True
    variational: bool = True
    affine: bool = False

    @property
    def smooth_in_pieces(self) -> bool:
        return self.smooth


KNOWN = [
    method("exponential", 0, requires=("affine",)),
    method("gauss", 16, "adaptive", "implicit", "dense", requires=("smooth",)),
    method("dop853", 8, "adaptive", "dense"),
    method("blanes_moan6", 6, requires=("mass_constant", "separable")),
    method("radau", 5, "adaptive", "implicit"),
]


@dataclass(frozen=True)
class Separable(Structure):
    mass_constant: bool = True


def names(facts: Structure) -> list[str]:
    return list(dict.fromkeys(c.name for c in candidates(facts, KNOWN)))


def test_candidates_are_those_whose_facts_hold() -> None:
    assert names(Separable()) == ["gauss", "dop853", "blanes_moan6"]
    assert names(Separable(affine=True))[0] == "exponential"
    assert "gauss" not in names(Separable(smooth=False))
    assert "blanes_moan6" not in names(Separable(separable=False))
    assert names(Separable(variational=False))[-1] == "radau"


def test_every_method_of_the_table_exists_and_none_stands_twice() -> None:
    lines = [(line.method, line.rows) for line in TABLE]
    assert len(set(lines)) == len(lines)
    assert {rows for _, rows in lines} == {LAND, DENSE}


def test_a_linear_motion_is_exact_by_its_exponential_unless_there_are_events() -> None:
    linear = Structure(affine=True, variational=False)
    assert reference.methods(linear, events=False) == ("exponential", "gauss", "radau", "dop853")
    assert reference.methods(linear, events=True) == ("gauss", "radau", "dop853")
    assert reference.methods(Structure(smooth=False, affine=True), False) == ("dop853", "dopri5")


def test_a_part_of_a_scene_is_of_whole_intervals() -> None:
    assert reference.part(100.5, 1.0) == (90.0, 0.0)
    span, interval = reference.part(3.0, 100.0)
    assert interval > 0 and 100.0 / interval == 2 ** round(math.log2(100.0 / interval))
    assert 8 <= round(span / interval) == span / interval and span <= 3.0


def test_a_reference_is_judged_by_its_own_method_unless_another_denies_it() -> None:
    def beside(name: str, *columns: float) -> Trial:
        candidate = Candidate(method(name, 8, "adaptive"), LAND, "")
        return trial(candidate, 1e-14, max(columns), 1.0, columns=columns)

    own = beside("gauss", 1e-14)
    assert reference._judge(own, beside("dop853", 1e-12), (), 1e-9) is own
    wrong = beside("dop853", 1e-6)
    assert reference._judge(own, wrong, (), 1e-9) is wrong
    better = beside("dop853", 1e-15)
    assert reference._judge(own, better, (), 1e-9) is better
    # Nor by one that is itself no better than that.
    radau = Candidate(method("radau", 5, "adaptive"), LAND, "")
    coarse = trial(radau, 1e-12, 2e-11, 1.0, columns=(2e-11,))
    assert reference._judge(own, coarse, (), 1e-12) is own


def test_only_what_is_tiny_beside_others_is_taken_for_zero() -> None:
    candidate = Candidate(method("gauss", 16, "adaptive"), LAND, "")
    chaotic = trial(candidate, 1e-14, 0.5, 1.0, columns=(0.5, 1e-14, 0.7))
    assert reference._noise([chaotic], (3.0, 2.0, 1e-15)) == (2,)
    assert reference._noise([chaotic], (3.0, 2.0, 1e-3)) == ()
    # Of runs that are the same in all digits another one has to tell.
    same = trial(candidate, 1e-15, 0.0, 1.0, columns=(0.0, 0.0, 0.0))
    assert reference._noise([same, chaotic], (3.0, 2.0, 1e-15)) == (2,)
    assert reference._noise([same], (3.0, 2.0, 1e-15)) == ()
