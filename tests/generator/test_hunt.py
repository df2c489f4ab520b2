"""A few random models with a bend or a jump beside their smooth twins: tests/fuzz/hunt.py."""

import sys

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import hunt
from bent_models import PLACES, ROOTS

PLACE = {place.name: place for place in PLACES}
SEEN = ("force", "potential", "mass", "gauge", "dissipation", "constraint", "rolling", "hold")


@pytest.mark.parametrize("name", SEEN)
def test_a_bend_is_the_limit_of_its_ramps(name):
    verdict, seen = hunt.judge((PLACE[name],), 900)
    assert verdict == "agrees", seen


@pytest.mark.parametrize("name", ["force", "potential", "mass", "rolling", "torque"])
def test_so_is_a_root_of_one(name):
    verdict, seen = hunt.judge((PLACE[name],), 1, ROOTS)
    assert verdict == "agrees", seen


def test_another_motion_is_found_to_be_wrong(monkeypatch):
    def other(seed, place, sharp, kinds):
        text = model(seed, place, sharp, kinds=kinds)
        return text.replace("force y = 0.7*", "force y = 0.71*") if sharp else text

    model = hunt.model
    monkeypatch.setattr(hunt, "model", other)
    assert hunt.judge((PLACE["force"],), 900)[0] == "WRONG"


def test_a_run_that_cannot_start_is_no_refusal(monkeypatch):
    monkeypatch.setattr(hunt, "COMMAND", [sys.executable, "-m", "no_such_pkgen"])
    with pytest.raises(RuntimeError, match="No module named"):
        hunt.judge((PLACE["force"],), 900)
