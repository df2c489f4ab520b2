"""A model as it stands, without scene or option, shows what it is about.

So a page, a film and a plot of it do too.
"""

from itertools import pairwise
from math import atan2, degrees
from pathlib import Path

import pytest

from conftest import ROOT, ran, table

MODELS = sorted((ROOT / "models").rglob("*.lag"))


def columns(pkgen, model: str | Path, *options: object) -> dict[str, list[float]]:
    done = ran("run", ROOT / "models" / model, *options)
    head, rows = table(done.stdout)
    return dict(zip(head, zip(*rows, strict=True), strict=True))


def signs(values: list[float]) -> list[int]:
    """The signs that they have, one after another."""
    found = [(x > 0) - (x < 0) for x in values]
    return [s for k, s in enumerate(found) if k == 0 or s != found[k - 1]]


def test_the_rattleback_reverses(pkgen) -> None:
    run = ("constrained/rattleback.lag", "--until", 30, "--record", "spin", "--every", 0.5)
    spin = columns(pkgen, *run)["spin"]
    assert signs(spin) == [-1, 1, -1]  # at 2.7 s and at 17.3 s
    assert min(spin) < -4 and max(spin) > 4
    other = columns(pkgen, *run, "--set", "n3=5")["spin"]  # a tenth as fast
    assert signs(other[:20]) == [1]


@pytest.mark.parametrize("model", ["foucault", "foucault_spherical"])
def test_the_plane_of_swing_turns(pkgen, model: str) -> None:
    """Once in 319 s, of which a page takes eight in a second."""
    run = (f"pendulums/{model}.lag", "--record", "x,y", "--at", "outermost")
    found = columns(pkgen, *run, "--until", 320)
    other_ends = list(zip(found["x"], found["y"], strict=True))[1::2]
    angles = [degrees(atan2(y, x)) for x, y in other_ends]
    steps = [(a - b) % 360 for a, b in pairwise(angles)]
    assert steps == pytest.approx([18.5] * len(steps), abs=3)  # to the right
    assert len(steps) == 18  # nearly once round
    earth = columns(pkgen, *run, "--until", 320, "--set", "turn=7.3e-5")
    assert max(map(abs, earth["y"])) < 0.1


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_none_is_at_rest(pkgen, path: Path) -> None:
    noisy = "\nnoise" in path.read_text("utf-8")  # methods with noise have fixed steps
    more = ("--step", 0.01) if noisy else ()
    found = columns(pkgen, path, "--until", 1.5, "--every", 0.5, *more)  # a disk settles at 2
    assert any(max(v) - min(v) > 1e-9 * max(map(abs, v)) for n, v in found.items() if n != "t")
