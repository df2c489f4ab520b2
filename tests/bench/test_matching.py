"""Matching of final errors: made-up curves whose answer is known."""

import math

import pytest

from bench.matching import curve, quartiles, ratio, seconds_at, spread

# Error 1e-k in 10^(k/4) ms: a method of order 4 at a whole number of steps.
SETTINGS = [10.0**-k for k in range(2, 9)]
ERRORS = [[e, e] for e in SETTINGS]
SECONDS = [[1e-3 * e**-0.25] * 2 for e in SETTINGS]


def test_between_settings_a_power_law_is_met_exactly() -> None:
    points = curve(SETTINGS, ERRORS, SECONDS)
    match = seconds_at(points, 3e-6)
    assert match is not None and not match.bound
    assert match.between == (1e-5, 1e-6)
    assert math.isclose(match.seconds, 1e-3 * 3e-6**-0.25, rel_tol=1e-12)


def test_an_error_that_is_not_reached() -> None:
    assert seconds_at(curve(SETTINGS, ERRORS, SECONDS), 0.99e-8) is None


def test_a_loosest_setting_that_is_better_already_is_a_bound() -> None:
    match = seconds_at(curve(SETTINGS, ERRORS, SECONDS), 0.5)
    assert match is not None and match.bound
    assert math.isclose(match.seconds, SECONDS[0][0])


def test_a_lucky_loose_setting_counts_as_no_better_than_tighter_ones() -> None:
    lucky = [e[:] for e in ERRORS]
    lucky[1] = [1e-9, 1e-9]
    assert seconds_at(curve(SETTINGS, lucky, SECONDS), 1e-8) == seconds_at(
        curve(SETTINGS, ERRORS, SECONDS), 1e-8
    )
    points = curve(SETTINGS, lucky, SECONDS)
    assert points[1].error == ERRORS[2][0] != lucky[1][0]


def test_a_failed_start_spoils_the_median_of_one_but_not_of_three() -> None:
    errors = [[e[0], float("inf"), e[0]] for e in ERRORS]
    seconds = [[t[0]] * 3 for t in SECONDS]
    assert seconds_at(curve(SETTINGS, errors, seconds), 1e-6) is not None
    alone = [[float("inf")] for _ in ERRORS]
    assert seconds_at(curve(SETTINGS, alone, [[t[0]] for t in SECONDS]), 1e-6) is None


def test_ratios_are_formed_round_by_round() -> None:
    """A machine that is twice as slow in one round changes no ratio of that round."""
    drift = [1.0, 2.0, 1.0, 3.0]
    found = ratio([6.0 * d for d in drift], [2.0 * d for d in drift])
    assert (found.median, found.low, found.high) == (3.0, 3.0, 3.0)


def test_quartiles() -> None:
    assert quartiles([1.0, 2.0, 3.0, 4.0, 5.0]) == (2.0, 4.0)
    assert spread([1.0, 2.0, 3.0, 4.0, 5.0]) == pytest.approx(2 / 3)
    assert quartiles([7.0]) == (7.0, 7.0)
