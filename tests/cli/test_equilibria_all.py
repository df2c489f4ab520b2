"""All equilibria in reach: of potentials that are sums of double wells, weakly coupled, all 3^n are
known (by the implicit function theorem); of a ring there is a continuum."""

from __future__ import annotations

import itertools
import json
import random
from pathlib import Path

import pytest

NAMES = "xyz"


def wells(seed: int, n: int) -> tuple[str, list[float]]:
    chance = random.Random(seed)
    at = [round(chance.uniform(0.3, 3.0), 3) for _ in range(n)]
    terms = [
        f"{chance.uniform(0.5, 2):.3f}*({c}^2 - {a}^2)^2" for c, a in zip(NAMES, at, strict=False)
    ]
    least = min(at) ** 4
    terms += [
        f"{0.02 * least * chance.choice((-1, 1)):.5f}*sin({a} + 2*{b})"
        for a, b in itertools.combinations(NAMES[:n], 2)
    ]
    kinetic = " + ".join(f"{c}'^2/2" for c in NAMES[:n])
    start = ", ".join(f"{c} = {0.9 * a:.4g}" for c, a in zip(NAMES, at, strict=False))
    text = f"model wells\ncoord {', '.join(NAMES[:n])}\nkinetic {kinetic}\n"
    return f"{text}potential {' + '.join(terms)}\nstart {start}\n", at


def told(pkgen, folder: Path, text: str) -> dict:
    model = folder / "model.lag"
    model.write_text(text)
    words = ("--quick", "--methods", "verlet", "--until", 20, "--points", "4x3", "-o", folder)
    done = pkgen("stability", model, *words, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_every_well_and_saddle_is_found(seed: int, n: int, pkgen, tmp_path: Path) -> None:
    text, at = wells(seed, n)
    found = told(pkgen, tmp_path, text)
    places = [tuple(e["q"]) for e in found["equilibria"]]
    near = {
        tuple(
            min((-1, 0, 1), key=lambda k, x=x, a=a: abs(x - k * a))
            for x, a in zip(q, at, strict=True)
        )
        for q in places
    }
    assert len(places) == len(near) == 3**n
    said = next(x for x in found["remarks"] if x.startswith("equilibria:"))
    assert f"found {3**n}, sought from 101 starts or more" in said


def test_a_ring_of_equilibria_is_named(pkgen, tmp_path: Path) -> None:
    text = "model ring\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential (x^2 + y^2 - 1)^2\n"
    found = told(pkgen, tmp_path, text + "start x = 0.9, y = 0.1\n")
    assert any("equilibria form a continuum" in x for x in found["remarks"])
