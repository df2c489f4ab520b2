"""Runs of chains of `let`s beside constraints, rotations and ends that are coupled, kept as loops,
beside the same with all members written out."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest
from test_loops_features import both

from conftest import case, seeds
from pkgen.compiler import compile_model
from pkgen.source import Source

sys.path.insert(0, str(Path(__file__).parents[1] / "generator"))
from carried_models import held, links, turned

__all__ = ["both"]
METHODS = (("dop853", "--rtol", "1e-11"), ("rk4", "--step", "0.002"), ("gauss", "--rtol", "1e-11"))


def compare(text: str, method: tuple[str, ...], both) -> None:
    words = ("--until", 0.4, "--every", 0.1, "--method", *method)
    (loops, told), (written, said) = both(text, *words)
    assert len(loops) == len(written) == 5, text
    for one, other in zip(loops, written, strict=True):
        assert sorted(one) == pytest.approx(sorted(other), rel=1e-8, abs=1e-8), text
    for key in ("residual", "constraint_drift"):
        assert told.get(key) is None or told[key] == pytest.approx(said[key], abs=1e-10)


@pytest.mark.parametrize("seed", seeds(range(3), 5))
def test_a_chain_whose_end_is_held_is_that_written_out(seed: int, both) -> None:
    dice = random.Random(seed)
    text = held(dice)
    assert "lambda_" in text
    compare(text, METHODS[seed % 3], both)


@pytest.mark.parametrize("seed", seeds(range(3), 3))
def test_a_chain_of_bodies_that_turn_is_that_written_out(seed: int, both) -> None:
    text = turned(random.Random(seed))
    made = compile_model(Source("turned.lag", text))
    assert made.looped and made.equations.solved  # momenta depend on attitudes through places
    compare(text, METHODS[seed % 3], both)


IMPLICIT = (
    ("gauss2", "--step", "0.02"),
    ("radau5", "--step", "0.02"),
    ("lobatto3", "--step", "0.02"),
    ("radau", "--rtol", "1e-11"),
    ("gauss8", "--step", "0.1"),
)


@pytest.mark.parametrize("seed", seeds([3, 0, 1], 7))
def test_implicit_methods_of_chains_are_those_written_out(seed: int, both) -> None:
    dice = random.Random(seed)
    text = links(dice, states=seed % 3 == 2)
    while "j = i+1..N" in text:  # of which the derivatives are dense
        text = links(dice)
    method = IMPLICIT[seed % 5]
    more = ("--set", "push=0.3") if "input push" in text else ()
    words = ("--until", 0.4, "--every", 0.1, "--method", *method, *more)
    (loops, told), (written, _) = both(text, *words)
    assert told["jacobians"] > 0
    for one, other in zip(loops, written, strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-8), text


STILL = case("still")


def test_a_chain_that_nothing_moves_at_first_runs(both) -> None:
    compare(STILL, ("dop853", "--rtol", "1e-11"), both)
