"""A model as it stands, without scene or option, shows what it is about.

So a page, a film and a plot of it do too.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from conftest import ROOT, table

MODELS = sorted((ROOT / "models").rglob("*.lag"))


def columns(pkgen, model: str | Path, *options: object) -> dict[str, list[float]]:
    done = pkgen("run", ROOT / "models" / model, *options)
    assert done.returncode == 0, done.stderr
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


@pytest.mark.long
@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_none_is_at_rest(pkgen, path: Path) -> None:
    found = columns(pkgen, path, "--until", 1.5, "--every", 0.5)  # a disk settles at 2
    assert any(max(v) - min(v) > 1e-9 * max(map(abs, v)) for n, v in found.items() if n != "t")
