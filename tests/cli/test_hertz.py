"""Contacts whose force is a root or a power of the depth: steps end where they begin and end."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from conftest import rows, seeds, written


def between_walls(seed: int, powers: tuple[float, ...]) -> tuple[str, float, float, float]:
    """A body between two walls k d^p, written in three ways; until when, where it is then, and the
    width. The time within a wall is 2 d/v int_0^1 dz/sqrt(1 - z^p)."""
    draw = random.Random(seed)
    k, p = 10 ** draw.uniform(0, 7), draw.choice(powers)
    width, speed, x = draw.uniform(0.1, 9), 10 ** draw.uniform(-1, 1), draw.uniform(0.2, 0.8)
    depth = (speed**2 / 2 / k) ** (1 / p)
    within = math.sqrt(math.pi) * math.gamma(1 + 1 / p) / math.gamma(0.5 + 1 / p)
    within *= 2 * depth / speed
    until = (1 - x) * width / speed + 5 * within + 4 * width / speed + x * width / speed / 2
    walls = draw.choice(
        [
            f"{k!r}*(max(0, x - {width!r})^{p} + max(0, -x)^{p})",
            f"{k!r}*max(0, abs(x - {width / 2!r}) - {width / 2!r})^{p}",
            f"{k!r}*(sqrt(max(0, x - {width!r}))^{2 * p:.0f} + sqrt(max(0, -x))^{2 * p:.0f})",
        ][: 3 if powers[0] < 2 else 2]
    )
    start = f"start x = {x * width!r}, x' = {speed!r}, y = 1e-9\n"
    text = f"model walls\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y^2/2 + {walls}\n{start}"
    return text, until, width - x * width / 2, width


HERTZ, SOFT = (1.5, 2.5, 3.5), (2, 3)
WALLS = [(HERTZ, m) for m in ("dop853", "dopri5", "radau", "gsl_rk8pd", "gsl_msbdf")]
WALLS += [(SOFT, m) for m in ("gauss", "dop853", "radau", "gsl_rk8pd", "gsl_rkf45")]


@pytest.mark.parametrize(("powers", "method"), WALLS)
@pytest.mark.parametrize("seed", seeds(range(3), 25))
def test_a_body_between_walls(pkgen, tmp_path: Path, powers: tuple, method: str, seed: int) -> None:
    """Tolerances are those of the step that is tried, not of the one that free flight proposed."""
    text, until, x, width = between_walls(seed, powers)
    run = ("--until", until, "--every", until, "--method", method, "--rtol", "1e-10")
    last = rows(pkgen, written(tmp_path, text), *run)[-1]
    assert abs(last["x"] - x) < 2e-6 * width, (last["x"], x)
