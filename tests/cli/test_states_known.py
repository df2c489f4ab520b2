"""Models of states against what is known of them: order, stiffness, a chain, a rocket."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from conftest import case, ran, table, written

DECAY = """\
model decay
state u [K]
param tau = 1 [min]
rate u = -u/tau
start u = 300 [K]
let closed = (300 [K])*exp(-t/tau)
scene cold
  until 10 [min]
  {}
  record u every 1 [min]
  expect u = closed within 3e-6 [K]
end
"""


@pytest.mark.parametrize("how", ["accuracy 1e-8", "method radau rtol 1e-8", "method exponential"])
def test_an_accuracy_is_kept_by_a_state(tmp_path: Path, how: str) -> None:
    ran("run", written(tmp_path, DECAY.format(how)), "--scene", "cold")


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


# H. H. Robertson (1966), at t = 40 from the manual of CVODE, at 1e11 from E. Hairer, G. Wanner's
# set of problems.
ROBERTSON = case("robertson")


def test_a_stiff_reaction(pkgen, tmp_path: Path) -> None:
    model = written(tmp_path, ROBERTSON)
    radau = ("--method", "radau", "--rtol", "1e-9", "--atol", "1e-16")
    done = pkgen("run", model, "--until", "1e11", "--every", "1e11", *radau, "--json")
    said = json.loads(done.stdout)
    expected = [0.2083340149701255e-07, 0.8333360770334713e-13, 0.9999999791665050]
    assert said["rows"][-1][1:] == pytest.approx(expected, rel=1e-6)
    assert said["report"]["steps"] < 3000
    done = pkgen("run", model, "--until", "40", "--every", "40", *radau)
    assert table(done.stdout)[1][-1][1:] == pytest.approx([0.71582, 9.1855e-6, 0.28417], rel=1e-4)


DIFFUSION = case("diffusion")


@pytest.mark.parametrize("how", [("exponential",), ("radau", "--rtol", "1e-9")])
def test_a_chain_of_states(pkgen, tmp_path: Path, how: tuple[str, ...]) -> None:
    """A mode of the chain decays by 4 D/dx^2 sin^2(pi/(2 (N + 1)))."""
    model = written(tmp_path, DIFFUSION)
    run = ("run", model, "--until", "0.05", "--every", "0.05", "--method", *how)
    head, (first, last) = table(pkgen(*run, "--start", "c[9]=0.30901699437494745").stdout)
    assert head == ["t", *(f"c[{i}]" for i in range(1, 10))]
    left = math.exp(-0.05 * 400 * math.sin(math.pi / 20) ** 2)
    assert left < 0.7
    assert last[1:] == pytest.approx([left * c for c in first[1:]], rel=1e-8)
    _, (_, last) = table(pkgen("run", model, "--scene", "between").stdout)
    end = math.sin(0.9 * math.pi)  # straight between what is held
    straight = [1 - (1 - end) * i / 8 for i in (0, 1, 7, 8)]
    assert last[1:] == pytest.approx(straight, abs=1e-7)


ROCKET = case("rocket")


@pytest.mark.parametrize(
    "how", [("rk4", "--step", "0.01"), ("gauss4", "--step", "0.1"), ("radau", "--rtol", "1e-10")]
)
def test_a_mass_that_is_a_state(pkgen, tmp_path: Path, how: tuple[str, ...]) -> None:
    """K. E. Tsiolkovsky (1903)."""
    run = ("run", written(tmp_path, ROCKET), "--until", "20", "--every", "10", "--method", *how)
    head, (*_, last) = table(pkgen(*run).stdout)
    end = dict(zip(head, last, strict=True))
    assert end["z'"] > 1600 and end["m"] == pytest.approx(40)
    assert abs(end["off"]) < 1e-6
