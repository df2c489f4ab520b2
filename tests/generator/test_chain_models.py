"""Random families as loops and with their members written out: tests/fuzz/families.py."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, seeds

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import families

# One of each kind that stays loops.
EACH = (17, 18, 19, 21, 22, 23, 25, 26, 27, 31)


@pytest.mark.parametrize("seed", seeds(EACH, 32))
def test_loops_are_members_written_out(seed: int) -> None:
    verdict, seen = families.alone(seed)
    wanted = ("agree",) if seed in EACH else ("agree", "written out", "refused")
    assert verdict in wanted, f"{verdict}: {seen}\n{families.text_of(seed)}"


def test_a_wrong_row_is_found(monkeypatch) -> None:
    """Were the two compared with nothing, all would agree."""
    both = families.both

    def other(folder, *words):
        mine, theirs = both(folder, *words)
        rows = [[x + 1e-5 for x in row] for row in mine[1]]
        return (mine[0], rows, *mine[2:]), theirs

    monkeypatch.setattr(families, "both", other)
    assert families.alone(4)[0] == "DIFFER"


def test_a_seed_is_one_model_whatever_the_hash_seed() -> None:
    code = "import random, chain_models as c; print([c.drawn(random.Random(s)) for s in range(60)])"
    here = str(Path(__file__).parent)
    told = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONPATH": here, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "2", "3")
    }
    assert len(told) == 1
