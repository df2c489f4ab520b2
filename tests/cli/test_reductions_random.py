"""Scenes of random systems move reduced as they do whole, in whatever reductions come together."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from conftest import seeds, written

EVEN = ("1", "(2 + cos({0}))", "(1 + {0}^2)", "exp(sin({0})/3)")
WELLS = ("0", "k*{0}^2/2", "-cos({0})", "{0}^4/4 + {0}^2/2")
OF_TWO = ("0.3*{0}*{1}", "0.2*cos({0} - {1})")
HELD = ("0.4", "0.3*sin(t)", "0.2*t")


def system(seed: int) -> tuple[str, list[str]]:
    """A model of two to four coordinates with a scene `s`, and options of its run."""
    r = random.Random(seed)
    names = list("abcd"[: r.randint(2, 4)])
    cyclic = r.sample(names, r.randint(0, len(names) - 1))
    bound = [name for name in names if name not in cyclic]

    def maybe(chance: float, text: str) -> list[str]:
        return [text] if r.random() < chance else []

    kinetic = [
        f"{r.choice(['1', '2', 'm', 'k'])}*{r.choice(EVEN).format(r.choice(bound))}*{x}'^2/2"
        for x in names
    ]
    for _ in range(r.randint(0, 2)):
        factor = r.choice(["1", f"cos({r.choice(bound)})"])
        kinetic.append("0.2*{}*{}'*{}'".format(factor, *r.sample(names, 2)))
    kinetic += maybe(0.3, f"0.4*{r.choice(bound)}*{r.choice(names)}'")  # as of a magnetic field
    potential = [r.choice(WELLS).format(x) for x in bound]
    if len(bound) > 1:
        potential += maybe(0.6, r.choice(OF_TWO).format(*r.sample(bound, 2)))
    forces = maybe(0.3, f"force {r.choice(bound)} = -0.1*{r.choice(names)}'")
    forces += maybe(0.3, f"force {r.choice(names)} = 0.3*cos(t)")
    starts = [f"{x} = {r.uniform(-1, 1):.3f}, {x}' = {r.uniform(-1, 1):.3f}" for x in names]
    hold = r.choice(names) if r.random() < 0.25 else ""
    free = [x for x in names if x != hold]
    columns = [x + r.choice(["", "", "'"]) for x in r.sample(free, r.randint(1, len(free)))]
    columns += maybe(0.4, f"p_{r.choice(free)}") + maybe(0.3, "energy")
    options = [f"--start={r.choice(free)}'=0.31"] if r.random() < 0.6 else []
    options += maybe(0.4, "--set=k=0.9")
    lines = [
        f"model random{seed}",
        "param m = 1.3 in (0, inf)",
        "param k = 0.7 in (0, inf)",
        f"coord {', '.join(names)}",
        f"lagrangian {' + '.join(kinetic)} - ({' + '.join(potential)})",
        *(forces if len({f.split()[1] for f in forces}) == len(forces) else forces[:1]),
        f"start {', '.join(starts)}",
        "scene s",
        *maybe(0.4, "set m = 2.1"),
        *([f"hold {hold} = {r.choice(HELD)}"] if hold else []),
        "until 6",
        "method gauss rtol 1e-13",
        f"record {', '.join(columns)} every 0.5",
        "end",
    ]
    return "\n".join(lines) + "\n", options


@pytest.mark.parametrize("seed", seeds([1, 2, 3], 29))
def test_random_systems_move_as_they_do_whole(pkgen, tmp_path: Path, seed: int) -> None:
    text, options = system(seed)
    model = written(tmp_path, text)
    rows = []
    for more in ([], ["--no-reduce"]):
        done = pkgen("run", model, "--scene", "s", *options, *more)
        assert done.returncode == 0, text + done.stderr
        rows.append(np.loadtxt(done.stdout.splitlines(), delimiter=",", skiprows=1))
    scale = np.abs(rows[1]).max(axis=0)
    assert (np.abs(rows[0] - rows[1]) <= 1e-10 * scale + 1e-13).all(), text
