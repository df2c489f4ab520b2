"""Mutated models: whatever the text, there is a Model or a ModelError, and in good time."""

from __future__ import annotations

import random
import re
import time
from pathlib import Path

import pytest
from conftest import long_but
from pkgen.front.check import check_text
from pkgen.front.read import from_text
from pkgen.source import ModelError

HERE = Path(__file__).parent
SEEDS = [
    *10 * sorted((HERE.parents[1] / "models").glob("*.lag")),  # beside ever more wrong ones
    *sorted((HERE / "wrong").glob("*.lag")),
]
EXTRA = """model many
size N = 3
param a[i = 1..N] = 2 [m] in (0 [cm], inf)
const c = 3 [N]
coord q[1..N] [m], x [m]
fixed q[0] = 0, q[N+1] = a[1]*sin(2*t/(1 [s]))
input u [m]
let X[0] = 0
let X[i = 1..N] = X[i-1] + q[i]
let P = [x, u, X[2]]
param m = 1 [kg]
kinetic m/2*dot(P', P') + sum(m/2*q[i]'^2, i = 1..N)
potential sum(c/a[i]*(q[i+1] - q[i])^2/2, i = 1..N) - c*norm(P)
force q[i = 1..N] = -c*q[i]/a[i]
dissipation c*x'^2/2/(1 [m/s])
observe e[i = 1..N] = p_q[i]
conserve h = energy
start q[i = 1..N] = sin(pi*i/(N+1)), x' = 0.1
event cross: x rising stop
scene one
  set m = 2 [kg]
  hold x = (1 [m])*sin(t/(1 [s]))
  record x, q[1] every 0.1 [s] at cross
  expect drift(energy) < 1e-9
  until 3
end
"""
BITS = [
    *"()[]+-*/^',=.:'\"#\\{}\n\t é²θ\0∞", "..", "**", "''", " [m]", "[1]", "1e400", "1e-400",
    "9^9^9^9", "inf", "t", "pi", "energy", "T", "q[i]", "sum(", "sum(x, i = 1..3)", "step", "in (",
    "\nend\n", "\nlet ", "\nscene s\n", "\nmodel b\n", "[x, 0, 0]", ".x", "0", "99999", "-1",
    "norm(", "[kg*m/s^2]", "\nperiodic q\n", "\nfree q\n", " at ", " every ",
]  # fmt: skip
WORD = re.compile(r"\w+|\s+|[^\w\s]")


def mutated(random_: random.Random, text: str) -> str:
    parts = WORD.findall(text)
    for _ in range(random_.choice((1, 1, 2, 3, 8))):
        at = random_.randrange(len(parts)) if parts else 0
        kind = random_.randrange(6)
        if kind == 0:
            del parts[at : at + random_.choice((1, 1, 2, 10))]
        elif kind == 1:
            parts.insert(at, random_.choice(BITS))
        elif kind == 2 and parts:
            parts.insert(at, random_.choice(parts))
        elif kind == 3 and parts:
            parts[at] = random_.choice(parts)
        elif kind == 4 and parts:
            other = random_.randrange(len(parts))
            parts[at], parts[other] = parts[other], parts[at]
        elif parts:
            word = parts[at]
            cut = random_.randrange(len(word) + 1)
            parts[at] = word[:cut] + random_.choice(BITS) + word[cut + random_.randrange(2) :]
    return "".join(parts)


def outcome(text: str) -> bool:
    """Whether a model came out; anything but a ModelError goes through."""
    try:
        check_text(from_text("fuzz.lag", text))
    except ModelError as error:
        assert error.text()
        return False
    return True


@pytest.mark.parametrize("seed", long_but({0, 1}, range(4)))
def test_only_model_errors(seed):
    random_ = random.Random(seed)
    texts = [path.read_text(encoding="utf-8") for path in SEEDS if path.stat().st_size < 4000]
    texts += [EXTRA] * 20
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
