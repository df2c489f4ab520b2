"""Scenes that ask for an accuracy: those of all models, of the test set, published and random ones.

A scene of a model is taken as it stands but for its method, in whose place it asks for an accuracy,
and for what it expects, which is of that method. Its other variants start a little elsewhere.
"""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .kept_models import MODELS

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests" / x) for x in ("", "cli", "fuzz")]

from accuracy.cases import CASES, SCENE  # noqa: E402
from bent_models import PLACES, ROOTS, model  # noqa: E402
from test_reductions_random import system  # noqa: E402

ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
BOUND = re.compile(r"^\s*(rotation|constraint|rolling) ", re.M)  # its starts are not free


@dataclass(frozen=True)
class Case:
    """`varied`: a seed of another start; 0: its own."""

    name: str
    kind: str
    text: str
    scene: str
    varied: int = 0


def cases(quick: bool) -> list[Case]:
    every = [*_own(), *_test_set(), *_models(), *_published(), *_kinks(), *_random()]
    return every[:: len(every) // QUICK] if quick else every


QUICK = 24


def _models() -> Iterator[Case]:
    for path in sorted((ROOT / "models").rglob("*.lag")):
        text = path.read_text(encoding="utf-8")
        for k, name in enumerate(re.findall(r"^scene (\w+)", text, re.M)):
            if "swarm" in _block(text, name):
                continue  # of which a few members are tried
            draw = random.Random(f"{path.stem} {name}")
            first, second = draw.sample(ACCURACIES, 2)
            kind = "constraints, rotations" if BOUND.search(text) else "models"
            yield Case(f"{path.stem} {name}", kind, asking(text, name, first), name)
            if kind == "models":
                again = asking(text, name, second)
                yield Case(f"{path.stem} {name} elsewhere", kind, again, name, k + 1)


def _test_set() -> Iterator[Case]:
    for case in CASES:
        yield Case(case.name, "test set", case.text(), SCENE)


def _published() -> Iterator[Case]:
    for path in sorted((ROOT / "bench/lag/published").glob("*.lag")):
        text = path.read_text(encoding="utf-8")
        for name in re.findall(r"^scene (\w+)", text, re.M):
            if "accuracy" in (block := _block(text, name)):
                asked = float(re.findall(r"accuracy\s+(\S+)", block)[0])
                yield Case(f"{path.stem} {name}", "published", asking(text, name, asked), name)


def _kinks() -> Iterator[Case]:
    for seed in range(2, 4):
        for place in PLACES:
            draw = random.Random(f"{place.name} {seed}")
            roots = {"kinds": ROOTS} if draw.random() < 0.2 else {}
            text = model(seed, place, True, **roots)
            text = re.sub(r"until 2\n(.*) every 1\n", r"until 4\n\1 every 0.1\n", text)
            asked = asking(text, "s", draw.choice(ACCURACIES))
            yield Case(f"kink in {place.name} {seed}", "kinks", asked, "s")


def _random() -> Iterator[Case]:
    for seed in range(40, 72):
        text, _ = system(seed)
        asked = random.Random(seed).choice(ACCURACIES)
        yield Case(f"random {seed}", "random", asking(text, "s", asked), "s")


def _own() -> Iterator[Case]:
    for kind, name, text, accuracies in MODELS:
        for k, asked in enumerate(accuracies):
            varied = k if "state" not in text else 0
            yield Case(f"{name} {asked:.0e}", kind, asking(text, "s", asked), "s", varied)


def _block(text: str, name: str) -> str:
    return re.findall(rf"^scene {name}\b.*?^end$", text, re.M | re.S)[0]


def asking(text: str, name: str, accuracy: float) -> str:
    """The model with this scene alone, which asks for an accuracy and expects nothing."""
    kept: list[str] = []
    dropped = depth = 0
    for line in _block(text, name).splitlines():
        bare = line.partition("#")[0]
        if not depth:
            dropped = bare.split()[:1] in (["method"], ["expect"], ["accuracy"])
        depth += sum(bare.count(c) for c in "([") - sum(bare.count(c) for c in ")]")
        if not dropped:
            kept.append(line)
    kept.insert(1, f"  accuracy {accuracy:g}")
    before = re.sub(r"^scene \w+.*?^end$", "", text, flags=re.M | re.S)
    return "\n".join([before, *kept, ""])
