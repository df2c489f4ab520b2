"""The simulated farm keeps what a sweep promises, and loses what theory says."""

import pytest

from bench.scale_farm import Farm, simulated
from conftest import seeds


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_each_shard_is_done_once_or_named(seed: int) -> None:
    farm = Farm(2000, 100.0, 50, 300.0, back=5.0, late=0.3, bad=0.01, seed=seed)
    found = simulated(farm)  # which demands it
    assert found.given_up >= 10 and found.twice > 0


def test_what_is_lost_is_half_a_shard_a_death() -> None:
    """Deaths are a Poisson process: of shards that are short beside the time between them, each
    loses half of one, in the mean of their squares over their mean."""
    farm = Farm(20_000, 100.0, 100, 20_000.0, bad=0.0)
    found = simulated(farm)
    mean, square = 1.5 / 1.3863, 3.75 / 2.7726  # of 2^u, u uniform over -1..1
    expected = farm.seconds * square / mean / 2 / farm.between
    assert found.lost == pytest.approx(expected, rel=0.2)
    assert found.given_up == 0
