"""The table of a million steps: what a row says, and that what it says is measured."""

import dataclasses

import pytest

from bench import accuracy, bodies, systems

RUN = bodies.Run(
    "disk goes", "gauss4 h = 0.1", 1000, 3, 1, 0, 3,
    norm=2e-16, place=0.0, rate=3e-16, energy=7e-13, power=1.0, others=-1.0, seconds=0.005,
    growth="secular, as t", met=8, asked=8,
)  # fmt: skip


def test_a_row_says_what_is_free_and_what_there_is_none_of() -> None:
    assert RUN.cells() == (
        "disk goes", "3, 1", "0 + 3", "3", "gauss4 h = 0.1", "2.0e-16", "–", "3.0e-16", "7.0e-13",
        "secular, as t (t^1.00)", "–", "5", "8 of 8",
    )  # fmt: skip


@pytest.mark.parametrize("bad", [{"norm": 2e-14}, {"place": 1e-9}, {"rate": 1e-9}, {"met": 7}])
def test_a_residual_or_a_miss_is_told(bad: dict) -> None:
    assert RUN.well
    assert not dataclasses.replace(RUN, **bad).well


def test_rods_stay_on_their_circle_and_keep_their_energy() -> None:
    path = bodies.ROOT / "models" / "constrained" / "pendulum_rod.lag"
    short, long = (
        bodies.of_scene(path, "right_angle", {"rattle4": h}, 2000)[0] for h in (0.02, 0.1)
    )
    assert (short.coordinates, short.holonomic, short.rolling) == (2, 1, 0)
    assert 0 < short.place < 1e-15 and 0 < short.rate < 1e-15
    assert 0 < short.energy < 2e-7 < long.energy  # of order 4
    assert short.well and short.seconds > 0


@pytest.mark.parametrize(
    ("bench", "there"), [(bodies, "free_body"), (systems, "free_body"), (accuracy, "pendulum")]
)
def test_what_is_not_there_is_no_empty_table(bench, there) -> None:
    with pytest.raises(SystemExit) as caught:
        bench.main(["--only", "nosuch"])
    assert "nosuch" in str(caught.value) and there in str(caught.value)
