"""Wrong values of arguments of the Python API: one error each, in the words of the API."""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pkgen as api
from conftest import ROOT, written

DOUBLE = ROOT / "models/double_pendulum.lag"
RUN = (
    *("until", "method", "every", "step", "max_step", "rtol", "atol", "start", "inputs"),
    *("record", "at", "diagnose", "iteration", "max_steps", "tableau", "composition"),
)
WRONG: tuple[object, ...] = (
    *(True, -1, 0, 1.5, 2**70, 10**400, float("nan"), float("inf"), 1j, 1e-300),
    *("", "x", "-u", "2 [kg]", "[", "0x", "é\0", b"1"),
    *([], [1], [0.5, 0.1], ["x"], [None], (1, 2), {1, 2}, range(3), iter("ab")),
    *({}, {"x": 1}, {1: 2}, {"theta1": [1]}, {"theta1": None}, {"theta1": "-"}, {"theta1": "x"}),
    *(object(), print, None, Path("nowhere"), np.zeros(3), np.array("x"), np.array(2.0)),
)
SAID = (api.UsageError, api.ModelError, api.RunError)


@pytest.fixture(scope="module")
def double() -> api.Model:
    return api.load(DOUBLE)


def judged(call: Callable[[], object]) -> None:
    """It works, or it says why not."""
    try:
        call()
    except SAID as error:
        said = str(error)
        assert said and "--" not in said, said
        assert "command line" not in said and "finding(s)" not in said


@pytest.mark.parametrize("name", [*RUN, "threads"])
def test_wrong_values_of_a_run(double: api.Model, name: str) -> None:
    def call(value: object) -> object:
        given = {"until": 0.1, "max_steps": 100, "step": None, name: value}
        if name == "threads":
            return double.ensemble({"theta1": [1.0]}, **given)
        return double.run(**given)

    for value in WRONG:
        judged(lambda value=value: call(value))


def test_wrong_values_elsewhere(double: api.Model) -> None:
    y = double.start
    for value in WRONG:
        calls = [
            lambda v=value: api.load(v),
            lambda v=value: api.load(DOUBLE, scene=v),
            lambda v=value: api.load(DOUBLE, sizes=v),
            lambda v=value: api.load(DOUBLE, sizes={"N": v}),
            lambda v=value: double.ensemble(v, until=0.1),
            lambda v=value: double.ensemble({"theta1": v}, until=0.1),
            lambda v=value: double.rhs(0, v),
            lambda v=value: double.rhs(v, y),
            lambda v=value: double.M(v, [1, 2]),
            lambda v=value: double.energy([1, 2], v),
            lambda v=value: double.f([1, 2], [1, 2], v),
            lambda v=value: api.load(DOUBLE).params.__setitem__("m1", v),
        ]
        for call in calls:
            judged(call)


def test_random_pairs_of_wrong_values(double: api.Model) -> None:
    dice = random.Random(1)
    for _ in range(300):
        given = {name: dice.choice(WRONG) for name in dice.sample(RUN, 2)}
        judged(lambda given=given: double.run(**{"until": 0.1, "max_steps": 100, **given}))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"until": "x"}, "until=x: unknown name 'x'"),
        ({"until": "1 [kg]"}, "until=1 [kg]: unit mismatch"),
        ({"every": [1]}, "every=[1]: give a number in SI, or a text with a unit"),
        ({"start": [0.5, 0.1]}, "start=[0.5, 0.1]: give a dictionary of values by name"),
        ({"start": {"theta9": 1}}, "start['theta9']: the model has no such coordinate"),
        ({"inputs": {"u": ([0], [1])}}, "inputs['u']: the model has no such input; it has: none"),
        ({"inputs": {"u": 1}}, "inputs['u']: the model has no such"),
        ({"max_steps": "9"}, "max_steps='9': give a whole number"),
        ({"iteration": "none"}, "iteration='none': give 'newton' or 'fixed'"),
        ({"method": "rk4"}, "method rk4 has a fixed step: give it by step="),
        ({"method": "rk4", "step": 0.1, "rtol": 1e-3}, "rtol= is for adaptive methods"),
        ({"composition": [1, 2]}, "composition=1.0,2.0:1:1: error: the weights sum to 3"),
        ({"method": "verlet", "step": 0.1}, "verlet needs a system that is separable"),
    ],
)
def test_messages_name_arguments(double: api.Model, given: dict, said: str) -> None:
    with pytest.raises((api.UsageError, api.ModelError)) as wrong:
        double.run(**{"until": 1, **given})
    assert said in str(wrong.value)


def test_a_record_may_be_one_name(double: api.Model) -> None:
    assert double.run(0.1, record="theta1").columns == ("t", "theta1")


def test_an_error_of_a_model_says_all(tmp_path: Path) -> None:
    path = written(tmp_path, "model wrong\ncoord x\nkinetic y'^2/2\n")
    with pytest.raises(api.ModelError) as wrong:
        api.load(path)
    said = str(wrong.value)
    assert said == wrong.value.text() and f"{path}:3:9: error: " in said and "^" in said


def test_warnings_come_once_for_each_model(tmp_path: Path) -> None:
    path = written(
        tmp_path, "model idle\ncoord x\nparam unused = 1\nkinetic x'^2/2\npotential x^2/2\n"
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model = api.load(path)
        for until in (1, 2):
            model.run(until, every=1)
            model.run(until, method="rk4", step=0.1, record=["x"])
        model.energy([1.0], [0.0])
    assert len(told) == 1 and "unused" in str(told[0].message)
