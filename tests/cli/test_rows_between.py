"""A fixed step that is asked for is the one that is taken, whatever is recorded: rows between steps
are those of a shorter step from where one began. The oracle is a method's matrix for x'' = -x."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path

import numpy as np
import pytest

from conftest import case, ran

MODEL = case("rows_between_model")
A = np.array([[0.0, 1.0], [-1.0, 0.0]])
ONE = np.eye(2)


def series(z: np.ndarray, last: int) -> np.ndarray:
    return sum(np.linalg.matrix_power(z, k) / math.factorial(k) for k in range(last + 1))


def kick(h: float) -> np.ndarray:
    return np.array([[1, 0], [-h / 2, 1]])


MATRIX = {
    "rk4": lambda h: series(h * A, 4),
    "verlet": lambda h: kick(h) @ np.array([[1, h], [0, 1]]) @ kick(h),
    "gauss2": lambda h: np.linalg.solve(
        ONE - h * A / 2 + h * h * A @ A / 12, ONE + h * A / 2 + h * h * A @ A / 12
    ),
    "radau5": lambda h: np.linalg.solve(
        ONE - 3 * h * A / 5 + 3 * h * h * A @ A / 20 - h**3 * A @ A @ A / 60,
        ONE + 2 * h * A / 5 + h * h * A @ A / 20,
    ),
}


def state(method: str, h: float, t: float, start: tuple[float, float]) -> np.ndarray:
    """After as many whole steps as go into t, and a shorter one."""
    whole = math.floor(t / h + 1e-9)
    y = np.linalg.matrix_power(MATRIX[method](h), whole) @ np.array(start)
    return MATRIX[method](t - whole * h) @ y


def written(write, method: str, step: float, every: float, second: str = "y^2/2") -> str:
    expected = state(method, step, 4.56, (1, 0.3))[0]
    return write(
        MODEL.format(
            method=method, step=step, every=every, expected=repr(float(expected)), second=second
        )
    )


@pytest.mark.parametrize("method", MATRIX)
def test_rows_are_of_shorter_steps_and_disturb_nothing(write, method: str) -> None:
    chance = random.Random(method)
    step, every = round(chance.uniform(0.3, 0.9), 3), round(chance.uniform(0.2, 1.4), 3)
    path = written(write, method, step, every)
    for scene in ("alone", "members", "watched"):
        done = ran("run", path, "--scene", scene, "--json")
        found = json.loads(done.stdout)
        rows = found["rows"]
        if scene == "alone":
            rows = [(2, *row) for row in rows]
            assert found["report"]["step"] == step and found["report"]["steps"] == math.ceil(
                7 / step
            )
        assert len(rows) >= (math.ceil(7 / every) + 1) * (1 if scene == "alone" else 3)
        error = worse = 0.0
        for j, t, *x in rows:
            by_time = abs(t / every - round(t / every)) < 1e-9 or t == 7
            if not by_time:
                continue
            start = (j / 2, 0.3)
            error = max(error, np.abs(state(method, step, t, start) - x[:2]).max())
            shortened = every / math.ceil(every / step)
            worse = max(worse, np.abs(state(method, shortened, t, start) - x[:2]).max())
        assert error < 2e-13
        assert worse > 1e-9 or shortened == step  # what it was: another step


def test_an_unstable_step_looks_unstable(pkgen, write) -> None:
    path = written(write, "verlet", 2.05, 3)
    done = pkgen("run", path, "--scene", "alone", "--json", "--until", "60")
    found = json.loads(done.stdout)
    exact = state("verlet", 2.05, 60, (1, 0.3))
    assert found["report"]["step"] == 2.05 and found["report"]["steps"] == 30
    assert found["rows"][-1][1:3] == pytest.approx(list(exact), rel=1e-9) and abs(exact[0]) > 100
    said = pkgen("run", path, "--scene", "alone").stderr
    assert "steps of 2.05," in said and "the energy" in said


def test_blocks_apart_take_their_steps_too(pkgen, write) -> None:
    path = written(write, "gauss2", 0.37, 0.9, second="k*y^4/4")
    done = pkgen("run", path, "--scene", "apart", "--json")
    rows = json.loads(done.stdout)["rows"]
    assert len(json.loads(done.stdout)["report"]["parts"]) == 2
    for t, x, v, _ in rows:
        assert np.abs(state("gauss2", 0.37, t, (1, 0.3)) - (x, v)).max() < 1e-13
    assert done.returncode == 0 and len(rows) == 9


def test_steps_that_divide_the_interval_land_as_they_did(pkgen, write, tmp_path: Path) -> None:
    """Ten steps of 0.01 are 0.1 but for rounding; 0.7 is not reached by 2 steps of 0.3."""
    path = written(write, "rk4", 0.01, 0.1)
    runs = {}
    for every in ("0.1", "0.01", "0.05", "7"):
        done = pkgen("run", path, "--scene", "alone", "--json", "--every", every)
        found = json.loads(done.stdout)
        report = found["report"]
        assert report["steps"] == 700 and report["evaluations"] == 2800
        runs[every] = {round(row[0], 9): row[1:] for row in found["rows"]}
    assert all(run[7.0] == pytest.approx(runs["7"][7.0], abs=1e-13) for run in runs.values())
    between = json.loads(
        pkgen("run", path, "--scene", "alone", "--json", "--every", "0.007").stdout
    )
    assert between["report"]["steps"] == 700 and len(between["rows"]) == 1001
    assert between["rows"][-1][1:] == runs["7"][7.0]


def test_a_model_with_events_has_rows_within_steps(pkgen, write) -> None:
    """The step aside has the model's own parameters where no switch has sides."""
    text = "model swings\ncoord x\nkinetic x'^2/2\npotential x^2/2\nstart x = 1\nevent zero: x\n"
    options = ("--method", "rk4", "--step", "0.01", "--until", "1", "--every", "0.37")
    rows = json.loads(pkgen("run", write(text), "--json", *options).stdout)["rows"]
    assert [row[0] for row in rows] == pytest.approx([0, 0.37, 0.74, 1])
    assert all(row[1] == pytest.approx(np.cos(row[0]), abs=1e-9) for row in rows)
