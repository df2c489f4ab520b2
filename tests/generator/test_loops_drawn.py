"""Random models, drawn for sums inside expressions and rates of states: kernels as loops against
the unrolled code."""

import random

import pytest
import test_loops
from chain_models import drawn
from loop_harness import Looped, Written, looped
from test_loops import assert_kernels, assert_start

from pkgen.middle.families.indexed_ir import NotKept as CannotLoop
from pkgen.source import ModelError


def is_for_this(text: str) -> bool:
    """Whether members feel a total, or rates others, or an output is computed along members."""
    try:
        e = looped(text)
    except (CannotLoop, ModelError):
        return False
    return bool(e.sums or e.summed or e.along or any(s.kind == "a" for s in e.slots))


@pytest.mark.parametrize("seed", range(0, 60, 4))
def test_drawn_models_equal_the_unrolled_code(seed: int, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(test_loops, "TOLERANCE", 1e-12)  # what is drawn loses digits
    texts = {k: drawn(random.Random(k), size=3) for k in range(seed, seed + 4)}
    texts = {k: text for k, text in texts.items() if is_for_this(text)}
    assert texts
    for k, text in texts.items():
        loops, dice = Looped(text, tmp_path / f"loops{k}", ("-O0",)), random.Random(k)
        for size in (3, 5):
            written, at = Written(text, size, tmp_path / f"n{k}_{size}"), loops.at(size)
            assert_start(written, at)
            q, v = ([dice.uniform(-1, 1) for _ in range(at.n)] for _ in range(2))
            u = [dice.uniform(-1, 1) for _ in written.program.equations.inputs]
            assert_kernels(written, at, (dice.uniform(0, 3), q, v, u), f"N = {size}\n{text}")
