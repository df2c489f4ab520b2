"""The published problems: runs end where they are claimed to; exact ends, found in two ways."""

import json
import math

import pytest

from bench import published
from bench import published_by_hand as by_hand

QUICK = {"andrews", "orbits D5", "arenstorf loose"}
BY_HAND = (
    ("andrews published", "andrews", 0.03, 200, 1e-13),
    ("outer_planets book", "planets", 200_000, 1500, 1e-13),
    ("stiff_pendulum published", "stiff_pendulum", 10, 6000, 1e-12),
    ("fpu_stiff published", "fpu_stiff", 200, 14000, 1e-11),
)


def marked(problem: published.Problem):
    quick = {problem.model, f"{problem.model} {problem.scene}"} & QUICK
    return pytest.param(problem, id=problem.name, marks=[] if quick else [pytest.mark.long])


@pytest.mark.parametrize("problem", [marked(problem) for problem in published.PROBLEMS])
def test_each_ends_where_it_is_claimed_to(problem: published.Problem) -> None:
    found = published.run(problem, runs=1)
    assert 0 < found.error <= problem.claim
    if problem.published:
        assert found.off < 1e-5


def test_a_wrong_end_is_off() -> None:
    at = published.kepler(0.9)(20)
    assert published.difference(at, published.kepler(0.9)(20 + 1e-9), each=False) > 1e-10
    assert published.difference([1, 2, 3], [1, 2.5], each=True) == 0.2
    assert published.pendulum(0) == pytest.approx([1, 0], abs=1e-15)


def test_exact_ends_are_there_for_all_without_a_closed_form() -> None:
    kept = json.loads(published.EXACT.read_text(encoding="utf-8"))
    needed = {p.exact: p.rows for p in published.PROBLEMS if p.closed is None}
    assert {name: len(rows) for name, rows in kept.items()} == needed


@pytest.mark.parametrize(
    ("name", "what", "until", "steps", "allowed"),
    [pytest.param(*x, marks=[] if x[1] == "planets" else [pytest.mark.long]) for x in BY_HAND],
)
def test_the_exact_end_again_by_hand(name, what, until, steps, allowed) -> None:
    kept = json.loads(published.EXACT.read_text(encoding="utf-8"))[name]
    end = [float(x) for x in getattr(by_hand, what)(until, steps)]
    assert published.difference(end, kept[0], each=False) < allowed


def test_the_governor_again_by_hand() -> None:
    """After one of the ten seconds, which explicit steps need 10 s of Python for."""
    kept = json.loads(published.EXACT.read_text(encoding="utf-8"))["governor published"]
    end = [float(x) for x in by_hand.governor(1, 9000)]
    assert published.difference(end, kept[-1], each=False) < 1e-13


def test_the_point_of_a03_again_by_hand() -> None:
    kept = json.loads(published.EXACT.read_text(encoding="utf-8"))["andrews a03"]
    beta = float(by_hand.andrews(0.05, 400)[0])
    end = [0.007 * math.cos(beta), 0.007 * math.sin(beta)]
    assert published.difference(end, kept[0], each=False) < 1e-13
