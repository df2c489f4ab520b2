"""Runs of chains of links kept as loops, beside the same with all members written out."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest
from test_loops_features import both, rows

from conftest import case, ran, seeds

sys.path.insert(0, str(Path(__file__).parents[1] / "generator"))
from carried_models import links

__all__ = ["both"]


@pytest.mark.parametrize("seed", seeds([3, 0, 1], 9))
def test_chains_with_states_and_events_are_those_written_out(seed: int, both) -> None:
    dice = random.Random(seed)
    text = links(dice, states=True).replace("size N = 5", "size N = 9")
    text += "event swings: q[3] - 1 either\nevent lengthens: tip - 0.5 either\n"
    method = dice.choice((("dop853", "--rtol", "1e-11"), ("rk4", "--step", "0.002"), ("gauss",)))
    words = ("--until", 0.4, "--every", 0.1, "--method", *method)
    (loops, told), (written, said) = both(text, *words)
    assert len(loops) == len(written) == 5
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9), text
    for one, other in zip(told["events"], said["events"], strict=True):
        assert one["times"] == pytest.approx(other["times"], abs=1e-7), text


HANGING = case("hanging")


def test_members_of_an_ensemble_are_single_runs(pkgen, tmp_path: Path) -> None:
    model, table = tmp_path / "hanging.lag", tmp_path / "members.csv"
    model.write_text(HANGING)
    table.write_text("k,l[3],theta[20]\n1,0.1,0.3\n2,0.02,-0.3\n3,0.05,0\n")
    common = ("--until", 1, "--every", 0.5, "--method", "rk4", "--step", "0.005")
    done = ran("run", model, *common, "--ensemble", table, "--threads", 2)
    found = rows(done.stdout)
    words = ("--set", "k=2", "--set", "l[3]=0.02", "--start", "theta[20]=-0.3")
    alone = rows(pkgen("run", model, *common, *words).stdout)
    mine = [row[1:] for row in found if row[0] == 2]
    assert len(mine) == 3
    for one, other in zip(alone, mine, strict=True):
        assert other == pytest.approx(one, rel=1e-11, abs=1e-12)
