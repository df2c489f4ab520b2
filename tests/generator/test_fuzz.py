"""Mutated models: whatever the text, there is a Model or a ModelError, and in good time."""

import random
import subprocess
import sys
import time

import pytest

from conftest import ROOT, seeds
from pkgen.front.check.check import check_text
from pkgen.front.read import from_text
from pkgen.source import ModelError

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
from models import EXTRA, corpus, mutated


def outcome(text: str) -> bool:
    """Whether a model came out; anything but a ModelError goes through."""
    try:
        check_text(from_text("fuzz.lag", text))
    except ModelError as error:
        assert error.text()
        return False
    return True


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_only_model_errors(seed):
    random_ = random.Random(seed)
    texts = corpus()
    right = wrong = 0
    end = time.monotonic() + 20  # a slow machine does fewer
    while right + wrong < 500 and time.monotonic() < end:
        text = mutated(random_, random_.choice(texts))
        try:
            if outcome(text):
                right += 1
            else:
                wrong += 1
        except Exception as error:
            raise AssertionError(f"{type(error).__name__} for this model:\n{text}") from error
    assert right > 10  # mutations small enough to leave some models right
    assert wrong > 100


def test_the_extra_model_is_right():
    assert outcome(EXTRA)


FOUND = [  # what has once ended in an internal error
    "model wrong\nparam force = 1\nparam in\n= \nend\n2\nparam step = 3\ncoord x\nkinetic x'^2/2\n",
    "model m\nsize N 0 5\ncoord x\nkinetic x'^2/2\ncontact c[i = 1..N]: x - i >= 0\n",
]


@pytest.mark.parametrize("text", FOUND)
def test_what_was_found(text):
    assert not outcome(text)


def test_noise():
    random_ = random.Random(2385)
    alphabet = "aqx'[]()+-*/^.,=0123456789 \n#θé"
    for _ in range(300):
        text = "".join(random_.choice(alphabet) for _ in range(random_.randrange(200)))
        assert not outcome(text)
        assert not outcome("model a\nlet b = " + text)


def test_a_minute_of_each():
    """The fuzzers, of models through the compiler and of the runtime (docs/dev/fuzzing.md)."""
    done = subprocess.run(
        ["make", "-s", "fuzz", "FUZZ_SECONDS=60"],
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, done.stdout[-4000:]
