"""Models of states against what is known of them: order, stiffness, a chain, a rocket."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from conftest import case, table, written

LORENZ = case("lorenz")


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk2", 2), ("rk3", 3), ("rk4", 4)])
def test_order_on_lorenz(pkgen, tmp_path: Path, method: str, order: int) -> None:
    """Of steps that the compiler has put together with the model."""
    model, at = written(tmp_path, LORENZ), ("--until", "0.5", "--every", "0.5")

    def end(*how: str) -> list[float]:
        return table(pkgen("run", model, *at, *how).stdout)[1][-1]

    exact = end("--method", "gauss", "--rtol", "1e-14")
    steps = [0.5 / n for n in (4000, 8000)] if order < 3 else [0.5 / n for n in (400, 800)]
    first, second = (
        max(
            abs(a - b)
            for a, b in zip(end("--method", method, "--step", f"{h!r}"), exact, strict=True)
        )
        for h in steps
    )
    assert second > 1e-11 and abs(math.log2(first / second) - order) < 0.1
