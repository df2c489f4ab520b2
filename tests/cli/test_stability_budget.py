"""What a map may take: fewer points and methods, said; random costs first."""

from __future__ import annotations

import json
import random
import time

import pytest

from conftest import ROOT, seeds
from pkgen.__main__ import main
from pkgen.analysis.stability import budget


@pytest.mark.parametrize("seed", seeds(range(3), 47))
def test_random_costs_fit(seed: int) -> None:
    r = random.Random(seed)
    costs = {name: 10 ** r.uniform(-5, 1) for name in "abcdef"[: r.randint(1, 6)]}
    up, across, seconds = r.randint(1, 64), r.randint(2, 64), 10 ** r.uniform(0, 2)
    cut = budget.cut(costs, up, across, seconds)
    least = min(up, budget.LEAST_UP) * min(across, budget.LEAST_ACROSS)
    taken = sum(costs[name] for name in cut.methods)
    assert cut.methods and cut.up <= up and cut.across <= across
    # Beyond the time only where one method has the least that there is; a bound of one kind costs.
    slack = max(1, budget.LEAST_UP, budget.LEAST_ACROSS)
    assert cut.up * cut.across * taken <= slack * seconds or len(cut.methods) == 1
    if up * across * sum(costs.values()) <= seconds:
        assert (cut.up, cut.across, len(cut.methods)) == (up, across, len(costs))
    left = [costs[name] for name in costs if name not in cut.methods]
    assert all(x >= costs[name] for x in left for name in cut.methods)
    assert not left or least * sum(costs.values()) > seconds
    assert bool(budget.told(budget.Cut(up, across, tuple(costs)), cut, seconds)) == (
        (cut.up, cut.across, cut.methods) != (up, across, tuple(costs))
    )


def test_fewer_values_keep_the_last() -> None:
    values = tuple(float(k) for k in range(1, 13))
    assert budget.fewer(values, 12) == values
    assert budget.fewer(values, 4) == (3.0, 6.0, 9.0, 12.0)


def test_a_long_chain_is_cut_and_says_so(tmp_path, capsys) -> None:
    began = time.process_time()
    model = ROOT / "models/chains/harmonic_fixed.lag"
    asked = ("--quick", "--seconds", "3", "--json", "-o", str(tmp_path))
    assert main(["stability", str(model), *asked]) == 0
    found = json.loads(capsys.readouterr().out)
    assert time.process_time() - began < 30  # without, 60 and more; on two cores some 10
    said = " ".join(found["remarks"])
    assert "to be done in 3 s the map has" in said and "--seconds 30 allows for more" in said
    assert len(found["rows"]) < 12 and found["points"]
